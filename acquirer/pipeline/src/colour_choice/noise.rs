//! The camera's noise law: variance = read + shot x light, per channel, in linear light (1 is full scale).
//!
//! Takes repeated frames of one picture; half the squared difference of two repeats is a sample of the
//! variance, and a line through the samples, binned by light, is the law. Without repeats a common webcam's
//! law is taken. Source: European Machine Vision Association, standard 1288 (photon transfer).

use image::RgbImage;

use super::{
    samples::{CLIPPED, linear},
    thin::ThinTrial,
};

/// Bins of light between black and full scale.
const BINS: usize = 16;
/// Least variance: that of rounding to a byte, at medium light.
const READ_FLOOR: f64 = 1.4e-6;
/// Least growth of the variance with light.
const SHOT_FLOOR: f64 = 1e-6;

/// How uncertain a light is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NoiseLaw {
    /// Variance without light.
    pub read: f64,
    /// Variance per unit of light.
    pub shot: f64,
    /// Whether it was measured on this trial's frames.
    pub measured: bool,
}

impl NoiseLaw {
    /// A webcam in a lit room: about 1.5 steps of a byte at medium light.
    pub(super) const COMMON: Self = Self {
        read: 4e-6,
        shot: 1.5e-4,
        measured: false,
    };

    pub(super) fn new(trial: &ThinTrial) -> Self {
        let mut bins = [(0.0, 0.0, 0.0); BINS];
        for frames in [&trial.black, &trial.white] {
            for pair in frames.windows(2) {
                add_pair(&mut bins, &pair[0], &pair[1]);
            }
        }
        fit(&bins).unwrap_or(Self::COMMON)
    }

    /// Variance of one channel of one pixel.
    pub(super) fn variance(self, light: f32) -> f32 {
        (self.read + self.shot * f64::from(light.max(0.0))) as f32
    }
}

/// Adds the samples of two repeats: count, sum of light, sum of variance.
fn add_pair(bins: &mut [(f64, f64, f64); BINS], a: &RgbImage, b: &RgbImage) {
    for (&p, &q) in a.as_raw().iter().zip(b.as_raw()) {
        // a clipped byte does not fluctuate
        if p.max(q) >= CLIPPED {
            continue;
        }
        let (p, q) = (f64::from(linear(p)), f64::from(linear(q)));
        let light = (p + q) / 2.0;
        let bin = &mut bins[((light * BINS as f64) as usize).min(BINS - 1)];
        bin.0 += 1.0;
        bin.1 += light;
        bin.2 += (p - q) * (p - q) / 2.0;
    }
}

/// The line through the bins' means, each weighted by its share of the samples over its squared variance.
fn fit(bins: &[(f64, f64, f64); BINS]) -> Option<NoiseLaw> {
    let (mut w, mut wx, mut wy, mut wxx, mut wxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for &(count, light, variance) in bins.iter().filter(|bin| bin.0 >= 30.0) {
        let (x, y) = (light / count, variance / count);
        let weight = count / (y + READ_FLOOR).powi(2);
        w += weight;
        wx += weight * x;
        wy += weight * y;
        wxx += weight * x * x;
        wxy += weight * x * y;
    }
    if w == 0.0 {
        return None;
    }
    let spread = wxx - wx * wx / w;
    let slope = if spread > 1e-9 * wxx {
        ((wxy - wx * wy / w) / spread).max(SHOT_FLOOR)
    } else {
        SHOT_FLOOR
    };
    Some(NoiseLaw {
        read: ((wy - slope * wx) / w).max(READ_FLOOR),
        shot: slope,
        measured: true,
    })
}
