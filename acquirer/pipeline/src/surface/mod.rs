//! Points of the surface in millimetres, from labelled vertices and lines and a calibrated rig.
//!
//! Takes one stage's reading and the calibration. A vertex's place on the projector is known exactly, so
//! its point is the one on the projector's ray that the camera would see nearest to the vertex: only the
//! part of the error along the epipolar line reaches the depth. A point of a line is where the camera ray
//! meets the line's plane of light; lines nearly along the epipolar direction carry no depth and are left
//! out, the others' confidence is weighted by the squared sine of the angle. What is left out is counted by reason;
//! a vertex more than three pixels off its epipolar line is wrong and left out too. A calibration of another rig
//! or another camera size gives wrong points quietly.

pub mod difference;

use std::collections::BTreeMap;

use nalgebra::Vector3;
use shared::{
    geometry::{CameraPixel, ProjectorPixel, RigCalibration},
    pattern::{Axis, Corner},
};

use super::{
    Captures, Projected, StageReading,
    dense::{DenseLine, find_dense_lines},
    grid::DecodedCrossing,
    shift::{
        epipolar::Epipolar,
        lines::{LEAST_SINE, sine},
    },
};

/// A point of the surface, in the camera frame: x right, y down, z forward.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePoint {
    /// Row of the pattern it lies on, if any.
    pub row: Option<u16>,
    /// Column of the pattern it lies on, if any.
    pub column: Option<u16>,
    /// The vertex it is, or `None` for a point along a line.
    pub corner: Option<Corner>,
    /// Position in millimetres.
    pub position_mm: [f64; 3],
    /// Colour of the surface there, as the camera sees it under white light.
    pub colour: [u8; 3],
    /// Probability that the label is right, 0 to 1.
    pub confidence: f64,
}

/// Largest distance of a vertex from its epipolar line, camera px.
const OFF_EPIPOLAR_PX: f64 = 3.0;

/// Why a vertex or a line point gave no point of the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SurfaceDrop {
    /// Its line runs along the epipolar direction: no depth.
    AlongEpipolar,
    /// It lies off its epipolar line: a wrong label or place.
    OffEpipolar,
    /// Its line's light is not projected there: outside of the raster.
    OutsideRaster,
    /// Its rays don't meet before the camera.
    NoMeeting,
}

impl SurfaceDrop {
    /// The name in result files, for example `along_epipolar`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::AlongEpipolar => "along_epipolar",
            Self::OffEpipolar => "off_epipolar",
            Self::OutsideRaster => "outside_raster",
            Self::NoMeeting => "no_meeting",
        }
    }
}

/// A point of the surface and where on its line it lies.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// The point.
    pub point: SurfacePoint,
    /// How far along its line its light leaves the projector, edge coordinates; 0 for a vertex.
    pub along_px: f64,
    /// Which unbroken piece of a line it lies on.
    pub piece: usize,
    /// Which point of that piece it is.
    pub step: usize,
}

/// The surface of one stage.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surface {
    /// All vertices, then the points along the lines.
    pub points: Vec<Placed>,
    /// How many vertices and line points were left out, by reason.
    pub dropped: BTreeMap<SurfaceDrop, usize>,
}

/// The points of the surface of one stage: all vertices, then the points along the lines.
#[must_use]
pub fn find_surface(
    reading: &StageReading,
    captures: &Captures,
    projected: &Projected,
    calibration: &RigCalibration,
) -> Vec<SurfacePoint> {
    let lines = find_dense_lines(&reading.grid);
    let surface = read_surface((reading, &lines), captures, projected, calibration);
    surface.points.into_iter().map(|p| p.point).collect()
}

/// As [`find_surface`], from lines that are already dense, with places and what was dropped.
#[must_use]
pub fn read_surface(
    (reading, lines): (&StageReading, &[DenseLine]),
    captures: &Captures,
    projected: &Projected,
    calibration: &RigCalibration,
) -> Surface {
    let scene = Scene {
        captures,
        projected,
        calibration,
    };
    let mut surface = Surface::default();
    for crossing in &reading.grid.crossings {
        scene.vertices(crossing, &mut surface);
    }
    for (piece, line) in lines.iter().enumerate() {
        for step in 0..line.points.len() {
            match scene.line_point(line, step) {
                Ok((along_px, point)) => surface.points.push(Placed {
                    point,
                    along_px,
                    piece,
                    step,
                }),
                Err(reason) => *surface.dropped.entry(reason).or_default() += 1,
            }
        }
    }
    surface
}

struct Scene<'a> {
    captures: &'a Captures,
    projected: &'a Projected,
    calibration: &'a RigCalibration,
}

