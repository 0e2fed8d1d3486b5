//! Whether labels agree with where they are seen.
//!
//! Takes labelled crossings, gives how far each is from its epipolar line: of the calibration if there is one, else of
//! a fundamental matrix fitted to the labels themselves by RANSAC (M. Fischler and R. Bolles 1981; R. Hartley's eight
//! points 1997; Sampson's distance). A wrong label that happens to slide along its epipolar line passes quietly. A
//! flat scene tells one matrix of many: what stands before it then seems to contradict, and is left out.

use bumpalo::{Bump, collections::Vec};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use shared::geometry::{CameraPixel, ProjectorPixel, RigCalibration};

use super::DecodeSettings;

/// Where a crossing is seen, and where it was projected from.
pub(super) type Match = (CameraPixel, ProjectorPixel);

/// What is known about where a projected point can be seen.
pub(super) enum Geometry<'a> {
    /// All of it.
    Rig(&'a RigCalibration, f64),
    /// What the labels tell.
    Labels(Epipolar),
    /// Nothing: too few labels.
    Unknown,
}

impl<'a> Geometry<'a> {
    /// That of the calibration, with the largest distance from an epipolar line in camera px.
    pub(super) fn of_rig(calibration: &'a RigCalibration, settings: &DecodeSettings) -> Self {
        Self::Rig(calibration, settings.epipolar_px)
    }

    /// That which the matches tell, to within `limit_px` camera px.
    pub(super) fn of_labels(matches: &[Match], limit_px: f64, bump: &Bump) -> Self {
        Epipolar::of(matches, limit_px, bump).map_or(Self::Unknown, Self::Labels)
    }

    /// Distance (Sampson) of a match from its epipolar line as a share of the largest that is allowed; `None` where
    /// the camera can't see it at all.
    pub(super) fn distance(&self, (camera, projector): Match) -> Option<f64> {
        match self {
            Self::Rig(rig, limit_px) => Some(rig.sampson_px(camera, projector)? / limit_px),
            Self::Labels(epipolar) => Some(epipolar.distance((camera, projector))),
            Self::Unknown => Some(0.0),
        }
    }

    /// Whether a match can't be right.
    pub(super) fn contradicts(&self, matched: Match) -> bool {
        self.distance(matched).is_none_or(|distance| distance > 1.0)
    }

    /// Whether positions tell anything.
    pub(super) fn is_known(&self) -> bool {
        !matches!(self, Self::Unknown)
    }
}

/// Matches that a fundamental matrix is fitted to.
const SAMPLE: usize = 8;
/// Most samples that are tried.
const MOST_ROUNDS: usize = 100;

/// The epipolar geometry that labels tell without a calibration.
#[derive(Debug)]
pub(super) struct Epipolar {
    fundamental: Matrix3<f64>,
    camera: Scaling,
    projector: Scaling,
    limit_px: f64,
}

impl Epipolar {
    /// The geometry that most matches agree with, to within `limit_px`; `None` with too few of them.
    fn of(matches: &[Match], limit_px: f64, bump: &Bump) -> Option<Self> {
        const FEWEST: usize = 20;
        if matches.len() < FEWEST {
            return None;
        }
        let points = Normalised::new(matches, bump);
        let fundamental = points.consensus(limit_px * points.camera_scaling.scale, bump)?;
        let mut found = Self {
            fundamental,
            camera: points.camera_scaling,
            projector: points.projector_scaling,
            limit_px,
        };
        let distances = matches.iter().map(|&m| found.distance(m));
        let mut distances = Vec::from_iter_in(distances, bump);
        let middle = distances.len() / 2;
        let (_, median, _) = distances.select_nth_unstable_by(middle, f64::total_cmp);
        // lens distortion is not in the model: what most labels share is not held against any of them
        found.limit_px *= (5.0 * *median).max(1.0);
        Some(found)
    }

    /// Sampson's distance from the epipolar line as a share of the limit.
    fn distance(&self, (camera, projector): Match) -> f64 {
        let camera_point = self.camera.point((camera.x, camera.y));
        let projector_point = self.projector.point((projector.x, projector.y));
        let distance = sampson(&self.fundamental, &camera_point, &projector_point);
        distance / (self.camera.scale * self.limit_px)
    }
}

fn next_random(state: &mut u64) -> usize {
    // xorshift64: the same sequence on every run and machine
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 33) as usize
}

/// Samples after which one without a wrong match has come with 99 % probability.
fn rounds_for(right_share: f64) -> usize {
    let all_right = right_share.powi(SAMPLE as i32).clamp(1e-6, 1.0 - 1e-6);
    let rounds = (0.01_f64.ln() / (1.0 - all_right).ln()).ceil();
    (rounds as usize).clamp(1, MOST_ROUNDS)
}

/// Matches shifted and scaled to about 1, for the eight-point algorithm.
struct Normalised<'a> {
    camera: Vec<'a, Vector3<f64>>,
    projector: Vec<'a, Vector3<f64>>,
    camera_scaling: Scaling,
    projector_scaling: Scaling,
}

