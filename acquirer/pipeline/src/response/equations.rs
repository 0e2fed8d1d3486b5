//! What must hold between the captures of solid colours, as equations between bytes of one channel at one block.

use shared::pattern::Rgb;

use super::solids::{Blocks, PRIMARIES, SUMS, SolidCaptures};

/// Most blocks that are looked at: more hardly tell more.
const MOST_BLOCKS: usize = 700;
/// White must be this much brighter than black, byte values.
const LEAST_SIGNAL: f64 = 12.0;
/// A primary darker than this may be cut off, byte values.
const LEAST_PRIMARY: f64 = 2.0;
/// Fewest greys that show the shape of a curve.
const FEWEST_GREYS: usize = 3;

/// Four byte values of one channel at one block that belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Sum of two primaries, black, and the two.
    Pair,
    /// Grey, black, white, nothing.
    Grey,
}

/// Equations that share their unknowns.
pub(super) struct Group {
    pub(super) kind: Kind,
    /// The grey's share of white.
    pub(super) share: f64,
    pub(super) nominal_share: f64,
    pub(super) bytes: Vec<[f64; 4]>,
}

impl Group {
    /// What each byte's light counts; the sum is 0 when light adds up.
    pub(super) fn factors(&self) -> [f64; 4] {
        match self.kind {
            Kind::Pair => [1.0, 1.0, -1.0, -1.0],
            Kind::Grey => [1.0, self.share - 1.0, -self.share, 0.0],
        }
    }
}

/// The equations of all pairs and greys, each channel by itself; `None` when a colour is missing.
pub(super) fn groups(solids: &SolidCaptures) -> Option<Vec<Group>> {
    let [black, white] = [Rgb::BLACK, Rgb::WHITE].map(|colour| solids.means(colour));
    let (black, white) = (black?, white?);
    let mut groups = Vec::new();
    for ([a, b], colour) in SUMS {
        let [sum, a, b] = [colour, PRIMARIES[a], PRIMARIES[b]].map(|colour| solids.means(colour));
        let pictures = [&sum?, &black, &a?, &b?];
        groups.extend([0, 1, 2].map(|channel| pair(pictures, channel)));
    }
    let mut greys = 0;
    for grey in solids.greys() {
        let seen = solids.means(Rgb([grey; 3]))?;
        let pictures = [&seen, &black, &white];
        groups.extend([0, 1, 2].map(|channel| ramp(pictures, channel, grey)));
        greys += 1;
    }
    (greys >= FEWEST_GREYS).then_some(groups)
}

fn pair(pictures: [&Blocks; 4], channel: usize) -> Group {
    let mut bytes = together(pictures, channel);
    bytes.retain(|[sum, black, a, b]| a.min(*b) >= LEAST_PRIMARY && sum - black > LEAST_SIGNAL);
    Group {
        kind: Kind::Pair,
        share: 0.0,
        nominal_share: 0.0,
        bytes,
    }
}

fn ramp(pictures: [&Blocks; 3], channel: usize, grey: u8) -> Group {
    let mut bytes = together(pictures, channel);
    bytes.retain(|[_, black, white]| white - black > LEAST_SIGNAL);
    let nominal_share = (f64::from(grey) / 255.0).powf(2.2);
    Group {
        kind: Kind::Grey,
        share: nominal_share,
        nominal_share,
        bytes: bytes.into_iter().map(|[g, k, w]| [g, k, w, 0.0]).collect(),
    }
}

/// The bytes of one channel at the blocks that all pictures show even and not cut off.
fn together<const N: usize>(pictures: [&Blocks; N], channel: usize) -> Vec<[f64; N]> {
    let blocks = pictures.iter().map(|picture| picture.len()).min();
    let blocks = blocks.unwrap_or(0);
    let places = (0..blocks).step_by(blocks.div_ceil(MOST_BLOCKS).max(1));
    let bytes = places.map(|at| pictures.map(|picture| f64::from(picture[at][channel])));
    bytes
        .filter(|bytes| bytes.iter().all(|v| v.is_finite()))
        .collect()
}
