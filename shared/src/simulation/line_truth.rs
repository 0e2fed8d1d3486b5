//! What is true of the lines of a simulated scan: where each place of each line falls, if the camera sees it.
//!
//! Takes a grid, gives the middles of its lines sampled every projector pixel: only places that the projector
//! lights (nothing in the way, inside its raster) and that the camera sees (nothing in the way, inside its
//! frame), through both lenses' distortion, without noise or blur. A surface too dark to be read counts too.

use nalgebra::Vector3;

use super::space::Space;
use crate::{
    geometry::{CameraPixel, ProjectorPixel},
    pattern::{Axis, Grid, RasterSize},
};

/// A place on the middle of a line that projector and camera both see.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineSample {
    /// Which way the line runs.
    pub axis: Axis,
    /// Which line of the grid, from 0.
    pub line: u16,
    /// How far along the line, on the grid's raster, edge coordinates.
    pub along_px: f64,
    /// Where the camera sees it.
    pub camera: CameraPixel,
    /// The point, mm, camera frame.
    pub point_mm: Vector3<f64>,
}

impl Space {
    /// The middles of all lines of the grid, every projector pixel, where projector and camera both see them;
    /// rows first, then by line, then along it.
    ///
    /// `size` is that of the raster that the grid was drawn on; another size than the projector's is stretched.
    #[must_use]
    pub fn line_truth(&self, grid: &Grid, size: RasterSize) -> Vec<LineSample> {
        let mut samples = Vec::new();
        for axis in Axis::BOTH {
            let length = match axis {
                Axis::Row => size.width,
                Axis::Column => size.height,
            };
            for line in (0..grid.lines(axis)).filter_map(|k| u16::try_from(k).ok()) {
                let across_px = grid.line(axis, line.into(), size).centre_px();
                let along = (0..length).map(|k| f64::from(k) + 0.5);
                samples.extend(
                    along.filter_map(|at| self.line_sample((axis, line), (across_px, at), size)),
                );
            }
        }
        samples
    }

    fn line_sample(
        &self,
        (axis, line): (Axis, u16),
        (across_px, along_px): (f64, f64),
        size: RasterSize,
    ) -> Option<LineSample> {
        let lens = &self.rig.projector;
        let scale_x = f64::from(lens.width) / f64::from(size.width.max(1));
        let scale_y = f64::from(lens.height) / f64::from(size.height.max(1));
        let at = match axis {
            Axis::Row => ProjectorPixel::new(along_px * scale_x, across_px * scale_y),
            Axis::Column => ProjectorPixel::new(across_px * scale_x, along_px * scale_y),
        };
        let hit = self.lit_place(at).filter(|_| lens.contains(at.x, at.y))?;
        Some(LineSample {
            axis,
            line,
            along_px,
            camera: self.seen_at(&hit)?,
            point_mm: self.in_camera(&hit.point),
        })
    }
}
