//! How far vertices and line points moved between the stages, in figures.

use serde::Serialize;

use super::{mean, rounded};
use crate::pipeline::{result::ScanResult, shift::epipolar::DirectionSource};

/// How far the vertices moved between the stages, in camera pixels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShiftFigures {
    /// Vertices read in both stages.
    pub vertices: usize,
    /// Crossings read in both stages.
    pub crossings: usize,
    /// Relative depth for one pixel of shift.
    pub depth_per_px: f64,
    /// Smallest shift.
    pub smallest_px: f64,
    /// Half of the vertices moved less.
    pub median_px: f64,
    /// Mean shift.
    pub mean_px: f64,
    /// Largest shift.
    pub largest_px: f64,
}

impl ShiftFigures {
    pub(super) fn of(result: &ScanResult) -> Option<Self> {
        let mut shifts: Vec<f64> = result.shifts.iter().map(|s| s.shift_px).collect();
        shifts.retain(|shift| shift.is_finite());
        shifts.sort_by(f64::total_cmp);
        let mut crossings: Vec<_> = result.shifts.iter().map(|s| s.index).collect();
        crossings.sort_unstable();
        crossings.dedup();
        Some(Self {
            vertices: shifts.len(),
            crossings: crossings.len(),
            depth_per_px: result.depth_per_px,
            smallest_px: rounded(*shifts.first()?),
            median_px: rounded(shifts[shifts.len() / 2]),
            mean_px: rounded(mean(&shifts)?),
            largest_px: rounded(*shifts.last()?),
        })
    }
}

/// What moved along the epipolar direction, in camera pixels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LineShiftFigures {
    /// Where the direction comes from.
    pub direction: DirectionSource,
    /// Line points with a shift.
    pub points: usize,
    /// Line points without: the line runs along the epipolar direction.
    pub along_epipolar: usize,
    /// Line points without: not read where they should be in the background.
    pub not_in_background: usize,
    /// Vertices that moved by more than a pixel.
    pub moved_vertices: usize,
    /// Root mean square of their shifts across the direction, which is error only; `None` when none moved.
    pub across_rms_px: Option<f64>,
    /// Vertices whose error is more than three standard deviations.
    pub rejected_vertices: usize,
}

impl LineShiftFigures {
    pub(super) fn of(result: &ScanResult) -> Option<Self> {
        let found = &result.line_shifts;
        Some(Self {
            direction: found.source?,
            points: found.points.len(),
            along_epipolar: found.along_epipolar,
            not_in_background: found.not_in_background,
            moved_vertices: found.across.map_or(0, |a| a.moved),
            across_rms_px: found.across.map(|a| rounded(a.rms_px)),
            rejected_vertices: found.across.map_or(0, |a| a.rejected),
        })
    }
}
