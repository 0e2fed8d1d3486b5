//! How well the camera will tell the colours apart, predicted place by place.
//!
//! Takes the places of a trial with the responses and the noise law. For each place the mean and the
//! variance of every colour's light follow (`distances`), and from them the Mahalanobis distance d between
//! two colours; a reader with a reference mistakes one for the other with probability Q(d/2). Gives the mean of
//! Q over the scene, its mean by tile, and the distance that nine tenths of the surface exceed. Channels
//! are taken as independent, which a Bayer mosaic and JPEG make optimistic: good for ranking.

use rayon::prelude::*;
use shared::pattern::PALETTE_SIZE;

use super::{
    Separability, TILES,
    distances::{DARK, LANES, PAIRS, pair_number, squared_distances},
    noise::NoiseLaw,
    responses::{Responses, is_lit},
    samples::{Place, Places},
};

/// Most places that are predicted.
const SAMPLES: usize = 5000;
/// Tiles of the scene; each is one parallel piece, so that sums come out the same on any number of threads.
const REGIONS: usize = TILES.0 * TILES.1;
/// Steps per standard deviation in the tables of distance.
const STEPS: f32 = 8.0;
/// Entries of these tables: up to 16 standard deviations.
const ENTRIES: usize = 128;
/// RMS error of a line's middle, in px, at a signal-to-noise ratio of 1 with 1 px of blur.
const LINE_ERROR_PX: f32 = 1.3;

/// Sums over the places of a tile, by pair of classes.
struct Sums {
    error: [f64; PAIRS],
    count: usize,
    /// How often each distance occurs, [`ENTRIES`] for each pair.
    distances: Vec<u32>,
    squared_line_error: [f64; PALETTE_SIZE],
}

/// What the scene will do to the colours.
#[derive(Debug, Clone, Default)]
pub(super) struct Predicted {
    /// Averages over the scene.
    pub separability: Separability,
    /// The same by tile, `None` where no light arrives.
    pub tiles: Vec<Option<Separability>>,
    /// Predicted RMS error of a unary line in each colour, camera px.
    pub line_error_px: Vec<f64>,
    /// Share of the places, by tile, that projected light reaches.
    pub lit: Vec<f64>,
}

/// Predicts distances and errors; `None` when no place is lit.
pub(super) fn predict(
    places: &Places,
    responses: &Responses,
    noise: NoiseLaw,
) -> Option<Predicted> {
    let mut by_tile: [Vec<&Place>; REGIONS] = Default::default();
    let mut all = [0_usize; REGIONS];
    for place in &places.places {
        all[place.tile] += 1;
        if is_lit(place, noise) {
            by_tile[place.tile].push(place);
        }
    }
    let lit: usize = by_tile.iter().map(Vec::len).sum();
    if lit == 0 {
        return None;
    }
    let table = error_table();
    let step = lit.div_ceil(SAMPLES);
    let tiles: Vec<Sums> = by_tile
        .par_iter()
        .map(|lit| {
            let chosen: Vec<&Place> = lit.iter().step_by(step).copied().collect();
            Sums::new(&chosen, responses, noise, &table)
        })
        .collect();
    let share = |(lit, all): (&Vec<&Place>, usize)| lit.len() as f64 / all.max(1) as f64;
    let lit = by_tile.iter().zip(all).map(share).collect();
    Some(predicted(&tiles, responses.r.len(), lit))
}

impl Sums {
    fn new(
        places: &[&Place],
        responses: &Responses,
        noise: NoiseLaw,
        table: &[f32; ENTRIES],
    ) -> Self {
        let mut sums = Self {
            error: [0.0; PAIRS],
            count: places.len(),
            distances: vec![0; PAIRS * ENTRIES],
            squared_line_error: [0.0; PALETTE_SIZE],
        };
        for places in places.chunks(LANES) {
            let squared = squared_distances(places, responses, noise);
            sums.add(&squared, places.len(), table);
        }
        sums
    }

