//! A camera's response as numbers: the linear light at evenly spaced byte values.
//!
//! Between them the curve is the sRGB curve (IEC 61966-2-1) plus a natural cubic spline through the knots'
//! differences from it, so that a camera that follows sRGB has exactly that table, and others a smooth one.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Byte values at which the light is given: 255 k / 16 for k = 0 to 16.
pub const KNOTS: usize = 17;
/// Distance of two knots, in byte values.
const STEP: f64 = 255.0 / (KNOTS - 1) as f64;

/// Linear light (0 to 1) of a byte of the sRGB curve.
pub(super) fn srgb(byte: f64) -> f64 {
    let value = byte / 255.0;
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

/// A camera's response: the linear light of the bytes 255 k / 16, from 0 to 1, rising.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "[f64; KNOTS]", into = "[f64; KNOTS]")]
pub struct ResponseCurve {
    light: [f64; KNOTS],
}

/// Numbers that are no response.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error(
    "a response curve starts at 0, rises from each of its 17 values to the next, and ends at 1"
)]
pub struct NoResponse;

impl TryFrom<[f64; KNOTS]> for ResponseCurve {
    type Error = NoResponse;

    fn try_from(light: [f64; KNOTS]) -> Result<Self, NoResponse> {
        let rises = light.windows(2).all(|pair| pair[0] < pair[1]);
        let ends = light[0] == 0.0 && (light[KNOTS - 1] - 1.0).abs() < 1e-9;
        (rises && ends).then_some(Self { light }).ok_or(NoResponse)
    }
}

impl From<ResponseCurve> for [f64; KNOTS] {
    fn from(curve: ResponseCurve) -> Self {
        curve.light
    }
}

impl ResponseCurve {
    /// The curve whose knots differ from sRGB's by these amounts of light, scaled to end at 1; `None` when it does not
    /// rise everywhere.
    pub(super) fn from_srgb_plus(differences: &[f64; KNOTS], splines: &Splines) -> Option<Self> {
        let table = splines.table(differences);
        let rises = table.windows(2).all(|pair| pair[0] < pair[1]);
        let scale = 1.0 / table[255];
        let light = std::array::from_fn(|k| scale * (srgb(STEP * k as f64) + differences[k]));
        rises.then(|| Self::try_from(light).ok()).flatten()
    }

    /// The sRGB curve.
    #[must_use]
    pub fn srgb() -> Self {
        Self {
            light: std::array::from_fn(|k| srgb(STEP * k as f64)),
        }
    }

    /// Linear light at the bytes 255 k / 16.
    #[must_use]
    pub fn knots(&self) -> [f64; KNOTS] {
        self.light
    }

    /// Linear light of every byte; never falling.
    #[must_use]
    pub fn table(&self) -> [f64; 256] {
        let differences = std::array::from_fn(|k| self.light[k] - srgb(STEP * k as f64));
        let mut table = Splines::new().table(&differences);
        for byte in 1..256 {
            // knots that somebody gave by hand can make the spline swing
            table[byte] = table[byte].clamp(table[byte - 1], 1.0);
        }
        table
    }
}

/// For each byte, how much the value at each knot weighs in the natural cubic spline through all of them.
pub(super) struct Splines {
    weights: Vec<[f64; KNOTS]>,
}

impl Splines {
    pub(super) fn new() -> Self {
        let mut weights = vec![[0.0; KNOTS]; 256];
        for k in 0..KNOTS {
            let mut values = [0.0; KNOTS];
            values[k] = 1.0;
            let bends = second_derivatives(&values);
            for (byte, weights) in weights.iter_mut().enumerate() {
                weights[k] = spline_at(&values, &bends, byte as f64 / STEP);
            }
        }
        Self { weights }
    }

    /// The weights at a byte value, 0 to 255, which may lie between two.
    pub(super) fn at(&self, byte: f64) -> [f64; KNOTS] {
        let low = (byte.max(0.0) as usize).min(254);
        let part = byte - low as f64;
        std::array::from_fn(|k| {
            let [a, b] = [low, low + 1].map(|byte| self.weights[byte][k]);
            a + part * (b - a)
        })
    }

    /// The sRGB table plus the spline.
    pub(super) fn table(&self, differences: &[f64; KNOTS]) -> [f64; 256] {
        std::array::from_fn(|byte| {
            let terms = self.weights[byte].iter().zip(differences);
            srgb(byte as f64) + terms.map(|(w, d)| w * d).sum::<f64>()
        })
    }
}

/// Second derivatives of the natural cubic spline through values one apart (the tridiagonal system, solved by
/// elimination).
fn second_derivatives(values: &[f64; KNOTS]) -> [f64; KNOTS] {
    let (mut diagonal, mut right) = ([1.0; KNOTS], [0.0; KNOTS]);
    for k in 1..KNOTS - 1 {
        let bend = 6.0 * (values[k + 1] - 2.0 * values[k] + values[k - 1]);
        let above = if k == 1 { 0.0 } else { 1.0 / diagonal[k - 1] };
        diagonal[k] = 4.0 - above;
        right[k] = bend - above * right[k - 1];
    }
    let mut bends = [0.0; KNOTS];
    for k in (1..KNOTS - 1).rev() {
        bends[k] = (right[k] - bends[k + 1]) / diagonal[k];
    }
    bends
}

fn spline_at(values: &[f64; KNOTS], bends: &[f64; KNOTS], at: f64) -> f64 {
    let k = (at as usize).min(KNOTS - 2);
    let (a, b) = (k as f64 + 1.0 - at, at - k as f64);
    a * values[k]
        + b * values[k + 1]
        + ((a * a * a - a) * bends[k] + (b * b * b - b) * bends[k + 1]) / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_knots_of_srgb_give_its_table() {
        let splines = Splines::new();
        let curve = ResponseCurve::from_srgb_plus(&[0.0; KNOTS], &splines).unwrap();
        let table = curve.table();
        for (byte, light) in table.into_iter().enumerate() {
            assert!((light - srgb(byte as f64)).abs() < 1e-12, "{byte}: {light}");
        }
    }

    #[test]
    fn the_knots_of_a_power_law_give_a_table_near_it() {
        let power = |byte: f64| (byte / 255.0).powf(1.5);
        let curve = ResponseCurve::try_from(std::array::from_fn(|k| power(STEP * k as f64)));
        for (byte, light) in curve.unwrap().table().into_iter().enumerate() {
            let error = light - power(byte as f64);
            assert!(error.abs() < 1.5e-3, "{byte}: off by {error}");
        }
    }

    #[test]
    fn a_curve_that_falls_or_does_not_end_at_1_is_refused() {
        let mut light: [f64; KNOTS] = std::array::from_fn(|k| k as f64 / 16.0);
        assert!(ResponseCurve::try_from(light).is_ok());
        light[5] = 0.1;
        assert_eq!(ResponseCurve::try_from(light), Err(NoResponse));
        assert!(ResponseCurve::try_from([0.0; KNOTS]).is_err());
    }
}
