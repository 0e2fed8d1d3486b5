//! How much the light of a steady picture swings, from frame to frame and down the rows of a frame.
//!
//! Takes the band means of frames of one picture, gives their swing as a share of the projector's white; a slow drift of
//! the whole picture is left out. Noise differs from band to band and a flicker hardly does, so the differences of
//! neighbouring bands tell the noise, which is taken off. It fails quietly when lamp and camera keep step for many
//! seconds: such bands stand still.

use std::f64::consts::TAU;

use super::{Light, light::BANDS};

/// Bands with less than this share of the brightest band's white are left out.
const LEAST_WHITE: f32 = 0.1;

/// Longest time from the first row's exposure to the last one's that is tried, in milliseconds.
const LONGEST_READOUT_MS: i32 = 40;

/// Deviations of the bands' light from steady, as shares of white.
pub(super) struct Modulation {
    /// For each frame and band: stamp in milliseconds, band, and red, green and blue's deviation.
    deviations: Vec<(f64, usize, [f64; 3])>,
}

impl Modulation {
    /// The deviations of a picture's frames, by the white that black and white differ by.
    pub(super) fn of(picture: &Light, black: &Light, white: &Light) -> Self {
        let levels = band_whites(black, white);
        let brightest = levels.iter().flatten().copied().fold(0.0, f32::max);
        let drifts = [0, 1, 2].map(|c| undrifted(picture, c));
        let mut deviations = Vec::new();
        for (band, level) in levels.iter().enumerate() {
            if level.iter().any(|level| *level < LEAST_WHITE * brightest) || brightest <= 0.0 {
                continue;
            }
            let channels: [Vec<f64>; 3] = std::array::from_fn(|c| {
                let values = picture.series.iter().zip(&drifts[c]);
                let values: Vec<f64> = values
                    .map(|(frame, drift)| f64::from(frame.bands[band][c]) * drift)
                    .collect();
                let level = mean(values.iter().copied());
                values.into_iter().map(|value| value - level).collect()
            });
            for (frame, means) in picture.series.iter().enumerate() {
                let deviation = std::array::from_fn(|c| channels[c][frame] / f64::from(level[c]));
                deviations.push((means.stamp_ms, band, deviation));
            }
        }
        Self { deviations }
    }

    /// Swing of the deviations' part along a direction of colour (three weights), noise taken off: the amplitude of a
    /// cosine of the same power.
    pub(super) fn swing(&self, weights: [f64; 3]) -> f64 {
        let along =
            |deviation: &[f64; 3]| -> f64 { (0..3).map(|c| weights[c] * deviation[c]).sum() };
        let values: Vec<(usize, f64, f64)> = self
            .deviations
            .iter()
            .map(|(stamp, band, deviation)| (*band, *stamp, along(deviation)))
            .collect();
        let power = mean(values.iter().map(|(_, _, value)| value * value));
        let mut sorted = values;
        sorted.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let neighbours = sorted
            .windows(2)
            .filter(|pair| pair[0].1 == pair[1].1 && pair[1].0 == pair[0].0 + 1);
        let noise = mean(neighbours.map(|pair| (pair[1].2 - pair[0].2).powi(2))) / 2.0;
        (2.0 * (power - noise).max(0.0)).sqrt()
    }

    /// The direction of colour along which the light swings most: weights whose squares sum to 1.
    pub(super) fn direction(&self) -> [f64; 3] {
        let mut products = nalgebra::Matrix3::zeros();
        for (_, _, deviation) in &self.deviations {
            let deviation = nalgebra::Vector3::from(*deviation);
            products += deviation * deviation.transpose();
        }
        let eigen = products.symmetric_eigen();
        let most = eigen.eigenvalues.imax();
        let direction = eigen.eigenvectors.column(most);
        [direction[0], direction[1], direction[2]]
    }

    /// Share of the power that a cosine of a frequency explains, 0 to 1, with whatever read-out explains most.
    pub(super) fn explained_by(&self, hz: f64) -> f64 {
        let readouts = (0..=LONGEST_READOUT_MS).map(f64::from);
        readouts
            .map(|readout_ms| self.explained(hz, readout_ms))
            .fold(0.0, f64::max)
    }

    fn explained(&self, hz: f64, readout_ms: f64) -> f64 {
        let (mut cc, mut ss, mut cs, mut cv, mut sv, mut vv) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (stamp_ms, band, deviation) in &self.deviations {
            let time_ms = stamp_ms + *band as f64 / BANDS as f64 * readout_ms;
            let (sine, cosine) = (TAU * hz * time_ms / 1000.0).sin_cos();
            let value = deviation.iter().sum::<f64>() / 3.0;
            cc += cosine * cosine;
            ss += sine * sine;
            cs += cosine * sine;
            cv += cosine * value;
            sv += sine * value;
            vv += value * value;
        }
        let determinant = cc * ss - cs * cs;
        if determinant.abs() < 1e-9 || vv <= 0.0 {
            return 0.0;
        }
        let (a, b) = (
            (cv * ss - sv * cs) / determinant,
            (sv * cc - cv * cs) / determinant,
        );
        ((a * cv + b * sv) / vv).clamp(0.0, 1.0)
    }
}

/// White minus black of each band.
fn band_whites(black: &Light, white: &Light) -> Vec<[f32; 3]> {
    let mean = |light: &Light, band: usize, c: usize| {
        let sum: f32 = light.series.iter().map(|frame| frame.bands[band][c]).sum();
        sum / light.series.len().max(1) as f32
    };
    (0..BANDS)
        .map(|band| std::array::from_fn(|c| mean(white, band, c) - mean(black, band, c)))
        .collect()
}

/// What each frame's light of a channel must be multiplied by so that the whole picture does not drift: a straight line
/// through time.
fn undrifted(picture: &Light, channel: usize) -> Vec<f64> {
    let values: Vec<f64> = picture
        .series
        .iter()
        .map(|frame| {
            let bands = frame.bands.iter().map(|band| f64::from(band[channel]));
            bands.sum::<f64>() / frame.bands.len().max(1) as f64
        })
        .collect();
    let count = values.len() as f64;
    let middle = (count - 1.0) / 2.0;
    let level = mean(values.iter().copied());
    let (mut rise, mut run) = (0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        rise += (k as f64 - middle) * (value - level);
        run += (k as f64 - middle).powi(2);
    }
    let slope = if run > 0.0 { rise / run } else { 0.0 };
    (0..values.len())
        .map(|k| {
            let line = level + slope * (k as f64 - middle);
            if line > 0.0 { level / line } else { 1.0 }
        })
        .collect()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value;
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { 0.0 }
}
