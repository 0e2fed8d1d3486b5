//! How large the projector's pixels are in the camera's picture, measured on a decoded grid.
//!
//! Takes labelled crossings, gives the median over neighbours on one line of their distance in camera px over the
//! grid's pitch in projector px. A grid seen at very different distances is finer in places than this says.

use shared::{
    geometry::CameraPixel,
    pattern::{Axis, CameraScale, Grid, RasterSize},
};

use super::ends::beside;
use crate::grid::DecodedGrid;

/// Fewest pairs of neighbours for a median to be trusted.
const FEWEST: usize = 4;

/// The measured scale; `None` with too few neighbouring crossings in one of the directions.
#[must_use]
pub fn measured_scale(
    grid: &DecodedGrid,
    pattern: &Grid,
    raster: RasterSize,
) -> Option<CameraScale> {
    let scale = |across: Axis| {
        // neighbours on a row are a pitch of the columns apart
        let along = match across {
            Axis::Row => Axis::Column,
            Axis::Column => Axis::Row,
        };
        let apart = |a: CameraPixel, b: CameraPixel| (a.x - b.x).hypot(a.y - b.y);
        let pairs = grid.crossings.iter().filter_map(|crossing| {
            let next = grid.crossing(beside(crossing.index, along, 1)?)?;
            Some(apart(crossing.centre, next.centre))
        });
        let mut gaps: Vec<f64> = pairs.collect();
        gaps.sort_by(f64::total_cmp);
        let median = gaps.get(gaps.len() / 2).filter(|_| gaps.len() >= FEWEST)?;
        Some(median / pattern.pitch_px(across, raster))
    };
    Some(CameraScale {
        rows: scale(Axis::Row)?,
        columns: scale(Axis::Column)?,
    })
}
