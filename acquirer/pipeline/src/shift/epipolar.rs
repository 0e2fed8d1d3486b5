//! The epipolar direction at a place of the camera picture: where a lit point moves when only its depth changes.
//!
//! With a calibration it is the picture of the projector's ray, exactly. Without, all such directions pass through
//! one point, the picture of the projector (the epipole), which the vertices' shifts tell: homogeneous least squares
//! over the lines through each vertex's two places, weighted to distances in px and against outliers (R. Hartley and
//! A. Zisserman, "Multiple View Geometry", 2004, chapter 9). When the shifts don't tell the epipole from a common
//! direction, the common direction is taken. Lens distortion bends the lines; without a calibration that is an error
//! across of a few hundredths of the shift in the corners, quietly.

use nalgebra::{Matrix3, Vector3};
use serde::Serialize;
use shared::geometry::{CameraPixel, RigCalibration};

use super::Shift;

/// Shifts shorter than this say nothing about the direction, camera px.
pub(super) const MOVED_PX: f64 = 1.0;
/// Fewest vertices that moved.
const FEWEST: usize = 8;
/// Rounds of reweighting.
const ROUNDS: usize = 20;
/// The epipole is believed when it makes the robust sum of squares smaller by this factor.
const BETTER: f64 = 0.8;
/// A point on the projector's ray is moved by this share of its distance.
const STEP: f64 = 0.01;
/// Distance for the calibrated direction, mm; it is the same at all distances.
const ANY_MM: f64 = 1000.0;
/// Scale of picture coordinates in the fit, px.
const SCALE_PX: f64 = 500.0;

/// Where the directions come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DirectionSource {
    /// The rig's calibration.
    Calibration,
    /// The vertices' shifts.
    Shifts,
}

/// The epipolar directions of a camera picture.
#[derive(Debug, Clone, Copy)]
pub enum Epipolar<'a> {
    /// From a calibration.
    Rig(&'a RigCalibration),
    /// Towards a point of the picture, homogeneous and scaled; the sign is that of nearer surfaces.
    Pole(Vector3<f64>),
}

impl Epipolar<'_> {
    /// Where they come from.
    #[must_use]
    pub fn source(&self) -> DirectionSource {
        match self {
            Self::Rig(_) => DirectionSource::Calibration,
            Self::Pole(_) => DirectionSource::Shifts,
        }
    }

    /// The unit direction in which a lit point moves when its surface comes nearer.
    #[must_use]
    pub fn direction(&self, at: CameraPixel) -> Option<[f64; 2]> {
        let [x, y] = match self {
            Self::Rig(rig) => {
                let point = rig.camera_ray(at)?.at(ANY_MM);
                let projector = rig.projector_from_camera.inverse().translation_mm;
                let nearer = rig.camera_pixel(&(point + (projector - point) * STEP))?;
                [nearer.x - at.x, nearer.y - at.y]
            }
            Self::Pole(pole) => {
                let [x, y] = scaled(at);
                [pole.x - pole.z * x, pole.y - pole.z * y]
            }
        };
        let length = x.hypot(y);
        (length > 1e-12).then(|| [x / length, y / length])
    }

    /// A displacement's parts along and across the direction at its middle, px.
    #[must_use]
    pub fn split(&self, before: CameraPixel, after: CameraPixel) -> Option<[f64; 2]> {
        let [dx, dy] = self.direction(middle(before, after))?;
        let (x, y) = (after.x - before.x, after.y - before.y);
        Some([x * dx + y * dy, x * dy - y * dx])
    }
}

/// The directions that shifts tell; `None` when too few vertices moved.
#[must_use]
pub fn from_shifts(shifts: &[Shift]) -> Option<Epipolar<'static>> {
    let moved: Vec<&Shift> = shifts
        .iter()
        .filter(|s| s.shift_px.is_finite() && s.shift_px > MOVED_PX)
        .collect();
    if moved.len() < FEWEST {
        return None;
    }
    let (pole, free) = fit(&moved, false)?;
    let (common, fixed) = fit(&moved, true)?;
    let pole = if free < BETTER * fixed { pole } else { common };
    let mut along: Vec<f64> = moved
        .iter()
        .filter_map(|s| Some(Epipolar::Pole(pole).split(s.before, s.after)?[0]))
        .collect();
    along.sort_by(f64::total_cmp);
    let nearer = along.get(along.len() / 2).copied()?;
    Some(Epipolar::Pole(if nearer < 0.0 { -pole } else { pole }))
}

/// The epipole nearest to all lines, at infinity if asked, and the robust sum of squared distances.
fn fit(moved: &[&Shift], at_infinity: bool) -> Option<(Vector3<f64>, f64)> {
    let lines: Vec<Vector3<f64>> = moved
        .iter()
        .map(|s| homogeneous(s.before).cross(&homogeneous(s.after)))
        .collect();
    let mut weights = vec![1.0; lines.len()];
    let mut found = (Vector3::zeros(), f64::MAX);
    for _ in 0..ROUNDS {
        let mut sum = Matrix3::zeros();
        for (line, weight) in lines.iter().zip(&weights) {
            sum += *weight * line * line.transpose();
        }
        if at_infinity {
            for k in 0..3 {
                (sum[(2, k)], sum[(k, 2)]) = (0.0, 0.0);
            }
            sum[(2, 2)] = 2.0 * sum.trace();
        }
        let eigen = sum.symmetric_eigen();
        let pole: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into();
        let across: Vec<f64> = moved
            .iter()
            .map(|s| Epipolar::Pole(pole).split(s.before, s.after))
            .map(|split| split.map_or(f64::MAX, |[_, across]| across.abs()))
            .collect();
        let sigma = robust_sigma(&across)?.max(1e-6);
        let cut = |a: f64| (a / sigma).min(3.0);
        found = (pole, across.iter().map(|&a| (sigma * cut(a)).powi(2)).sum());
        for ((weight, shift), across) in weights.iter_mut().zip(moved).zip(&across) {
            let [x, y] = scaled(middle(shift.before, shift.after));
            let reach = (pole.x - pole.z * x).hypot(pole.y - pole.z * y).max(1e-9);
            *weight = if *across > 3.0 * sigma {
                0.0
            } else {
                reach.powi(-2)
            };
        }
    }
    pole_is_finite(&found.0).then_some(found)
}

fn pole_is_finite(pole: &Vector3<f64>) -> bool {
    pole.iter().all(|v| v.is_finite())
}

/// Standard deviation from the median of absolute values (0.6745 of it for a normal distribution).
pub(super) fn robust_sigma(absolute: &[f64]) -> Option<f64> {
    let mut sorted = absolute.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).map(|median| median / 0.6745)
}

fn middle(a: CameraPixel, b: CameraPixel) -> CameraPixel {
    CameraPixel::new(0.5 * (a.x + b.x), 0.5 * (a.y + b.y))
}

fn scaled(at: CameraPixel) -> [f64; 2] {
    [at.x / SCALE_PX, at.y / SCALE_PX]
}

fn homogeneous(at: CameraPixel) -> Vector3<f64> {
    let [x, y] = scaled(at);
    Vector3::new(x, y, 1.0)
}
