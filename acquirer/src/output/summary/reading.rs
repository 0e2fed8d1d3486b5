//! What was read from one stage, in figures.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{mean, rounded};
use crate::{
    output::tables::share,
    pipeline::{
        StageReading,
        dense::DenseLine,
        grid::{DecodedGrid, DropReason},
    },
};

/// What was read from one stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageFigures {
    /// Crossings of the projected grid.
    pub crossings_possible: usize,
    /// Crossings with a label.
    pub crossings_labelled: usize,
    /// Labelled of possible crossings, in percent.
    pub coverage_percent: f64,
    /// Vertices: four for each labelled crossing.
    pub vertices: usize,
    /// Mean confidence of the labels, 0 to 1; `None` without labels.
    pub mean_confidence: Option<f64>,
    /// Crossings found and dropped, for each reason by its name.
    pub dropped: BTreeMap<&'static str, usize>,
    /// All dropped crossings.
    pub dropped_total: usize,
    /// Points along decoded lines.
    pub line_points: usize,
}

impl StageFigures {
    pub(in crate::output) fn of(
        reading: &StageReading,
        lines: &[DenseLine],
        possible: usize,
    ) -> Self {
        let grid: &DecodedGrid = &reading.grid;
        let labelled = grid.crossings.len();
        let confidences: Vec<f64> = grid.crossings.iter().map(|c| share(c.confidence)).collect();
        let by_reason = grid.dropped_by_reason();
        Self {
            crossings_possible: possible,
            crossings_labelled: labelled,
            coverage_percent: rounded(100.0 * labelled as f64 / possible.max(1) as f64),
            vertices: 4 * labelled,
            mean_confidence: mean(&confidences).map(rounded),
            dropped: by_reason
                .map(|(reason, count)| (DropReason::name(reason), count))
                .into(),
            dropped_total: grid.dropped.len(),
            line_points: lines.iter().map(|line| line.points.len()).sum(),
        }
    }
}
