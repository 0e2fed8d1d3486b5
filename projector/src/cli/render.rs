//! `projector render`: a pattern as a picture file.

use std::{fs, path::Path};

use anyhow::{Context, bail};
use serde_json::Value;
use shared::pattern::{Grid, GridSettings, Pattern};

use super::RenderArgs;

pub(super) const FORMS: &str = r##"FILE is one of
  a pattern    {"kind": "solid", "colour": "#8000ff"}
               {"kind": "ramp"}
               {"kind": "test_card"}    focus and keystone
               {"kind": "identify", "label": "A"}
               {"kind": "grid", ...} with the keys of a grid
  a grid       {"rows": 15, "columns": 15,
                "row_width_px": 6, "column_width_px": 6,
                "colours": ["#ff0000", "#ffff00", "#ff00ff", "#00ff00"]}
               with 4 colours PRMVS, with 2 PRBCS, with 1 unary; with
               "row_symbols" and "column_symbols" (for every line the number
               of its colour, from 0) any code in up to 16 colours
  a recording  scan.json; its "pattern" is drawn
or the same in TOML, as config/pattern.toml.

Example:
  projector render --pattern scan-001/scan.json --size 1024x768 grid.png"##;

pub(super) fn run(args: &RenderArgs) -> anyhow::Result<()> {
    let path = args.pattern.display();
    let pattern = read(&args.pattern, args.unary).with_context(|| format!("cannot draw {path}"))?;
    let raster = pattern.raster(args.size);
    let out = args.out.display();
    image::save_buffer_with_format(
        &args.out,
        raster.bytes(),
        args.size.width,
        args.size.height,
        image::ExtendedColorType::Rgb8,
        image::ImageFormat::Png,
    )
    .with_context(|| format!("cannot write {out}"))
}

fn read(path: &Path, unary: bool) -> anyhow::Result<Pattern> {
    let text = fs::read_to_string(path)?;
    let is_toml = path
        .extension()
        .is_some_and(|extension| extension == "toml");
    let value: Value = if is_toml {
        toml::from_str(&text)?
    } else {
        serde_json::from_str(&text)?
    };
    pattern(value, unary)
}

fn pattern(value: Value, unary: bool) -> anyhow::Result<Pattern> {
    let value = match value.get("pattern") {
        Some(inner) => inner.clone(),
        None => value,
    };
    if unary {
        let settings: GridSettings = serde_json::from_value(value)
            .context("a unary picture needs a grid with a unary colour")?;
        return Ok(settings.unary_grid().into());
    }
    if value.get("kind").is_some() {
        return Ok(serde_json::from_value(value)?);
    }
    if value.get("colours").is_none() {
        bail!(
            "it has neither \"kind\" nor \"colours\" nor \"pattern\": see projector render --help"
        );
    }
    Ok(serde_json::from_value::<Grid>(value)?.into())
}
