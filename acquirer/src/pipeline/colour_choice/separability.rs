//! How well the camera will tell the colours apart, predicted place by place.
//!
//! Takes the places of a trial with the responses and the noise law. For each place the mean and the
//! variance of every colour's light follow, and from them the Mahalanobis distance d between two
//! colours; a reader with a reference mistakes one for the other with probability Q(d/2). Gives the mean of
//! Q over the scene, its mean by tile, and the distance that nine tenths of the surface exceed. Channels
//! are taken as independent, which a Bayer mosaic and JPEG make optimistic: good for ranking.

use rayon::prelude::*;
use shared::pattern::PALETTE_SIZE;

use super::{
    Separability, TILES,
    noise::NoiseLaw,
    responses::{Responses, is_lit},
    samples::{Place, Places},
};

/// The sixteen colours and, last, no line.
const CLASSES: usize = PALETTE_SIZE + 1;
/// Number of the class "no line".
const DARK: usize = PALETTE_SIZE;
/// About how many places are predicted.
const SAMPLES: usize = 5000;
/// Places per parallel piece; fixed, so that sums come out the same on any number of threads.
const PIECE: usize = 256;
/// Steps per standard deviation in the tables of distance.
const STEPS: f32 = 8.0;
/// Entries of these tables: up to 16 standard deviations.
const ENTRIES: usize = 128;
/// Share of a colour's light by which blur, compression and interpolated channels falsify it.
const LIGHT_ERROR: f32 = 0.03;
/// RMS error of a line's middle, in px, at a signal-to-noise ratio of 1 with 1 px of blur.
const LINE_ERROR_PX: f32 = 1.3;

/// One number for each pair of classes.
type Pairs = [[f32; CLASSES]; CLASSES];

/// Sums over the places of a piece.
#[derive(Clone)]
struct Sums {
    error: Vec<Pairs>,
    count: [usize; TILES.0 * TILES.1],
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
    let lit: Vec<&Place> = places.places.iter().filter(|p| is_lit(p, noise)).collect();
    if lit.is_empty() {
        return None;
    }
    let step = (lit.len() / SAMPLES).max(1);
    let chosen: Vec<&Place> = lit.iter().step_by(step).copied().collect();
    let table = error_table();
    let pieces: Vec<Sums> = chosen
        .par_chunks(PIECE)
        .map(|piece| {
            let mut sums = Sums::new();
            for place in piece {
                sums.add(place, responses, noise, &table);
            }
            sums
        })
        .collect();
    let mut sums = Sums::new();
    for piece in &pieces {
        sums.merge(piece);
    }
    Some(sums.predicted(responses.r.len(), lit_shares(places, &lit)))
}

fn lit_shares(places: &Places, lit: &[&Place]) -> Vec<f64> {
    let count = |tile: usize, of: &mut dyn Iterator<Item = &Place>| {
        of.filter(|place| place.tile == tile).count() as f64
    };
    (0..TILES.0 * TILES.1)
        .map(|tile| {
            let all = count(tile, &mut places.places.iter());
            count(tile, &mut lit.iter().copied()) / all.max(1.0)
        })
        .collect()
}

impl Sums {
    fn new() -> Self {
        Self {
            error: vec![[[0.0; CLASSES]; CLASSES]; TILES.0 * TILES.1],
            count: [0; TILES.0 * TILES.1],
            distances: vec![0; CLASSES * CLASSES * ENTRIES],
            squared_line_error: [0.0; PALETTE_SIZE],
        }
    }

    fn merge(&mut self, other: &Self) {
        for (tile, from) in self.error.iter_mut().zip(&other.error) {
            for (row, from) in tile.iter_mut().zip(from) {
                row.iter_mut().zip(from).for_each(|(a, b)| *a += b);
            }
        }
        self.count
            .iter_mut()
            .zip(&other.count)
            .for_each(|(a, b)| *a += b);
        self.distances
            .iter_mut()
            .zip(&other.distances)
            .for_each(|(a, b)| *a += b);
        self.squared_line_error
            .iter_mut()
            .zip(&other.squared_line_error)
            .for_each(|(a, b)| *a += b);
    }