impl Scene<'_> {
    fn vertices(&self, crossing: &DecodedCrossing, surface: &mut Surface) {
        for (corner, seen) in Corner::ALL.into_iter().zip(crossing.vertices) {
            match self.vertex(crossing, corner, seen) {
                Ok(point) => surface.points.push(Placed {
                    point,
                    along_px: 0.0,
                    piece: usize::MAX,
                    step: 0,
                }),
                Err(reason) => *surface.dropped.entry(reason).or_default() += 1,
            }
        }
    }

    fn vertex(
        &self,
        crossing: &DecodedCrossing,
        corner: Corner,
        seen: CameraPixel,
    ) -> Result<SurfacePoint, SurfaceDrop> {
        let grid = &self.projected.pattern.coded;
        let from = grid.vertex(crossing.index, corner, self.projected.raster);
        let point = nearest_on_ray(self.calibration, seen, from).ok_or(SurfaceDrop::NoMeeting)?;
        let back = self.calibration.camera_pixel(&point);
        let off = back.map_or(f64::MAX, |b| (b.x - seen.x).hypot(b.y - seen.y));
        if off > OFF_EPIPOLAR_PX {
            return Err(SurfaceDrop::OffEpipolar);
        }
        Ok(SurfacePoint {
            row: Some(crossing.index.row),
            column: Some(crossing.index.column),
            corner: Some(corner),
            position_mm: point.into(),
            colour: self.colour(seen),
            confidence: crossing.confidence,
        })
    }

    /// A line's point and how far along the line its light leaves the projector, px.
    fn line_point(&self, line: &DenseLine, k: usize) -> Result<(f64, SurfacePoint), SurfaceDrop> {
        let (axis, raster) = (line.axis, self.projected.raster);
        let grid = &self.projected.pattern.coded;
        let at = grid.line(axis, line.line.into(), raster).centre_px();
        let seen = line.points[k].position;
        let direction = Epipolar::Rig(self.calibration).direction(seen);
        let sine = sine(line, k, direction.ok_or(SurfaceDrop::NoMeeting)?);
        if sine < LEAST_SINE {
            return Err(SurfaceDrop::AlongEpipolar);
        }
        let found = match axis {
            Axis::Row => self.calibration.point_on_row(seen, at),
            Axis::Column => self.calibration.point_on_column(seen, at),
        };
        let point = found
            .filter(|p| p.iter().all(|v| v.is_finite()))
            .ok_or(SurfaceDrop::NoMeeting)?;
        let from = self.calibration.projector_pixel(&point);
        let from = from.ok_or(SurfaceDrop::NoMeeting)?;
        let (along, length) = match axis {
            Axis::Row => (from.x, raster.width),
            Axis::Column => (from.y, raster.height),
        };
        // a pixel for blur
        if !(-1.0..=f64::from(length) + 1.0).contains(&along) {
            return Err(SurfaceDrop::OutsideRaster);
        }
        let point = SurfacePoint {
            row: (axis == Axis::Row).then_some(line.line),
            column: (axis == Axis::Column).then_some(line.line),
            corner: None,
            position_mm: point.into(),
            colour: self.colour(seen),
            confidence: line.points[k].confidence * sine * sine,
        };
        Ok((along, point))
    }

    fn colour(&self, at: CameraPixel) -> [u8; 3] {
        let shown = self.captures.white.first().or(self.captures.prmvs.first());
        let inside = |picture: &&image::RgbImage| {
            at.x >= 0.0
                && at.y >= 0.0
                && at.x < f64::from(picture.width())
                && at.y < f64::from(picture.height())
        };
        shown.filter(inside).map_or([128; 3], |picture| {
            picture.get_pixel(at.x as u32, at.y as u32).0
        })
    }
}

/// The point on the projector's ray that the camera sees nearest to `seen`.
fn nearest_on_ray(
    calibration: &RigCalibration,
    seen: CameraPixel,
    from: ProjectorPixel,
) -> Option<Vector3<f64>> {
    const ROUNDS: usize = 10;
    let ray = calibration.projector_ray(from)?;
    let mut distance =
        (calibration.triangulate(seen, from)?.point - ray.origin).dot(&ray.direction);
    for _ in 0..ROUNDS {
        let step = 1e-4 * distance;
        let here = calibration.camera_pixel(&ray.at(distance))?;
        let there = calibration.camera_pixel(&ray.at(distance + step))?;
        let (dx, dy) = ((there.x - here.x) / step, (there.y - here.y) / step);
        let slope = dx * dx + dy * dy;
        let change = ((seen.x - here.x) * dx + (seen.y - here.y) * dy) / slope;
        if !change.is_finite() {
            return None;
        }
        distance += change;
        if change.abs() < 1e-6 {
            break;
        }
    }
    let point = ray.at(distance);
    (distance > 0.0 && point.z > 0.0 && point.iter().all(|v| v.is_finite())).then_some(point)
}
