//! The camera's channels made independent: what its red sees of green and blue light, and so on.
//!
//! A camera channel answers a little to the other primaries, so that on a saturated surface its light may
//! come from a primary that the surface reflects and not from its own. Takes the mean light of lines whose
//! colour lacks a primary; there the corrected channel must be dark. Gives a matrix with ones on the
//! diagonal (Caspi, Kiryati and Shamir 1998 call its inverse the colour coupling). A scene that is grey all
//! over says little; the prior then keeps the matrix near the identity.

/// Corrected channel j is the sum over c of `matrix[j][c]` times channel c.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unmixing {
    matrix: [[f32; 3]; 3],
}

/// Light of a line whose colour is known: what came back, relative to the strongest channel of white.
#[derive(Debug, Clone, Copy)]
pub(super) struct KnownLight {
    pub(super) light: [f32; 3],
    /// Which primaries its nominal colour lacks.
    pub(super) lacks: [bool; 3],
}

/// Spread of the corrections around none.
const PRIOR_SPREAD: f64 = 0.1;
/// Spread of a dark channel's light around 0, as a share of white: interreflection, chroma smear.
const DARK_SPREAD: f64 = 0.05;
/// Strongest correction.
const STRONGEST: f64 = 0.4;
/// Fewest lines to estimate a channel from.
const FEWEST: usize = 8;

impl Unmixing {
    /// Nothing corrected.
    pub(super) const NONE: Self = Self {
        matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    };

    /// Least squares for each channel's two corrections.
    pub(super) fn estimate(lines: &[KnownLight]) -> Self {
        let mut unmixing = Self::NONE;
        for channel in 0..3 {
            let others = [(channel + 1) % 3, (channel + 2) % 3];
            let weight = 1.0 / (DARK_SPREAD * DARK_SPREAD);
            let prior = 1.0 / (PRIOR_SPREAD * PRIOR_SPREAD);
            let (mut aa, mut ab, mut bb, mut ay, mut by) = (prior, 0.0, prior, 0.0, 0.0);
            let dark = lines.iter().filter(|line| line.lacks[channel]);
            if dark.clone().count() < FEWEST {
                continue;
            }
            for line in dark {
                let [a, b] = others.map(|other| f64::from(line.light[other]));
                let y = -f64::from(line.light[channel]);
                aa += weight * a * a;
                ab += weight * a * b;
                bb += weight * b * b;
                ay += weight * a * y;
                by += weight * b * y;
            }
            let determinant = aa * bb - ab * ab; // at least prior^2
            let solved = [
                (ay * bb - by * ab) / determinant,
                (by * aa - ay * ab) / determinant,
            ];
            for (other, value) in others.into_iter().zip(solved) {
                unmixing.matrix[channel][other] = value.clamp(-STRONGEST, 0.0) as f32;
            }
        }
        unmixing
    }

    /// Corrected light.
    pub(super) fn light(&self, light: [f32; 3]) -> [f32; 3] {
        self.matrix
            .map(|row| row[0] * light[0] + row[1] * light[1] + row[2] * light[2])
    }

    /// Variance of corrected light.
    pub(super) fn variance(&self, variance: [f32; 3]) -> [f32; 3] {
        self.matrix
            .map(|[r, g, b]| r * r * variance[0] + g * g * variance[1] + b * b * variance[2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crosstalk_is_found_from_lines_on_surfaces_of_many_colours() {
        let seen = |primaries: [f32; 3]| {
            let [r, g, b] = primaries;
            [r + 0.1 * g, g + 0.1 * r + 0.05 * b, b + 0.12 * g]
        };
        let mut lines = Vec::new();
        for k in 0..60 {
            let albedo = [
                0.1 + 0.015 * k as f32,
                0.9 - 0.012 * k as f32,
                0.2 + 0.01 * ((7 * k) % 60) as f32,
            ];
            for lacks in [
                [false, true, true],
                [true, false, true],
                [true, false, false],
                [false, true, false],
            ] {
                let primaries: [f32; 3] =
                    std::array::from_fn(|c| if lacks[c] { 0.0 } else { albedo[c] });
                lines.push(KnownLight {
                    light: seen(primaries),
                    lacks,
                });
            }
        }
        let unmixing = Unmixing::estimate(&lines);
        let corrected = unmixing.light(seen([0.0, 0.8, 0.0]));
        assert!(
            corrected[0].abs() < 0.01 && corrected[2].abs() < 0.01,
            "{corrected:?}"
        );
    }
}