    fn add(&mut self, place: &Place, responses: &Responses, noise: NoiseLaw, table: &[f32]) {
        let squared = squared_distances(place, responses, noise);
        self.count[place.tile] += 1;
        let errors = &mut self.error[place.tile];
        for a in 0..CLASSES {
            for b in a + 1..CLASSES {
                let entry = ((squared[a][b].sqrt() * STEPS) as usize).min(ENTRIES - 1);
                errors[a][b] += table[entry];
                self.distances[(a * CLASSES + b) * ENTRIES + entry] += 1;
            }
        }
        for (k, sum) in self.squared_line_error.iter_mut().enumerate() {
            let error = LINE_ERROR_PX / squared[k][DARK].sqrt().max(LINE_ERROR_PX);
            *sum += f64::from(error * error);
        }
    }

    fn predicted(&self, colours: usize, lit: Vec<f64>) -> Predicted {
        let all: usize = self.count.iter().sum();
        let mut mean = [[0.0_f64; CLASSES]; CLASSES];
        for tile in &self.error {
            for (a, b) in pairs() {
                mean[a][b] += f64::from(tile[a][b]) / all as f64;
            }
        }
        let tile = |(errors, &count): (&Pairs, &usize)| {
            (count > 0).then(|| {
                let error = |a: usize, b: usize| f64::from(errors[a][b]) / count as f64;
                table_of(colours, error, |_, _| 0.0)
            })
        };
        Predicted {
            separability: table_of(
                colours,
                |a, b| mean[a][b],
                |a, b| self.tenth_percentile(a, b, all),
            ),
            tiles: self.error.iter().zip(&self.count).map(tile).collect(),
            line_error_px: self.squared_line_error[..colours]
                .iter()
                .map(|sum| (sum / all as f64).sqrt())
                .collect(),
            lit,
        }
    }

    fn tenth_percentile(&self, a: usize, b: usize, all: usize) -> f64 {
        let start = (a * CLASSES + b) * ENTRIES;
        let mut below = 0;
        for (entry, count) in self.distances[start..start + ENTRIES].iter().enumerate() {
            below += *count as usize;
            if below * 10 > all {
                return (entry as f64 + 0.5) / f64::from(STEPS);
            }
        }
        ENTRIES as f64 / f64::from(STEPS)
    }
}

fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..CLASSES).flat_map(|a| (a + 1..CLASSES).map(move |b| (a, b)))
}

/// Fills the symmetric tables from functions of a pair a < b.
fn table_of(
    colours: usize,
    error: impl Fn(usize, usize) -> f64,
    distance: impl Fn(usize, usize) -> f64,
) -> Separability {
    let square = |of: &dyn Fn(usize, usize) -> f64| {
        (0..colours)
            .map(|a| {
                (0..colours)
                    .map(|b| if a == b { 0.0 } else { of(a.min(b), a.max(b)) })
                    .collect()
            })
            .collect()
    };
    Separability {
        error: square(&error),
        distance: square(&distance),
        dark_error: (0..colours).map(|a| error(a, DARK)).collect(),
        dark_distance: (0..colours).map(|a| distance(a, DARK)).collect(),
    }
}

/// Squared Mahalanobis distances between the classes at one place, for a reader that divides by a white
/// line there, whose own noise counts as well. Classes beyond the colours of the trial stay at no line.
fn squared_distances(place: &Place, responses: &Responses, noise: NoiseLaw) -> Pairs {
    let mut squared = [[0.0_f32; CLASSES]; CLASSES];
    for c in (0..3).filter(|&c| place.usable[c]) {
        let white = (place.white[c] * responses.line_level).max(0.0);
        let reference = noise.variance(place.dark[c] + white);
        let (mut mean, mut variance) = ([0.0; CLASSES], [0.0; CLASSES]);
        for k in 0..CLASSES {
            let r = responses.r.get(k).map_or(0.0, |r| r[c]);
            mean[k] = r * white;
            let shot = noise.variance(place.dark[c] + mean[k]) + r * r * reference;
            variance[k] = responses.excess * shot + (LIGHT_ERROR * mean[k]).powi(2);
        }
        // both halves of the square, so that the compiler takes several b at a time
        for a in 0..CLASSES {
            for b in 0..CLASSES {
                let apart = mean[a] - mean[b];
                squared[a][b] += 2.0 * apart * apart / (variance[a] + variance[b]);
            }
        }
    }
    squared
}

/// Q(d/2) for the middle of each entry of distance, Q the tail of the normal distribution.
fn error_table() -> Vec<f32> {
    (0..ENTRIES)
        .map(|entry| tail((entry as f64 + 0.5) / f64::from(STEPS) / 2.0) as f32)
        .collect()
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
