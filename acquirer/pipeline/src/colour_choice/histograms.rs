//! How often each distance between two colours, and each margin above the limit of being seen, occurs in a tile.
//!
//! Takes places of one tile, gives histograms from which mean errors and percentiles follow alike. An error is Q of
//! half the distance, or of the margin, Q being the tail of the normal distribution.

use std::sync::LazyLock;

use pulp::{Arch, NullaryFnOnce};
use shared::pattern::PALETTE_SIZE;

use super::{
    distances::{CLASSES, ClassLight, DARK, LANES, PAIRS},
    noise::NoiseLaw,
    responses::Responses,
    samples::Place,
    visibility::Visibility,
};

/// Steps per standard deviation.
const STEPS: f32 = 4.0;
/// Entries of a histogram: 16 standard deviations; a power of two, so that every masked number is one of them.
const ENTRIES: usize = 64;
/// The least margin: half of the entries lie below 0.
const LEAST_MARGIN: f32 = -8.0;
/// RMS error of a line's middle, in px, at a signal-to-noise ratio of 1 with 1 px of blur.
const LINE_ERROR_PX: f32 = 1.3;

/// What is known of projector and camera, beside the places.
#[derive(Clone, Copy)]
pub(super) struct Optics<'a> {
    pub responses: &'a Responses,
    pub noise: NoiseLaw,
    pub visibility: &'a Visibility,
}

/// Counts of one quantity. A tile holds far fewer places than can be counted.
pub(super) type Counts = [u16; ENTRIES];

/// The histograms of a tile.
pub(super) struct Histograms {
    /// Number of places.
    pub places: usize,
    /// Distances, by pair of classes.
    pub distances: Vec<Counts>,
    /// Margins, by colour.
    pub margins: Vec<Counts>,
    /// Sum over the places of the squared error of a line's middle, by colour.
    pub squared_line_error: [f64; PALETTE_SIZE],
}

impl Histograms {
    pub(super) fn new(places: &[&Place], optics: Optics<'_>) -> Self {
        let mut histograms = Self {
            places: places.len(),
            distances: vec![[0; ENTRIES]; PAIRS],
            margins: vec![[0; ENTRIES]; PALETTE_SIZE],
            squared_line_error: [0.0; PALETTE_SIZE],
        };
        // compiled for the widest registers that the processor has
        Arch::new().dispatch(Filling {
            histograms: &mut histograms,
            places,
            optics,
        });
        histograms
    }

    /// Adds up to [`LANES`] places.
    #[inline(always)]
    fn add(&mut self, places: &[&Place], optics: Optics<'_>) {
        let Optics {
            responses,
            noise,
            visibility,
        } = optics;
        let light = ClassLight::new(places, responses, noise);
        let pairs = (0..CLASSES).flat_map(|a| (a + 1..CLASSES).map(move |b| (a, b)));
        for ((a, b), histogram) in pairs.zip(&mut self.distances) {
            let distances = light.squared(a, b).map(f32::sqrt);
            count_up(distances.map(|d| d * STEPS), places.len(), histogram);
        }
        let margins = visibility.margins(places, responses, noise);
        for (margins, histogram) in margins.iter().zip(&mut self.margins) {
            let entries = margins.map(|m| (m - LEAST_MARGIN) * STEPS);
            count_up(entries, places.len(), histogram);
        }
        for (k, sum) in self.squared_line_error.iter_mut().enumerate() {
            let error = light.squared(k, DARK).map(|squared| {
                let share = LINE_ERROR_PX * LINE_ERROR_PX / squared.max(1e-9);
                share.min(1.0)
            });
            *sum += f64::from(error[..places.len()].iter().sum::<f32>());
        }
    }
}

/// Counts the entries that values in steps fall into; what is less or more goes to the first or the last.
#[inline(always)]
fn count_up(steps: [f32; LANES], places: usize, histogram: &mut Counts) {
    /// A number so large that a float near it has no fraction: its last bits are the whole steps.
    const WHOLE: f32 = (1 << 23) as f32;
    let entries = steps.map(|steps| {
        let middle = steps.clamp(0.5, ENTRIES as f32 - 0.5) - 0.5;
        (middle + WHOLE).to_bits() as usize % ENTRIES
    });
    if places == LANES {
        // the common case, without a loop of unknown length
        entries.into_iter().for_each(|entry| histogram[entry] += 1);
    } else {
        entries[..places]
            .iter()
            .for_each(|&entry| histogram[entry] += 1);
    }
}

/// The pass over the places of a tile.
struct Filling<'a> {
    histograms: &'a mut Histograms,
    places: &'a [&'a Place],
    optics: Optics<'a>,
}

