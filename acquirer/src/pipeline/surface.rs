//! Points of the surface in millimetres, from labelled vertices and lines and a calibrated rig.
//!
//! Takes the object's reading and the calibration. A vertex's place on the projector is known exactly, so
//! its point is the one on the projector's ray that the camera would see nearest to the vertex: only the
//! part of the error along the epipolar line reaches the depth. A point of a line is where the camera ray
//! meets the line's plane of light; lines nearly along the epipolar direction carry no depth and are left
//! out, the others' confidence is weighted by the squared sine of the angle. A calibration of another rig
//! or another camera size gives wrong points quietly.

use nalgebra::Vector3;
use shared::{
    geometry::{CameraPixel, ProjectorPixel, RigCalibration},
    pattern::{Axis, Corner},
};

use super::{
    Captures, Projected, StageReading,
    grid::{DecodedCrossing, LineTrack},
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

/// Smallest sine of the angle between a line and the epipolar direction for the line's points to count
/// (30 degrees): below it the depth error more than doubles.
const LEAST_SINE: f64 = 0.5;

/// The surface of the object: all vertices, then the points along the lines.
#[must_use]
pub fn find_surface(
    object: &StageReading,
    captures: &Captures,
    projected: &Projected,
    calibration: &RigCalibration,
) -> Vec<SurfacePoint> {
    let scene = Scene {
        captures,
        projected,
        calibration,
    };
    let crossings = object.grid.crossings.iter();
    let mut points: Vec<SurfacePoint> = crossings
        .flat_map(|crossing| scene.vertices(crossing))
        .collect();
    points.extend(
        object
            .grid
            .tracks
            .iter()
            .flat_map(|track| scene.line(track)),
    );
    points
}

struct Scene<'a> {
    captures: &'a Captures,
    projected: &'a Projected,
    calibration: &'a RigCalibration,
}

impl Scene<'_> {
    fn vertices(&self, crossing: &DecodedCrossing) -> Vec<SurfacePoint> {
        let grid = &self.projected.pattern.coded;
        let corners = Corner::ALL.into_iter().zip(crossing.vertices);
        corners
            .filter_map(|(corner, seen)| {
                let from = grid.vertex(crossing.index, corner, self.projected.raster);
                let point = nearest_on_ray(self.calibration, seen, from)?;
                Some(SurfacePoint {
                    row: Some(crossing.index.row),
                    column: Some(crossing.index.column),
                    corner: Some(corner),
                    position_mm: point.into(),
                    colour: self.colour(seen),
                    confidence: crossing.confidence,
                })
            })
            .collect()
    }

    fn line(&self, track: &LineTrack) -> Vec<SurfacePoint> {
        let Some(line) = track.line else {
            return Vec::new();
        };
        let grid = &self.projected.pattern.coded;
        let at = grid
            .line(track.axis, usize::from(line), self.projected.raster)
            .centre_px();
        let seen = smooth(track);
        let mut points = Vec::new();
        for (k, (point, &seen)) in track.points.iter().zip(&seen).enumerate() {
            let (before, after) = (seen_at(track, k, -2), seen_at(track, k, 2));
            let found = match track.axis {
                Axis::Row => self.calibration.point_on_row(seen, at),
                Axis::Column => self.calibration.point_on_column(seen, at),
            };
            let Some(position) = found.filter(|p| p.iter().all(|v| v.is_finite())) else {
                continue;
            };
            let sine = self.sine_to_epipolar(&position, seen, before, after);
            if sine < LEAST_SINE {
                continue;
            }
            points.push(SurfacePoint {
                row: (track.axis == Axis::Row).then_some(line),
                column: (track.axis == Axis::Column).then_some(line),
                corner: None,
                position_mm: position.into(),
                colour: self.colour(seen),
                confidence: point.confidence * sine * sine,
            });
        }
        points
    }

    /// Sine of the angle in the picture between the line (from `before` to `after`) and the epipolar line
    /// through a point.
    fn sine_to_epipolar(
        &self,
        point: &Vector3<f64>,
        seen: CameraPixel,
        before: CameraPixel,
        after: CameraPixel,
    ) -> f64 {
        let from = self.calibration.projector_pixel(point);
        let ray = from.and_then(|from| self.calibration.projector_ray(from));
        let Some(ray) = ray else { return 0.0 };
        // a hundredth further on the projector's ray is a step along the epipolar line
        let further = point + ray.direction * (0.01 * point.norm());
        let Some(step) = self.calibration.camera_pixel(&further) else {
            return 0.0;
        };
        let (ex, ey) = (step.x - seen.x, step.y - seen.y);
        let (lx, ly) = (after.x - before.x, after.y - before.y);
        let length = ex.hypot(ey) * lx.hypot(ly);
        if length > 0.0 {
            (ex * ly - ey * lx).abs() / length
        } else {
            0.0
        }
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

fn seen_at(track: &LineTrack, k: usize, step: isize) -> CameraPixel {
    let at = k.saturating_add_signed(step).min(track.points.len() - 1);
    track.points[at].position
}

/// Points of a line, averaged across it over the neighbours on either side.
fn smooth(track: &LineTrack) -> Vec<CameraPixel> {
    const REACH: usize = 3;
    (0..track.points.len())
        .map(|k| {
            // the same number on both sides, so that the mean stays at the point
            let reach = REACH.min(k).min(track.points.len() - 1 - k);
            let near = &track.points[k - reach..=k + reach];
            let mean = |of: fn(&CameraPixel) -> f64| {
                near.iter().map(|p| of(&p.position)).sum::<f64>() / near.len() as f64
            };
            CameraPixel::new(mean(|p| p.x), mean(|p| p.y))
        })
        .collect()
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