impl<'a> Normalised<'a> {
    fn new(matches: &[Match], bump: &'a Bump) -> Self {
        let camera = matches.iter().map(|m| (m.0.x, m.0.y));
        let projector = matches.iter().map(|m| (m.1.x, m.1.y));
        let camera_scaling = Scaling::of(camera.clone());
        let projector_scaling = Scaling::of(projector.clone());
        Self {
            camera: Vec::from_iter_in(camera.map(|p| camera_scaling.point(p)), bump),
            projector: Vec::from_iter_in(projector.map(|p| projector_scaling.point(p)), bump),
            camera_scaling,
            projector_scaling,
        }
    }

    /// The matrix that most matches agree with, each fit drawn once more from all that agree with it (O. Chum,
    /// J. Matas and J. Kittler, "Locally optimized RANSAC", 2003): on nearly flat scenes eight matches seldom
    /// tell the whole geometry. Ends early when a better one is unlikely.
    fn consensus(&self, limit: f64, bump: &Bump) -> Option<Matrix3<f64>> {
        let count = self.camera.len();
        let mut random = 0x2545_f491_4f6c_dd1d_u64;
        let mut best: Option<(usize, Matrix3<f64>)> = None;
        let (mut round, mut rounds) = (0, MOST_ROUNDS);
        let mut agree = Vec::with_capacity_in(count, bump);
        let mut now = Vec::with_capacity_in(count, bump);
        while round < rounds {
            round += 1;
            let sample: [usize; SAMPLE] = std::array::from_fn(|_| next_random(&mut random) % count);
            let Some(mut f) = self.fundamental(sample.into_iter()) else {
                continue;
            };
            self.find_agreeing(&f, limit, &mut agree);
            if best
                .as_ref()
                .is_some_and(|(most, _)| agree.len() * 10 < most * 9)
            {
                continue;
            }
            for _ in 0..2 {
                if let Some(again) = self.fundamental(agree.iter().copied()) {
                    self.find_agreeing(&again, limit, &mut now);
                    if now.len() >= agree.len() {
                        f = again;
                        std::mem::swap(&mut agree, &mut now);
                    }
                }
            }
            if best.as_ref().is_none_or(|(most, _)| agree.len() > *most) {
                rounds = rounds_for(agree.len() as f64 / count as f64);
                best = Some((agree.len(), f));
            }
        }
        best.map(|(_, f)| f)
    }

    fn find_agreeing(&self, f: &Matrix3<f64>, limit: f64, agreeing: &mut Vec<'_, usize>) {
        agreeing.clear();
        let all = 0..self.camera.len();
        agreeing.extend(all.filter(|&k| self.sampson(f, k) < limit));
    }

    /// The sum that a fundamental matrix makes least.
    fn normal(&self, chosen: impl Iterator<Item = usize>) -> SMatrix<f64, 9, 9> {
        let mut normal = SMatrix::<f64, 9, 9>::zeros();
        for k in chosen {
            let (c, p) = (&self.camera[k], &self.projector[k]);
            let row = SVector::<f64, 9>::from_fn(|i, _| p[i / 3] * c[i % 3]);
            normal += row * row.transpose();
        }
        normal
    }

    fn fundamental(&self, chosen: impl Iterator<Item = usize>) -> Option<Matrix3<f64>> {
        let eigen = self.normal(chosen).symmetric_eigen();
        let (least, _) = eigen.eigenvalues.argmin();
        let f = Matrix3::from_row_slice(eigen.eigenvectors.column(least).as_slice());
        let mut svd = f.svd(true, true);
        let (smallest, _) = svd.singular_values.argmin();
        svd.singular_values[smallest] = 0.0;
        let f = svd.recompose().ok()?;
        f.iter().all(|v| v.is_finite()).then_some(f)
    }

    fn sampson(&self, f: &Matrix3<f64>, k: usize) -> f64 {
        sampson(f, &self.camera[k], &self.projector[k])
    }
}

/// Sampson's distance in the camera's coordinates.
fn sampson(f: &Matrix3<f64>, camera: &Vector3<f64>, projector: &Vector3<f64>) -> f64 {
    let (on_projector, on_camera) = (f * camera, f.transpose() * projector);
    let slope = on_projector.xy().norm_squared() + on_camera.xy().norm_squared();
    projector.dot(&on_projector).abs() / slope.sqrt().max(1e-12)
}

/// Shifts points to their mean and scales their mean distance from it to the root of 2.
#[derive(Debug, Clone, Copy)]
struct Scaling {
    middle: (f64, f64),
    scale: f64,
}

impl Scaling {
    fn of(points: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let n = points.clone().count().max(1) as f64;
        let (x, y) = points
            .clone()
            .fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
        let spread = points.map(|p| (p.0 - x).hypot(p.1 - y)).sum::<f64>() / n;
        Self {
            middle: (x, y),
            scale: std::f64::consts::SQRT_2 / spread.max(1e-9),
        }
    }

    fn point(&self, (x, y): (f64, f64)) -> Vector3<f64> {
        Vector3::new(
            (x - self.middle.0) * self.scale,
            (y - self.middle.1) * self.scale,
            1.0,
        )
    }
}
