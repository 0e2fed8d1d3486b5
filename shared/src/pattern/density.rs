//! Whether a camera can resolve a grid: width and pitch of its lines in camera pixels.
//!
//! Source of the limits: lines need about two samples across to be found and about eight from one to the next for
//! their colours to be told apart (own measurements on simulated pictures). The scale is a measured one, or the
//! guess that the projector's raster just fills the camera's picture; a raster that fills less of it is resolved
//! worse than the guess says, quietly.

use super::{Axis, Grid, RasterSize};

/// Least width of a line, camera px.
pub const LEAST_WIDTH_PX: f64 = 2.0;
/// Least distance from one line to the next, camera px.
pub const LEAST_PITCH_PX: f64 = 8.0;
/// The numbers of lines that a coded grid may have.
pub const LINE_COUNTS: [usize; 5] = [15, 31, 63, 127, 255];

/// Camera pixels that one projector pixel covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraScale {
    /// Across rows: down the raster.
    pub rows: f64,
    /// Across columns: along the raster's width.
    pub columns: f64,
}

impl CameraScale {
    /// The guess that the raster just fills the picture.
    #[must_use]
    pub fn filling(raster: RasterSize, camera: RasterSize) -> Self {
        let scale = |axis| f64::from(camera.along(axis)) / f64::from(raster.along(axis).max(1));
        Self {
            rows: scale(Axis::Row),
            columns: scale(Axis::Column),
        }
    }

    /// The scale across the lines of one direction.
    #[must_use]
    pub fn across(self, axis: Axis) -> f64 {
        match axis {
            Axis::Row => self.rows,
            Axis::Column => self.columns,
        }
    }

    /// The largest number of lines of [`LINE_COUNTS`] that the camera resolves; `None` when even 15 are too many.
    #[must_use]
    pub fn most_lines(self, axis: Axis, raster: RasterSize) -> Option<usize> {
        let length_px = f64::from(raster.along(axis)) * self.across(axis);
        let resolved = |n: &usize| length_px / *n as f64 >= LEAST_PITCH_PX;
        LINE_COUNTS.into_iter().rev().find(resolved)
    }
}

impl Grid {
    /// What the camera can't resolve of this grid, with what it could. Empty when all is well.
    #[must_use]
    pub fn camera_warnings(&self, raster: RasterSize, scale: CameraScale) -> Vec<String> {
        Axis::BOTH
            .into_iter()
            .flat_map(|axis| {
                [
                    self.pitch_warning(axis, raster, scale),
                    self.width_warning(axis, scale),
                ]
            })
            .flatten()
            .collect()
    }

    fn pitch_warning(&self, axis: Axis, raster: RasterSize, scale: CameraScale) -> Option<String> {
        let pitch_px = self.pitch_px(axis, raster) * scale.across(axis);
        let (lines, name) = (self.lines(axis), name(axis));
        let advice = match scale.most_lines(axis, raster) {
            Some(most) => format!("at most {most} {name} would work"),
            None => format!(
                "not even {} {name} would work: move the camera nearer",
                LINE_COUNTS[0]
            ),
        };
        (pitch_px < LEAST_PITCH_PX).then(|| {
            format!(
                "{lines} {name} are too many for the camera: {pitch_px:.1} camera px from one to the next, \
                 {LEAST_PITCH_PX:.0} are needed; {advice}"
            )
        })
    }

    fn width_warning(&self, axis: Axis, scale: CameraScale) -> Option<String> {
        let across = scale.across(axis);
        let width_px = f64::from(self.width_px(axis)) * across;
        let name = name(axis);
        (width_px < LEAST_WIDTH_PX && across > 0.0).then(|| {
            format!(
                "{name} are too thin for the camera: {width_px:.1} camera px, {LEAST_WIDTH_PX:.0} are needed; \
                 a width of {:.0} projector px or more would work",
                (LEAST_WIDTH_PX / across).ceil()
            )
        })
    }
}

fn name(axis: Axis) -> &'static str {
    match axis {
        Axis::Row => "rows",
        Axis::Column => "columns",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::GridSettings;

    const XGA: RasterSize = RasterSize {
        width: 1024,
        height: 768,
    };
    const VGA: RasterSize = RasterSize {
        width: 640,
        height: 480,
    };

    fn warnings(lines: usize, width_px: u32, scale: CameraScale) -> Vec<String> {
        let colours = GridSettings::default().coded.colours().to_vec();
        let grid = Grid::coded(lines, lines, width_px, width_px, &colours).unwrap();
        grid.camera_warnings(XGA, scale)
    }

    #[test]
    fn a_grid_that_the_camera_resolves_gives_no_warning() {
        let scale = CameraScale::filling(XGA, VGA);
        assert!(warnings(15, 6, scale).is_empty());
    }

    #[test]
    fn too_many_lines_are_named_with_the_number_that_would_work() {
        let found = warnings(127, 4, CameraScale::filling(XGA, VGA));
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].contains("at most 31 rows"), "{}", found[0]);
        assert!(found[1].contains("at most 63 columns"), "{}", found[1]);
    }

    #[test]
    fn thin_lines_and_a_far_camera_are_named() {
        let far = CameraScale {
            rows: 0.1,
            columns: 0.625,
        };
        let found = warnings(15, 3, far);
        assert!(found[0].contains("not even 15 rows"), "{found:?}");
        assert!(found[1].contains("20 projector px or more"), "{found:?}");
        assert!(found[2].contains("columns are too thin"), "{found:?}");
    }
}
