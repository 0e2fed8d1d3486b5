//! The table `vertices.csv` of a scan's results.

use std::path::Path;

use acquirer::score::ReadVertex;
use anyhow::{Context, bail, ensure};
use shared::{
    geometry::CameraPixel,
    pattern::{Corner, GridIndex},
    stage::Stage,
};

/// The header that the table must have.
const HEADER: &str = "stage,row,column,vertex,x_px,y_px,confidence";

/// Reads the vertices of one stage from a results folder.
///
/// # Errors
/// A table that can't be read, has another header, or has a line with a word, number or confidence that can't be.
pub fn read_vertices(results: &Path, stage: Stage) -> anyhow::Result<Vec<ReadVertex>> {
    let path = results.join("vertices.csv");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let mut lines = text.lines().enumerate();
    let header = lines.next().map(|(_, line)| line);
    ensure!(header == Some(HEADER), "{}: {header:?}", path.display());
    let mut vertices = Vec::new();
    for (k, line) in lines {
        let place = || format!("{}:{}", path.display(), k + 1);
        let (own, vertex) = vertex(line).with_context(place)?;
        if own == stage.name() {
            vertices.push(vertex);
        }
    }
    Ok(vertices)
}

fn vertex(line: &str) -> anyhow::Result<(&str, ReadVertex)> {
    let fields: Vec<&str> = line.split(',').collect();
    let &[stage, row, column, corner, x, y, confidence] = fields.as_slice() else {
        bail!("{} columns instead of 7", fields.len());
    };
    let known = Stage::BOTH.map(Stage::name);
    ensure!(known.contains(&stage), "stage {stage:?}");
    let confidence: f64 = confidence.parse()?;
    ensure!((0.0..=1.0).contains(&confidence), "confidence {confidence}");
    let index = GridIndex {
        row: row.parse()?,
        column: column.parse()?,
    };
    let at = CameraPixel::new(x.parse()?, y.parse()?);
    Ok((stage, (index, corner_named(corner)?, at)))
}

/// The corner of a word in a table.
///
/// # Errors
/// A word that is none of the four.
pub(crate) fn corner_named(word: &str) -> anyhow::Result<Corner> {
    let mut corners = Corner::ALL.into_iter();
    let corner = corners.find(|corner| corner.name() == word);
    corner.with_context(|| format!("vertex {word:?}"))
}
