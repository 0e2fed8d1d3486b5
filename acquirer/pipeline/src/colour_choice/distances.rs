//! Squared Mahalanobis distances between the classes (sixteen colours and no line) at a few places at once.
//!
//! Takes places, gives one squared distance for each pair of classes and place, for a reader that divides by
//! a white line there, whose own noise counts as well. Places lie side by side in memory, so that the
//! compiler takes several in one instruction.

use shared::pattern::PALETTE_SIZE;

use super::{noise::NoiseLaw, responses::Responses, samples::Place};

/// The sixteen colours and, last, no line.
pub(super) const CLASSES: usize = PALETTE_SIZE + 1;
/// Number of the class "no line".
pub(super) const DARK: usize = PALETTE_SIZE;
/// Pairs of different classes.
pub(super) const PAIRS: usize = CLASSES * (CLASSES - 1) / 2;
/// Places that are worked on at once.
pub(super) const LANES: usize = 8;
/// Share of a colour's light by which blur, compression and interpolated channels falsify it.
pub(super) const LIGHT_ERROR: f32 = 0.03;

/// One number for each class and place.
type Classes = [[f32; LANES]; CLASSES];

/// Where the pair a < b stands in a list of all pairs: 0-1, 0-2 .. 0-16, 1-2 ..
pub(super) fn pair_number(a: usize, b: usize) -> usize {
    a * (2 * CLASSES - a - 1) / 2 + b - a - 1
}

/// Mean and variance of each class's light at up to [`LANES`] places, per channel; beyond these, no light. Classes
/// beyond the colours of the trial stay at no line.
pub(super) struct ClassLight {
    mean: [Classes; 3],
    variance: [Classes; 3],
}

impl ClassLight {
    #[inline(always)]
    pub(super) fn new(places: &[&Place], responses: &Responses, noise: NoiseLaw) -> Self {
        let mut light = Self {
            mean: [[[0.0; LANES]; CLASSES]; 3],
            variance: [[[1.0; LANES]; CLASSES]; 3],
        };
        for c in 0..3 {
            light.fill(c, places, responses, noise);
        }
        light
    }

    /// A channel that can't be used is dark in all classes.
    #[inline(always)]
    fn fill(&mut self, c: usize, places: &[&Place], responses: &Responses, noise: NoiseLaw) {
        let (read, shot) = (noise.read as f32, noise.shot as f32);
        let (mean, variance) = (&mut self.mean[c], &mut self.variance[c]);
        let (mut dark, mut white) = ([0.0; LANES], [0.0; LANES]);
        for (n, place) in places.iter().enumerate().filter(|(_, p)| p.usable[c]) {
            dark[n] = f32::max(place.dark[c], 0.0);
            white[n] = (place.white[c] * responses.line_level).max(0.0);
        }
        for k in 0..CLASSES {
            let r = responses.r.get(k).map_or(0.0, |r| r[c]);
            for n in 0..LANES {
                let reference = read + shot * (dark[n] + white[n]);
                mean[k][n] = r * white[n];
                let own = read + shot * (dark[n] + mean[k][n]) + r * r * reference;
                let falsified = LIGHT_ERROR * mean[k][n];
                variance[k][n] = responses.excess * own + falsified * falsified;
            }
        }
    }

    /// Squared distances between two classes.
    #[inline(always)]
    pub(super) fn squared(&self, a: usize, b: usize) -> [f32; LANES] {
        let mut squared = [0.0; LANES];
        for (mean, variance) in self.mean.iter().zip(&self.variance) {
            for n in 0..LANES {
                let apart = mean[a][n] - mean[b][n];
                squared[n] += 2.0 * apart * apart / (variance[a][n] + variance[b][n]);
            }
        }
        squared
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_counted_without_gaps() {
        let pairs = (0..CLASSES).flat_map(|a| (a + 1..CLASSES).map(move |b| (a, b)));
        for (n, (a, b)) in pairs.enumerate() {
            assert_eq!(pair_number(a, b), n);
        }
        assert_eq!(pair_number(DARK - 1, DARK), PAIRS - 1);
    }

    #[test]
    fn a_clipped_channel_tells_nothing_apart() {
        let mut place = super::super::samples::Places::grey_wall().places[0];
        let responses = Responses::nominal(&[[255, 0, 0], [0, 0, 0]].map(shared::pattern::Rgb));
        let apart =
            |place: &Place| ClassLight::new(&[place], &responses, NoiseLaw::COMMON).squared(0, 1);
        assert!(apart(&place)[0] > 100.0);
        assert_eq!(apart(&place)[1], 0.0);
        place.usable[0] = false;
        assert_eq!(apart(&place)[0], 0.0);
    }
}
