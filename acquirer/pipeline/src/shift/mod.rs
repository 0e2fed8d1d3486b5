//! How far each vertex moved between the background and the object: the thesis's relative depth.
//!
//! Takes the decoded grids of both stages, gives one [`Shift`] for each vertex read in both. The shift is
//! the distance in camera pixels between the two places; depth is the shift times a factor of the rig
//! (thesis, chapter 4.6 and Appendix C). A label that is wrong in one stage gives a wrong shift quietly, unless
//! it moved across the epipolar direction (`epipolar`): then it is marked (`lines`, which also shifts all points
//! of the lines).

pub mod epipolar;
pub mod lines;

use serde::{Deserialize, Serialize};
use shared::{
    geometry::CameraPixel,
    pattern::{Corner, GridIndex},
};

use super::grid::DecodedGrid;

/// Relative depth for one camera pixel of shift: the factor of Appendix C
/// (9.43 = 0.6633 x sqrt(202)). It has no unit; a calibrated rig gives millimetres instead.
pub const THESIS_DEPTH_PER_PX: f64 = 0.6633;

/// How shifts become relative depth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShiftSettings {
    /// Relative depth for one camera pixel of shift.
    pub depth_per_px: f64,
}

impl Default for ShiftSettings {
    fn default() -> Self {
        Self {
            depth_per_px: THESIS_DEPTH_PER_PX,
        }
    }
}

/// One vertex seen in both stages.
#[derive(Debug, Clone, PartialEq)]
pub struct Shift {
    /// Row and column of the crossing.
    pub index: GridIndex,
    /// Which of its vertices.
    pub corner: Corner,
    /// Where it stands without the object.
    pub before: CameraPixel,
    /// Where it stands with the object.
    pub after: CameraPixel,
    /// Distance between the two, in camera pixels.
    pub shift_px: f64,
    /// Relative depth: shift times the rig's factor.
    pub depth: f64,
}

/// Compares the two stages vertex by vertex; sorted by corner, row, column as in Appendix C.
#[must_use]
pub fn find_shifts(
    background: &DecodedGrid,
    object: &DecodedGrid,
    depth_per_px: f64,
) -> Vec<Shift> {
    let mut shifts = Vec::new();
    for (k, corner) in Corner::ALL.into_iter().enumerate() {
        for after in &object.crossings {
            let Some(before) = background.crossing(after.index) else {
                continue;
            };
            let (p, q) = (before.vertices[k], after.vertices[k]);
            let shift_px = (q.x - p.x).hypot(q.y - p.y);
            shifts.push(Shift {
                index: after.index,
                corner,
                before: p,
                after: q,
                shift_px,
                depth: shift_px * depth_per_px,
            });
        }
    }
    shifts
}
