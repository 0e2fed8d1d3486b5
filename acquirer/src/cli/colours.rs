//! `acquirer colours`: picks the four colours on the scene.

use std::path::PathBuf;

use anyhow::Context;

use super::{
    args::RigArgs,
    console::Console,
    rig::{make_ready, open_rig},
};
use crate::{
    pipeline::{Projected, colour_choice::ColourSelection},
    session::{
        Cancel, ColourTrialOrder, Rig, apply_selection, grid_warnings, projected, try_colours,
    },
};
use shared::pattern::{Palette, Rgb};

/// `acquirer colours`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acquirer colours --camera sim:coloured-room
  acquirer colours --projector 192.168.0.7:4460 --camera /dev/video0 --json --keep")]
pub(super) struct ColoursArgs {
    /// Which rig.
    #[command(flatten)]
    pub rig: RigArgs,
    /// Palette file of sixteen colours; the shipped one is config/palettes/sixteen.toml.
    #[arg(long, value_name = "FILE")]
    pub palette: Option<PathBuf>,
    /// Only tell the choice, leave the projector's colours as they are.
    #[arg(long)]
    pub keep: bool,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &ColoursArgs, cancel: &Cancel) -> anyhow::Result<()> {
    let mut config = args.rig.config.load()?;
    config.exposure.set |= args.rig.camera_settings.expose;
    let palette = match &args.palette {
        None => Palette::default(),
        Some(path) => {
            let text = std::fs::read_to_string(path)
                .with_context(|| format!("palette {}", path.display()))?;
            Palette::from_toml(&text).with_context(|| path.display().to_string())?
        }
    };
    let mut rig = open_rig(&args.rig, &config)?;
    let mut console = Console::new();
    for warning in grid_warnings(&rig, &projected(&rig)?) {
        console.say(&format!("warning: {warning}"));
    }
    make_ready(&mut rig, &config, cancel, &mut console)?;
    let selection = pick(&mut rig, &palette, !args.keep, cancel, &mut console)?;
    if args.json {
        println!("{}", serde_json::to_string(&selection)?);
    } else {
        print!("{}", text(&selection, &palette));
    }
    Ok(())
}

/// Tries all colours, chooses, and (if `apply`) sends the choice to the projector.
pub(super) fn pick(
    rig: &mut Rig,
    palette: &Palette,
    apply: bool,
    cancel: &Cancel,
    console: &mut Console,
) -> anyhow::Result<ColourSelection> {
    let now = projected(rig)?;
    let order = ColourTrialOrder {
        palette,
        projected: &now,
        current: current(&now),
    };
    let trial = try_colours(rig, &order, cancel, &mut |p| console.show(&p), None)?;
    if apply {
        apply_selection(rig, &trial.selection)?;
    }
    Ok(trial.selection)
}

/// The colours in use, when there are four.
fn current(projected: &Projected) -> Option<[Rgb; 4]> {
    projected.pattern.coded.colours().try_into().ok()
}

/// The choice for people: a table of the colours, the four, and why.
pub(super) fn text(selection: &ColourSelection, palette: &Palette) -> String {
    let mut text = format!("{:<14}{:>9}  {:>12}\n", "colour", "value", "recovered px");
    for entry in &selection.colours {
        let mark = match selection.best.iter().position(|&c| c == entry.colour) {
            Some(k) => format!("  colour {}", k + 1),
            None => String::new(),
        };
        let unary = if entry.colour == selection.unary {
            "  unary"
        } else {
            ""
        };
        text.push_str(&format!(
            "{:<14}{:>9}  {:>12}{mark}{unary}\n",
            entry.name,
            entry.colour.to_string(),
            entry.recovered_px
        ));
    }
    let names = selection
        .best
        .map(|colour| palette.name_of(colour))
        .join(", ");
    text.push_str(&format!(
        "best four: {names}; unary: {}\n",
        palette.name_of(selection.unary)
    ));
    for reason in &selection.reasons {
        text.push_str(&format!("  {reason}\n"));
    }
    text
}
