//! What is true of a simulated scan: where each vertex of the grid really falls, and whether it can be seen.
//!
//! Takes a grid, gives one entry per vertex that the projector lights and the camera sees, through both lenses'
//! distortion, without noise or blur.

use std::{fmt, io};

use nalgebra::Vector3;

use super::{solid::Hit, space::Space};
use crate::{
    geometry::{CameraPixel, Plane, ProjectorPixel},
    pattern::{Axis, Corner, Grid, GridIndex, RasterSize},
    stage::Stage,
};

/// Rounding of positions, mm.
const ROUNDING_MM: f64 = 0.01;

/// A crossing's surroundings reach along its lines from the middle by this share of the pitch: nearly half-way to the
/// next ones, so that the outermost lines of a raster have theirs.
const SURROUNDINGS: f64 = 0.45;

/// A crossing's surroundings are looked at on a lattice of about this spacing, projector px.
const LATTICE_PX: f64 = 2.0;

/// Two neighbouring places lie on an unbroken surface when their normals differ by less than this, as a cosine:
/// 25 degrees, so a cylinder is whole and the edge of a box is not.
const UNBROKEN_COSINE: f64 = 0.906;

/// ... and neither is further off the other's tangent plane than this share of their distance.
const UNBROKEN_STEP: f64 = 0.5;

/// A clear crossing's surroundings keep this distance from the border of the picture, px.
const BORDER_PX: f64 = 2.0;

/// The true place of one vertex of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruthVertex {
    /// In which stage.
    pub stage: Stage,
    /// Which crossing.
    pub index: GridIndex,
    /// Which of its four vertices.
    pub corner: Corner,
    /// Where the camera sees it.
    pub camera: CameraPixel,
    /// The point, mm, camera frame.
    pub point_mm: Vector3<f64>,
    /// Whether both lines are whole around the crossing, nearly half-way to their neighbours: lit and seen everywhere, on
    /// one unbroken surface.
    pub clear: bool,
    /// Distance to the next line of the grid on the same surface, px: the smaller of the two directions.
    pub pitch_px: f64,
}

impl Space {
    /// Every vertex of the grid that the projector lights and the camera sees.
    ///
    /// `size` is that of the raster that the grid was drawn on; a raster of another size than the projector's is
    /// stretched over it.
    #[must_use]
    pub fn truth(&self, grid: &Grid, size: RasterSize) -> Vec<TruthVertex> {
        let crossings =
            (0..grid.rows()).flat_map(|row| (0..grid.columns()).map(move |column| (row, column)));
        crossings
            .filter_map(|(row, column)| {
                Some(GridIndex {
                    row: u16::try_from(row).ok()?,
                    column: u16::try_from(column).ok()?,
                })
            })
            .flat_map(|index| self.crossing(grid, index, size))
            .collect()
    }

    fn crossing(&self, grid: &Grid, index: GridIndex, size: RasterSize) -> Vec<TruthVertex> {
        let lens = &self.rig.projector;
        let scale_x = f64::from(lens.width) / f64::from(size.width.max(1));
        let scale_y = f64::from(lens.height) / f64::from(size.height.max(1));
        let native = |at: ProjectorPixel| ProjectorPixel::new(at.x * scale_x, at.y * scale_y);
        let low = native(grid.vertex(index, Corner::UpperLeft, size));
        let high = native(grid.vertex(index, Corner::LowerRight, size));
        let pitch_x = grid.pitch_px(Axis::Column, size) * scale_x;
        let pitch_y = grid.pitch_px(Axis::Row, size) * scale_y;
        let clear = self.is_clear(low, high, (pitch_x, pitch_y));
        let vertex = |corner| {
            let at = native(grid.vertex(index, corner, size));
            let hit = self.lit_place(at).filter(|_| lens.contains(at.x, at.y))?;
            let camera = self.seen_at(&hit)?;
            let x = self.stretch_px(&hit, at, camera, (1.0, 0.0)) * pitch_x;
            let y = self.stretch_px(&hit, at, camera, (0.0, 1.0)) * pitch_y;
            let point_mm = self.in_camera(&hit.point);
            Some(TruthVertex {
                stage: self.stage,
                index,
                corner,
                camera,
                point_mm,
                clear,
                pitch_px: x.min(y),
            })
        };
        Corner::ALL.into_iter().filter_map(vertex).collect()
    }

