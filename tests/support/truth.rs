//! Truth tables of recorded scenes: `truth.csv`.

use std::path::Path;

use anyhow::{Context, bail};
use nalgebra::Vector3;
use shared::{geometry::CameraPixel, pattern::GridIndex, simulation::TruthVertex, stage::Stage};

use crate::vertices::corner_named;

/// Reads a `truth.csv`: stage, row, column, vertex, x_px, y_px, x_mm, y_mm, z_mm, clear, pitch_px.
///
/// # Errors
/// A file that can't be read, or a line that does not have these columns.
pub fn read_truth(path: &Path) -> anyhow::Result<Vec<TruthVertex>> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let lines = text.lines().enumerate().skip(1);
    lines
        .map(|(k, line)| vertex(line).with_context(|| format!("{}:{}", path.display(), k + 1)))
        .collect()
}

fn vertex(line: &str) -> anyhow::Result<TruthVertex> {
    let fields: Vec<&str> = line.split(',').collect();
    let &[
        stage,
        row,
        column,
        corner,
        x,
        y,
        x_mm,
        y_mm,
        z_mm,
        clear,
        pitch,
    ] = fields.as_slice()
    else {
        bail!("{} columns instead of 11", fields.len());
    };
    Ok(TruthVertex {
        stage: if stage == "object" {
            Stage::Object
        } else {
            Stage::Background
        },
        index: GridIndex {
            row: row.parse()?,
            column: column.parse()?,
        },
        corner: corner_named(corner)?,
        camera: CameraPixel::new(x.parse()?, y.parse()?),
        point_mm: Vector3::new(x_mm.parse()?, y_mm.parse()?, z_mm.parse()?),
        clear: clear == "1",
        pitch_px: if pitch.is_empty() {
            12.0
        } else {
            pitch.parse()?
        },
    })
}
