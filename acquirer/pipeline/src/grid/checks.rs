//! Whether labels agree with where they are seen.
//!
//! Takes labelled crossings, gives those that contradict the epipolar geometry: of the calibration if there
//! is one, else of a fundamental matrix fitted to the labels themselves by RANSAC (M. Fischler and
//! R. Bolles 1981; R. Hartley's eight points 1997; Sampson's distance). A wrong label that happens to
//! slide along its epipolar line passes quietly.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use shared::geometry::{CameraPixel, ProjectorPixel, RigCalibration};

use super::DecodeSettings;

/// Where a crossing is seen, and where it was projected from.
pub(super) type Match = (CameraPixel, ProjectorPixel);

/// For each match whether it contradicts the calibration.
pub(super) fn against_calibration(
    matches: &[Match],
    calibration: &RigCalibration,
    settings: &DecodeSettings,
) -> Vec<bool> {
    let off = |&(camera, projector): &Match| {
        let distance = calibration.sampson_px(camera, projector);
        distance.is_none_or(|distance| distance > settings.epipolar_px)
    };
    matches.iter().map(off).collect()
}

/// Matches that a fundamental matrix is fitted to.
const SAMPLE: usize = 8;
/// Most samples that are tried.
const MOST_ROUNDS: usize = 100;

/// For each match whether it lies further than `limit_px` from the epipolar line that the others give. Without
/// enough of them none does.
pub(super) fn against_each_other(matches: &[Match], limit_px: f64) -> Vec<bool> {
    const FEWEST: usize = 20;
    if matches.len() < FEWEST {
        return vec![false; matches.len()];
    }
    let points = Normalised::new(matches);
    let limit = limit_px * points.camera_scale;
    let Some(f) = points.consensus(limit) else {
        return vec![false; matches.len()];
    };
    let distances: Vec<f64> = (0..matches.len()).map(|k| points.sampson(&f, k)).collect();
    let mut sorted = distances.clone();
    sorted.sort_by(f64::total_cmp);
    // lens distortion is not in the model: what most labels share is not held against any of them
    let limit = limit.max(5.0 * sorted[sorted.len() / 2]);
    distances.into_iter().map(|d| d > limit).collect()
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
struct Normalised {
    camera: Vec<Vector3<f64>>,
    projector: Vec<Vector3<f64>>,
    camera_scale: f64,
}

impl Normalised {
    fn new(matches: &[Match]) -> Self {
        let (camera, camera_scale) = normalise(matches.iter().map(|m| (m.0.x, m.0.y)));
        let (projector, _) = normalise(matches.iter().map(|m| (m.1.x, m.1.y)));
        Self {
            camera,
            projector,
            camera_scale,
        }
    }

    /// The matrix that most matches agree with, each fit drawn once more from all that agree with it (O. Chum,
    /// J. Matas and J. Kittler, "Locally optimized RANSAC", 2003): on nearly flat scenes eight matches seldom
    /// tell the whole geometry. Ends early when a better one is unlikely.
    fn consensus(&self, limit: f64) -> Option<Matrix3<f64>> {
        let count = self.camera.len();
        let mut random = 0x2545_f491_4f6c_dd1d_u64;
        let mut best: Option<(usize, Matrix3<f64>)> = None;
        let (mut round, mut rounds) = (0, MOST_ROUNDS);
        while round < rounds {
            round += 1;
            let sample: Vec<usize> = (0..SAMPLE)
                .map(|_| next_random(&mut random) % count)
                .collect();
            let Some(mut f) = self.fundamental(sample.into_iter()) else {
                continue;
            };
            let mut agree = self.agreeing(&f, limit);
            if best
                .as_ref()
                .is_some_and(|(most, _)| agree.len() * 10 < most * 9)
            {
                continue;
            }
            for _ in 0..2 {
                if let Some(again) = self.fundamental(agree.iter().copied()) {
                    let now = self.agreeing(&again, limit);
                    if now.len() >= agree.len() {
                        (f, agree) = (again, now);
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

    fn agreeing(&self, f: &Matrix3<f64>, limit: f64) -> Vec<usize> {
        let all = 0..self.camera.len();
        all.filter(|&k| self.sampson(f, k) < limit).collect()
    }

    fn fundamental(&self, chosen: impl Iterator<Item = usize>) -> Option<Matrix3<f64>> {
        let mut normal = SMatrix::<f64, 9, 9>::zeros();
        for k in chosen {
            let (c, p) = (&self.camera[k], &self.projector[k]);
            let row = SVector::<f64, 9>::from_fn(|i, _| p[i / 3] * c[i % 3]);
            normal += row * row.transpose();
        }
        let eigen = normal.symmetric_eigen();
        let (least, _) = eigen.eigenvalues.argmin();
        let f = Matrix3::from_row_slice(eigen.eigenvectors.column(least).as_slice());
        let mut svd = f.svd(true, true);
        let (smallest, _) = svd.singular_values.argmin();
        svd.singular_values[smallest] = 0.0;
        let f = svd.recompose().ok()?;
        f.iter().all(|v| v.is_finite()).then_some(f)
    }

    fn sampson(&self, f: &Matrix3<f64>, k: usize) -> f64 {
        let (c, p) = (&self.camera[k], &self.projector[k]);
        let (on_projector, on_camera) = (f * c, f.transpose() * p);
        let slope = on_projector.xy().norm_squared() + on_camera.xy().norm_squared();
        p.dot(&on_projector).abs() / slope.sqrt().max(1e-12)
    }
}

fn normalise(points: impl Iterator<Item = (f64, f64)> + Clone) -> (Vec<Vector3<f64>>, f64) {
    let n = points.clone().count().max(1) as f64;
    let (x, y) = points
        .clone()
        .fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    let spread = points
        .clone()
        .map(|p| (p.0 - x).hypot(p.1 - y))
        .sum::<f64>()
        / n;
    let scale = std::f64::consts::SQRT_2 / spread.max(1e-9);
    let scaled = points.map(|p| Vector3::new((p.0 - x) * scale, (p.1 - y) * scale, 1.0));
    (scaled.collect(), scale)
}