    /// How many camera px one projector px covers at a place, along a direction on the projector.
    fn stretch_px(
        &self,
        hit: &Hit,
        at: ProjectorPixel,
        camera: CameraPixel,
        (dx, dy): (f64, f64),
    ) -> f64 {
        let beside = ProjectorPixel::new(at.x + dx, at.y + dy);
        let on_tangent = self.rig.projector_ray(beside).and_then(|ray| {
            let normal = self.direction_in_camera(&hit.normal);
            let point = self.in_camera(&hit.point);
            let plane = Plane {
                normal,
                offset_mm: normal.dot(&point),
            };
            self.rig.camera_pixel(&ray.meet_plane(&plane)?)
        });
        on_tangent.map_or(0.0, |there| (there.x - camera.x).hypot(there.y - camera.y))
    }

    /// Whether both lines are whole around their crossing, nearly half-way to the next lines: lit, seen, unbroken.
    fn is_clear(&self, low: ProjectorPixel, high: ProjectorPixel, pitch: (f64, f64)) -> bool {
        let beyond = |pitch: f64, width: f64| (SURROUNDINGS * pitch - width / 2.0).max(0.0);
        let (dx, dy) = (
            beyond(pitch.0, high.x - low.x),
            beyond(pitch.1, high.y - low.y),
        );
        let row = [(low.x - dx, high.x + dx), (low.y, high.y)];
        let column = [(low.x, high.x), (low.y - dy, high.y + dy)];
        self.is_whole(row) && self.is_whole(column)
    }

    /// Whether a rectangle of light, from and to along x and y (projector px), falls on one smooth surface and is
    /// seen everywhere.
    fn is_whole(&self, [across, down]: [(f64, f64); 2]) -> bool {
        let steps = |(from, to): (f64, f64)| ((to - from) / LATTICE_PX).ceil().clamp(1.0, 1000.0);
        let (columns, rows) = (steps(across), steps(down));
        let at =
            |(from, to): (f64, f64), k: usize, steps: f64| from + (to - from) * k as f64 / steps;
        let mut above: Vec<Hit> = Vec::new();
        for row in 0..=rows as usize {
            let y = at(down, row, rows);
            let line = (0..=columns as usize).map(|k| self.clear_place(at(across, k, columns), y));
            let Some(line) = line.collect::<Option<Vec<Hit>>>() else {
                return false;
            };
            let beside = line.iter().zip(line.iter().skip(1));
            if !beside
                .chain(line.iter().zip(&above))
                .all(|(a, b)| is_unbroken(a, b))
            {
                return false;
            }
            above = line;
        }
        true
    }

    /// What a projector position lights, if the camera sees it too.
    fn clear_place(&self, x: f64, y: f64) -> Option<Hit> {
        let hit = self.lit_place(ProjectorPixel::new(x, y))?;
        let lit = self.rig.projector.contains(x, y);
        (lit && self.is_inside(self.seen_at(&hit)?)).then_some(hit)
    }

    fn is_inside(&self, at: CameraPixel) -> bool {
        let lens = &self.rig.camera;
        let from_border = |v: f64, length: u32| v.min(f64::from(length) - v);
        from_border(at.x, lens.width) >= BORDER_PX && from_border(at.y, lens.height) >= BORDER_PX
    }
}

/// Whether two neighbouring places lie on one smooth surface.
fn is_unbroken(a: &Hit, b: &Hit) -> bool {
    let step = b.point - a.point;
    let off = a.normal.dot(&step).abs().max(b.normal.dot(&step).abs());
    a.normal.dot(&b.normal) > UNBROKEN_COSINE && off <= UNBROKEN_STEP * step.norm() + ROUNDING_MM
}

/// Writes truth as the table `truth.csv`: one line per vertex, camera px in edge coordinates, mm in the camera frame.
///
/// # Errors
/// When writing fails.
pub fn write_truth_csv(truth: &[TruthVertex], mut to: impl io::Write) -> io::Result<()> {
    writeln!(
        to,
        "stage,row,column,vertex,x_px,y_px,x_mm,y_mm,z_mm,clear,pitch_px"
    )?;
    truth.iter().try_for_each(|vertex| writeln!(to, "{vertex}"))
}

impl fmt::Display for TruthVertex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let GridIndex { row, column } = self.index;
        let (px, mm) = (self.camera, self.point_mm);
        write!(
            f,
            "{},{row},{column},{},{:.3},{:.3},",
            self.stage, self.corner, px.x, px.y
        )?;
        write!(
            f,
            "{:.3},{:.3},{:.3},{},{:.1}",
            mm.x,
            mm.y,
            mm.z,
            u8::from(self.clear),
            self.pitch_px
        )
    }
}
