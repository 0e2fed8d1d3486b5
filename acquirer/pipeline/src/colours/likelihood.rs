//! How likely a sample is in each colour, four colours at a time.
//!
//! A normal log-likelihood with the gain integrated out (matrix determinant and inversion lemmas), up to what all colours
//! share. The logarithm is our own, so that every machine gives the same bits.

use shared::pattern::MAX_COLOURS;

use super::Sample;

/// Colours that are looked at together.
const LANES: usize = 4;
const GROUPS: usize = MAX_COLOURS.div_ceil(LANES);

/// Responses of the colours, channel by channel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lanes {
    groups: [[[f32; LANES]; 3]; GROUPS],
    used: usize,
}

impl Lanes {
    pub(super) fn new(responses: &[[f32; 3]]) -> Self {
        let mut groups = [[[0.0; LANES]; 3]; GROUPS];
        for (k, response) in responses.iter().enumerate() {
            for c in 0..3 {
                groups[k / LANES][c][k % LANES] = response[c];
            }
        }
        Self {
            groups,
            used: responses.len().div_ceil(LANES),
        }
    }

    /// The log-likelihood of each colour, in nats; `weights` are the inverse variances of the channels' light.
    #[inline]
    pub(super) fn log_likelihoods(
        &self,
        (sample, weights): (&Sample, [f32; 3]),
        gain_variance: f32,
    ) -> [f32; MAX_COLOURS] {
        let mut nats = [0.0; MAX_COLOURS];
        let places = nats.chunks_mut(LANES);
        for (group, places) in self.groups[..self.used].iter().zip(places) {
            let (mut ee, mut em, mut mm) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            for c in 0..3 {
                let (full, light, weight) = (sample.full[c], sample.light[c], weights[c]);
                for k in 0..LANES {
                    let model = full * group[c][k];
                    let error = light - model;
                    ee[k] += error * error * weight;
                    em[k] += error * model * weight;
                    mm[k] += model * model * weight;
                }
            }
            let mut found = [0.0; LANES];
            for k in 0..LANES {
                let spread = 1.0 + gain_variance * mm[k];
                let logarithm = ln(spread);
                found[k] = -0.5 * (ee[k] - gain_variance * em[k] * em[k] / spread + logarithm);
            }
            places.copy_from_slice(&found[..places.len()]);
        }
        nats
    }
}

/// The natural logarithm of a normal number above 0 (S. L. Moshier, "Methods and Programs for Mathematical Functions",
/// 1989, `logf`).
#[inline(always)]
fn ln(x: f32) -> f32 {
    const ROOT_OF_HALF: u32 = 0x3f35_04f3;
    const MANTISSA: u32 = 0x007f_ffff;
    // x = 2^exponent (1 + rest), 1 + rest between the roots of 1/2 and of 2
    let shifted = x.to_bits().wrapping_add(0x3f80_0000 - ROOT_OF_HALF);
    let exponent = (shifted >> 23).wrapping_sub(127).cast_signed() as f32;
    let rest = f32::from_bits((shifted & MANTISSA) + ROOT_OF_HALF) - 1.0;
    let square = rest * rest;
    let mut series = 7.037_683_6e-2;
    for coefficient in [
        -1.151_461e-1,
        1.167_699_9e-1,
        -1.242_014_1e-1,
        1.424_932_3e-1,
        -1.666_805_8e-1,
        2.000_071_4e-1,
        -2.499_999_4e-1,
        3.333_333e-1,
    ] {
        series = series * rest + coefficient;
    }
    let small = series * rest * square - 2.121_944_4e-4 * exponent - 0.5 * square;
    rest + small + 0.693_359_4 * exponent
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_is_the_logarithm() {
        for k in 0..20_000 {
            let x = 0.9 * 1.001_f32.powi(k);
            let (ours, true_one) = (f64::from(ln(x)), f64::from(x).ln());
            assert!(
                (ours - true_one).abs() < 2e-7 * true_one.abs().max(1.0),
                "{x}: {ours}"
            );
        }
        assert_eq!(ln(1.0), 0.0);
    }

    #[test]
    fn a_sample_is_likeliest_in_its_own_colour_whichever_place_that_has() {
        let colours: Vec<[f32; 3]> = (0..MAX_COLOURS)
            .map(|k| {
                std::array::from_fn(|c| 0.2 + 0.8 * f32::from(u8::from((k + 1) >> c & 1 == 1)))
            })
            .collect();
        for count in 1..=MAX_COLOURS.min(7) {
            let lanes = Lanes::new(&colours[..count]);
            for (k, colour) in colours[..count].iter().enumerate() {
                let sample = Sample {
                    light: colour.map(|v| 0.4 * v),
                    full: [0.5; 3],
                    variance: [1e-4; 3],
                };
                let nats = lanes.log_likelihoods((&sample, [1e3; 3]), 0.05);
                let best = (0..count).max_by(|&a, &b| nats[a].total_cmp(&nats[b]));
                assert_eq!(best, Some(k), "{nats:?}");
            }
        }
    }
}
