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
const LIGHT_ERROR: f32 = 0.03;

/// One number for each class and place.
type Classes = [[f32; LANES]; CLASSES];

/// Where the pair a < b stands in a list of all pairs: 0-1, 0-2 .. 0-16, 1-2 ..
pub(super) fn pair_number(a: usize, b: usize) -> usize {
    a * (2 * CLASSES - a - 1) / 2 + b - a - 1
}

/// Squared distances for up to [`LANES`] places; beyond these, 0. Classes beyond the colours of the trial
/// stay at no line.
pub(super) fn squared_distances(
    places: &[&Place],
    responses: &Responses,
    noise: NoiseLaw,
) -> [[f32; LANES]; PAIRS] {
    let mut squared = [[0.0; LANES]; PAIRS];
    for c in 0..3 {
        let (mean, variance) = light(places, responses, noise, c);
        let mut pair = squared.iter_mut();
        for a in 0..CLASSES {
            for (b, squared) in (a + 1..CLASSES).zip(pair.by_ref()) {
                for n in 0..LANES {
                    let apart = mean[a][n] - mean[b][n];
                    squared[n] += 2.0 * apart * apart / (variance[a][n] + variance[b][n]);
                }
            }
        }
    }
    squared
}

/// Mean and variance of each class's light in one channel. A channel that can't be used is dark in all.
fn light(
    places: &[&Place],
    responses: &Responses,
    noise: NoiseLaw,
    c: usize,
) -> (Classes, Classes) {
    let (read, shot) = (noise.read as f32, noise.shot as f32);
    let (mut mean, mut variance) = ([[0.0; LANES]; CLASSES], [[1.0; LANES]; CLASSES]);
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
    (mean, variance)
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
        let apart = |place: &Place| {
            squared_distances(&[place], &responses, NoiseLaw::COMMON)[pair_number(0, 1)]
        };
        assert!(apart(&place)[0] > 100.0);
        assert_eq!(apart(&place)[1], 0.0);
        place.usable[0] = false;
        assert_eq!(apart(&place)[0], 0.0);
    }
}
