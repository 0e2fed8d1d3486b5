//! From positions in space to positions on the drawing: parallel projection, so that equal lengths stay equal.
//!
//! # Conventions
//! The room's axes are x to the right, y down, z away from the viewer, as in the camera's frame.

use super::Axes;

/// From where the surface is looked at, relative to the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    /// How far the viewer went round to the right, in radians.
    pub yaw_rad: f64,
    /// How far the viewer went up, in radians.
    pub pitch_rad: f64,
}

impl Default for Viewpoint {
    /// A little to the right and above: sides and tops of things show, and little hides behind them.
    fn default() -> Self {
        Self {
            yaw_rad: 0.5,
            pitch_rad: 0.38,
        }
    }
}

/// Takes data to the drawing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Projection {
    /// Middle of the data, and what one unit of data is in the room, for each axis.
    middle: [f64; 3],
    factor: [f64; 3],
    /// Rows: to the right, down, away, as seen by the viewer.
    turn: [[f64; 3]; 3],
    px_per_unit: f64,
    centre_px: [f64; 2],
}

impl Projection {
    /// The projection that fits the box of the axes into a frame (left, top, width, height in px).
    pub(super) fn fitting(axes: &Axes, from: Viewpoint, frame: [f64; 4]) -> Self {
        let ((sy, cy), (sp, cp)) = (from.yaw_rad.sin_cos(), from.pitch_rad.sin_cos());
        let [left, top, width, height] = frame;
        let mut projection = Self {
            middle: axes.0.each_ref().map(|axis| (axis.low + axis.high) / 2.0),
            factor: axes.0.each_ref().map(|axis| axis.factor),
            turn: [
                [cy, 0.0, sy],
                [sy * sp, cp, -cy * sp],
                [-sy * cp, sp, cy * cp],
            ],
            px_per_unit: 1.0,
            centre_px: [left + width / 2.0, top + height / 2.0],
        };
        let corners = axes.corners();
        let reach = |k: usize| {
            let centre = projection.centre_px[k];
            let offsets = corners.map(|p| (projection.place(p)[k] - centre).abs());
            offsets.into_iter().fold(f64::MIN_POSITIVE, f64::max)
        };
        projection.px_per_unit = (width / 2.0 / reach(0)).min(height / 2.0 / reach(1));
        projection
    }

    /// Where data stands in the room, as seen by the viewer: right, down, away; in the room's unit.
    pub(super) fn turned(&self, data: [f64; 3]) -> [f64; 3] {
        let room = [0, 1, 2].map(|k| (data[k] - self.middle[k]) * self.factor[k]);
        self.turn
            .map(|row| row.iter().zip(room).map(|(a, b)| a * b).sum())
    }

    /// Position on the drawing in px, and the distance from the viewer in px.
    pub(super) fn place(&self, data: [f64; 3]) -> [f64; 3] {
        let [right, down, away] = self.turned(data);
        [
            self.centre_px[0] + right * self.px_per_unit,
            self.centre_px[1] + down * self.px_per_unit,
            away * self.px_per_unit,
        ]
    }
}