impl NullaryFnOnce for Filling<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for places in self.places.chunks(LANES) {
            self.histograms.add(places, self.optics);
        }
    }
}

/// Sum over a tile's places of the probability to take one colour for the other.
pub(super) fn sum_of_errors(distances: &Counts) -> f64 {
    static TABLE: LazyLock<[f64; ENTRIES]> = LazyLock::new(|| table(|entry| entry / 2.0));
    weighted(distances, &TABLE)
}

/// Sum over a tile's places of the probability to lose a line.
pub(super) fn sum_of_losses(margins: &Counts) -> f64 {
    static TABLE: LazyLock<[f64; ENTRIES]> =
        LazyLock::new(|| table(|entry| entry + f64::from(LEAST_MARGIN)));
    weighted(margins, &TABLE)
}

/// The distance that nine tenths of all places exceed, in standard deviations.
pub(super) fn tenth_distance<'a>(tiles: impl Iterator<Item = &'a Counts>) -> f64 {
    tenth_percentile(tiles)
}

/// The distance of a line from no line that nine tenths of all places exceed: twice the margin, as two colours'
/// distance is twice that from the limit between them; at least 0.
pub(super) fn tenth_dark_distance<'a>(tiles: impl Iterator<Item = &'a Counts>) -> f64 {
    (2.0 * (tenth_percentile(tiles) + f64::from(LEAST_MARGIN))).max(0.0)
}

fn weighted(counts: &Counts, table: &[f64; ENTRIES]) -> f64 {
    let products = counts.iter().zip(table);
    products
        .map(|(&count, value)| f64::from(count) * value)
        .sum()
}

/// The value in standard deviations, from the first entry's beginning, that nine tenths of the places exceed; evenly
/// spread within an entry.
fn tenth_percentile<'a>(tiles: impl Iterator<Item = &'a Counts>) -> f64 {
    let mut all = [0_u32; ENTRIES];
    for tile in tiles {
        let sums = all.iter_mut().zip(tile);
        sums.for_each(|(sum, &count)| *sum += u32::from(count));
    }
    let mut rest = f64::from(all.iter().sum::<u32>()) / 10.0;
    let mut entries = 0.0;
    for count in all.map(f64::from) {
        if count >= rest {
            entries += rest / count.max(1.0);
            break;
        }
        rest -= count;
        entries += 1.0;
    }
    entries / f64::from(STEPS)
}

/// Q for the middle of each entry, whose value in standard deviations `x` makes Q's argument.
fn table(x: impl Fn(f64) -> f64) -> [f64; ENTRIES] {
    std::array::from_fn(|entry| tail(x((entry as f64 + 0.5) / f64::from(STEPS))))
}

/// Tail probability of the standard normal distribution, to 7.5e-8 (Abramowitz and Stegun, 26.2.17).
fn tail(x: f64) -> f64 {
    if x < 0.0 {
        return 1.0 - tail(-x);
    }
    let t = 1.0 / (1.0 + 0.231_641_9 * x);
    let polynomial = t
        * (0.319_381_530
            + t * (-0.356_563_782
                + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    (-x * x / 2.0).exp() / (2.0 * std::f64::consts::PI).sqrt() * polynomial
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tail_is_that_of_the_normal_distribution() {
        for (x, q) in [
            (0.0, 0.5),
            (1.0, 0.158_655_3),
            (3.0, 0.001_349_9),
            (-1.0, 0.841_344_7),
        ] {
            assert!((tail(x) - q).abs() < 1e-6, "{x}");
        }
    }

    #[test]
    fn a_value_is_counted_where_it_belongs() {
        let steps = [-3.0, 0.2, 1.1, 1.9, 2.1, 62.7, 63.2, 900.0];
        let mut counts = [0; ENTRIES];
        count_up(steps, 8, &mut counts);
        count_up([f32::INFINITY; LANES], 3, &mut counts);
        assert_eq!((counts[0], counts[1], counts[2]), (2, 2, 1));
        assert_eq!((counts[62], counts[63]), (1, 5));
    }

    #[test]
    fn nine_tenths_exceed_the_tenth_percentile() {
        let (mut few, mut many) = ([0; ENTRIES], [0; ENTRIES]);
        (few[8], many[40]) = (9, 91);
        let distance = tenth_distance([few, many].iter());
        assert!((10.0..10.25).contains(&distance), "{distance}");
        few[8] = 11;
        let distance = tenth_distance([few, many].iter());
        assert!((2.0..2.25).contains(&distance), "{distance}");
        let margin = tenth_dark_distance([few, many].iter());
        assert_eq!(margin, 0.0);
    }
}
