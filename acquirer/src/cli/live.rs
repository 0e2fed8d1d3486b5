//! `acquirer live`: reads frame after frame and prints one line for each.

use std::{
    io::{ErrorKind, Write},
    num::{NonZeroU8, NonZeroUsize},
    ops::ControlFlow,
};

use super::{
    args::{CalibrationArgs, RigArgs},
    console::Console,
    rig::{make_ready, open_rig},
};
use crate::session::{
    Cancel, LiveFrame, LiveMode, LiveSettings, grid_warnings, projected, read_live,
};

/// `acquirer live`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acquirer live --camera /dev/video0
  acquirer live --camera /dev/video0 --json | tee frames.jsonl
  acquirer live --camera sim:cylinder --mode tracking --refresh 60 --frames 300
  acquirer live --camera /dev/video0 --mode static --average 8

A line tells: the frame's number, its time, what it shows (coded, unary, black, white, other, mixed), crossings with a
label, milliseconds, and how many crossings have no label and why. Only frames that show the mode's grid are read.")]
pub(super) struct LiveArgs {
    /// Which rig.
    #[command(flatten)]
    pub rig: RigArgs,
    /// How frames are read.
    #[arg(long, value_enum, default_value = "dynamic")]
    pub mode: LiveModeArg,
    /// End after so many lines.
    #[arg(long, value_name = "N")]
    pub frames: Option<u64>,
    /// Coded frames that are averaged with --mode static, 1 to 255.
    #[arg(long, value_name = "N", default_value = "4")]
    pub average: NonZeroU8,
    /// Frames between two looks at the coded grid with --mode tracking.
    #[arg(long, value_name = "N", default_value = "60")]
    pub refresh: NonZeroUsize,
    /// The rig's calibration: labels are checked against its epipolar lines.
    #[command(flatten)]
    pub calibration: CalibrationArgs,
    /// One JSON object per line on standard output.
    #[arg(long)]
    pub json: bool,
}

/// `--mode`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum LiveModeArg {
    /// Nothing moves: the newest coded frames are averaged, the unary grid gives the geometry.
    Static,
    /// Things move: the coded grid stays up, every frame is read by itself.
    Dynamic,
    /// Things move slowly: the unary grid stays up, labels are carried on, the coded grid is shown now and then.
    Tracking,
}

impl From<LiveModeArg> for LiveMode {
    fn from(mode: LiveModeArg) -> Self {
        match mode {
            LiveModeArg::Static => Self::Static,
            LiveModeArg::Dynamic => Self::Dynamic,
            LiveModeArg::Tracking => Self::Tracking,
        }
    }
}

pub(super) fn run(args: &LiveArgs, cancel: &Cancel) -> anyhow::Result<()> {
    let mut config = args.rig.config.load()?;
    config.exposure.set |= args.rig.camera_settings.expose;
    let calibration = args.calibration.load()?;
    let mut rig = open_rig(&args.rig, &config)?;
    let mut console = Console::new();
    let projected = projected(&rig)?;
    for warning in grid_warnings(&rig, &projected) {
        console.say(&format!("warning: {warning}"));
    }
    make_ready(&mut rig, &config, cancel, &mut console)?;
    let settings = LiveSettings {
        mode: args.mode.into(),
        average: args.average.get().into(),
        refresh: args.refresh.get(),
        check_latency_every: config.latency.check_every(),
        record: config.record,
        pipeline: config.pipeline,
    };
    let (mut left, mut broken) = (args.frames, None);
    let scene = (&projected, calibration.as_ref());
    read_live(&mut rig, scene, &settings, cancel, &mut |seen| {
        if let Err(error) = print(seen.told, args.json) {
            broken = Some(error);
            return ControlFlow::Break(());
        }
        if let Some(left) = &mut left {
            *left = left.saturating_sub(1);
            if *left == 0 {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    })?;
    match broken {
        // whoever read the lines has had enough
        Some(error) if error.kind() != ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

fn print(frame: &LiveFrame, json: bool) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    if json {
        serde_json::to_writer(&mut out, frame)?;
        writeln!(out)?;
    } else {
        let reasons = frame.reasons.iter();
        let reasons = reasons.map(|(reason, count)| format!("  {reason} {count}"));
        writeln!(
            out,
            "{:>8} {:>12.3} s  {:<6} {:>5} crossings {:>7.1} ms{}",
            frame.frame,
            frame.time_s,
            frame.pattern,
            frame.crossings,
            frame.ms,
            reasons.collect::<String>()
        )?;
    }
    out.flush()
}