    fn add(&mut self, squared: &[[f32; LANES]; PAIRS], count: usize, table: &[f32; ENTRIES]) {
        let histograms = self.distances.chunks_exact_mut(ENTRIES);
        for ((squared, histogram), sum) in squared.iter().zip(histograms).zip(&mut self.error) {
            let entries = squared.map(|s| (s.sqrt() * STEPS).min(ENTRIES as f32 - 1.0) as i32);
            let mut error = 0.0;
            for entry in &entries[..count] {
                let entry = *entry as usize % ENTRIES;
                error += table[entry];
                histogram[entry] += 1;
            }
            *sum += f64::from(error);
        }
        for (k, sum) in self.squared_line_error.iter_mut().enumerate() {
            for squared in &squared[pair_number(k, DARK)][..count] {
                let error = LINE_ERROR_PX / squared.sqrt().max(LINE_ERROR_PX);
                *sum += f64::from(error * error);
            }
        }
    }
}

fn predicted(tiles: &[Sums], colours: usize, lit: Vec<f64>) -> Predicted {
    let all: usize = tiles.iter().map(|tile| tile.count).sum();
    let error = |pair: usize| tiles.iter().map(|t| t.error[pair]).sum::<f64>() / all as f64;
    let line_error = |k: usize| {
        let sum: f64 = tiles.iter().map(|t| t.squared_line_error[k]).sum();
        (sum / all as f64).sqrt()
    };
    let tile = |tile: &Sums| {
        let error = |pair: usize| tile.error[pair] / tile.count as f64;
        (tile.count > 0).then(|| table_of(colours, error, |_| 0.0))
    };
    Predicted {
        separability: table_of(colours, error, |pair| tenth_percentile(tiles, pair, all)),
        tiles: tiles.iter().map(tile).collect(),
        line_error_px: (0..colours).map(line_error).collect(),
        lit,
    }
}

fn tenth_percentile(tiles: &[Sums], pair: usize, all: usize) -> f64 {
    let mut below = 0;
    for entry in 0..ENTRIES {
        let at = pair * ENTRIES + entry;
        below += tiles
            .iter()
            .map(|t| t.distances[at] as usize)
            .sum::<usize>();
        if below * 10 > all {
            return (entry as f64 + 0.5) / f64::from(STEPS);
        }
    }
    ENTRIES as f64 / f64::from(STEPS)
}

/// Fills the symmetric tables from functions of a pair's number.
fn table_of(
    colours: usize,
    error: impl Fn(usize) -> f64,
    distance: impl Fn(usize) -> f64,
) -> Separability {
    let value = |of: &dyn Fn(usize) -> f64, a: usize, b: usize| match a == b {
        true => 0.0,
        false => of(pair_number(a.min(b), a.max(b))),
    };
    let square = |of: &dyn Fn(usize) -> f64| {
        let row = |a| (0..colours).map(|b| value(of, a, b)).collect();
        (0..colours).map(row).collect()
    };
    let dark = |of: &dyn Fn(usize) -> f64| (0..colours).map(|a| of(pair_number(a, DARK))).collect();
    Separability {
        error: square(&error),
        distance: square(&distance),
        dark_error: dark(&error),
        dark_distance: dark(&distance),
    }
}

/// Q(d/2) for the middle of each entry of distance, Q the tail of the normal distribution.
fn error_table() -> [f32; ENTRIES] {
    std::array::from_fn(|entry| tail((entry as f64 + 0.5) / f64::from(STEPS) / 2.0) as f32)
}

/// Tail probability of the standard normal distribution for x >= 0, to 7.5e-8 (Abramowitz and Stegun,
/// 26.2.17).
fn tail(x: f64) -> f64 {
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
        for (x, q) in [(0.0, 0.5), (1.0, 0.158_655_3), (3.0, 0.001_349_9)] {
            assert!((tail(x) - q).abs() < 1e-6, "{x}");
        }
    }

    #[test]
    fn tables_are_symmetric_and_a_tile_without_places_has_none() {
        let place = *Places::grey_wall().places.first().unwrap();
        let places = Places {
            places: vec![place; 20],
        };
        let colours = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255; 3]].map(shared::pattern::Rgb);
        let responses = Responses::nominal(&colours);
        let found = predict(&places, &responses, NoiseLaw::COMMON).unwrap();
        let error = &found.separability.error;
        let pairs = (0..4).flat_map(|a| (0..4).map(move |b| (a, b)));
        for (a, b) in pairs {
            assert_eq!(error[a][b], error[b][a]);
            assert_eq!(error[a][b] == 0.0, a == b);
        }
        assert_eq!(found.tiles[0].as_ref().unwrap().error, *error);
        assert!(found.tiles[1..].iter().all(Option::is_none));
        assert_eq!((found.lit[0], found.lit[1]), (1.0, 0.0));
    }
}
