//! How well the camera will tell the colours apart, predicted place by place.
//!
//! Takes the places of a trial with the responses and the noise law. For each place the mean and the
//! variance of every colour's light follow (`distances`), and from them the Mahalanobis distance d between
//! two colours; a reader with a reference mistakes one for the other with probability Q(d/2), and loses a line
//! whose gain stands m standard deviations above the line finder's limit (`visibility`) with probability Q(m).
//! Gives the mean of Q over the scene, its mean by tile, and the distance that nine tenths of the surface exceed.
//! Channels are taken as independent, which a Bayer mosaic and JPEG make optimistic: good for ranking.

use super::{
    Separability, TILES,
    distances::pair_number,
    histograms::{
        Histograms, Optics, sum_of_errors, sum_of_losses, tenth_dark_distance, tenth_distance,
    },
    responses::is_lit,
    samples::{Place, Places},
};

/// Tiles of the scene.
const REGIONS: usize = TILES.0 * TILES.1;

/// What the scene will do to the colours.
#[derive(Debug, Clone, Default)]
pub(super) struct Predicted {
    /// Averages over the scene.
    pub separability: Separability,
    /// Averages by tile, `None` where no light arrives.
    pub tiles: Vec<Option<Errors>>,
    /// Predicted RMS error of a unary line in each colour, camera px.
    pub line_error_px: Vec<f64>,
    /// Share of the places, by tile, that projected light reaches.
    pub lit: Vec<f64>,
}

/// Predicts distances and errors; `None` when no place is lit.
pub(super) fn predict(places: &Places, optics: Optics<'_>) -> Option<Predicted> {
    let mut by_tile: [Vec<&Place>; REGIONS] = Default::default();
    let mut all = [0_usize; REGIONS];
    for place in &places.places {
        all[place.tile] += 1;
        if is_lit(place, optics.noise) {
            by_tile[place.tile].push(place);
        }
    }
    if by_tile.iter().all(Vec::is_empty) {
        return None;
    }
    let histograms = by_tile.iter().map(|lit| Histograms::new(lit, optics));
    let histograms: Vec<Histograms> = histograms.collect();
    let colours = optics.responses.r.len();
    let share = |(lit, all): (&Vec<&Place>, usize)| lit.len() as f64 / all.max(1) as f64;
    let errors = |tile: &Histograms| (tile.places > 0).then(|| Errors::new(tile, colours));
    let tiles: Vec<_> = histograms.iter().map(errors).collect();
    Some(Predicted {
        separability: separability(&tiles, &histograms, colours),
        line_error_px: line_errors(&histograms, colours),
        tiles,
        lit: by_tile.iter().zip(all).map(share).collect(),
    })
}

/// How often colours are mistaken or not seen in a tile, on average.
#[derive(Debug, Clone)]
pub(super) struct Errors {
    /// Probability that a pixel of one is nearer to the other, by pair.
    pub pairs: Vec<Vec<f64>>,
    /// Probability that a line is lost.
    pub dark: Vec<f64>,
}

impl Errors {
    /// For a tile that is not empty.
    fn new(tile: &Histograms, colours: usize) -> Self {
        let places = tile.places as f64;
        let pair = |a, b| sum_of_errors(&tile.distances[pair_number(a, b)]) / places;
        let lost = |k: usize| sum_of_losses(&tile.margins[k]) / places;
        Self {
            pairs: square(colours, pair),
            dark: (0..colours).map(lost).collect(),
        }
    }
}

/// The tables of all tiles together; each counts as much as it has places.
fn separability(
    tiles: &[Option<Errors>],
    histograms: &[Histograms],
    colours: usize,
) -> Separability {
    let places = number_of_places(histograms);
    let mean = |of: &dyn Fn(&Errors) -> f64| {
        let tiles = tiles.iter().flatten();
        let filled = histograms.iter().filter(|h| h.places > 0);
        let sums = tiles
            .zip(filled)
            .map(|(tile, h)| h.places as f64 * of(tile));
        sums.sum::<f64>() / places
    };
    let distance =
        |a, b| tenth_distance(histograms.iter().map(|h| &h.distances[pair_number(a, b)]));
    let dark_distance = |k: usize| tenth_dark_distance(histograms.iter().map(|h| &h.margins[k]));
    Separability {
        error: square(colours, |a, b| mean(&|tile| tile.pairs[a][b])),
        distance: square(colours, distance),
        dark_error: (0..colours).map(|k| mean(&|tile| tile.dark[k])).collect(),
        dark_distance: (0..colours).map(dark_distance).collect(),
    }
}

fn line_errors(tiles: &[Histograms], colours: usize) -> Vec<f64> {
    let places = number_of_places(tiles);
    let squares = |k: usize| tiles.iter().map(|h| h.squared_line_error[k]).sum::<f64>();
    (0..colours).map(|k| (squares(k) / places).sqrt()).collect()
}

fn number_of_places(tiles: &[Histograms]) -> f64 {
    tiles.iter().map(|tile| tile.places).sum::<usize>() as f64
}

/// A symmetric table from a function of a < b, with 0 on its diagonal.
fn square(colours: usize, of: impl Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
    let mut table = vec![vec![0.0; colours]; colours];
    let pairs = (0..colours).flat_map(|a| (a + 1..colours).map(move |b| (a, b)));
    for (a, b) in pairs {
        let value = of(a, b);
        table[a][b] = value;
        table[b][a] = value;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::super::{
        noise::NoiseLaw, responses::Responses, samples::Places, visibility::Visibility,
    };
    use super::*;

    #[test]
    fn tables_are_symmetric_and_a_tile_without_places_has_none() {
        let place = *Places::grey_wall().places.first().unwrap();
        let places = Places {
            places: vec![place; 20],
        };
        let colours = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255; 3]].map(shared::pattern::Rgb);
        let (responses, noise) = (Responses::nominal(&colours), NoiseLaw::COMMON);
        let optics = Optics {
            responses: &responses,
            noise,
            visibility: &Visibility::new(&colours, 4.0, 2, noise),
        };
        let found = predict(&places, optics).unwrap();
        let error = &found.separability.error;
        let pairs = (0..4).flat_map(|a| (0..4).map(move |b| (a, b)));
        for (a, b) in pairs {
            assert_eq!(error[a][b], error[b][a]);
            assert_eq!(error[a][b] == 0.0, a == b);
        }
        assert_eq!(found.tiles[0].as_ref().unwrap().pairs, *error);
        assert!(found.tiles[1..].iter().all(Option::is_none));
        assert_eq!((found.lit[0], found.lit[1]), (1.0, 0.0));
    }
}
