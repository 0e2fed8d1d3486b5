//! From all that the frames say to the choice with its scores and reasons.

use shared::pattern::{Axis, Grid, RasterSize, Rgb};

use super::{
    ColourScore, ColourSelection, ColourSet, ColourTrial, Shots, TILES, TileScore,
    judge::Judged,
    reasons::{Grounds, sentences},
    recovery::Recovered,
    separability::Errors,
    sets::{Set, expected_error, is_worth_changing, members_of, symbol_order},
};

/// How many sets the ranking holds.
const RANKED: usize = 5;
/// Expected error when nothing could be measured: three of four colours by chance.
pub(super) const UNKNOWN_ERROR: f64 = 0.75;

/// All that the frames say.
pub(super) struct Evidence<'a> {
    pub trial: &'a ColourTrial,
    /// At least four different colours.
    pub shots: Vec<Shots<'a>>,
    pub judged: Judged,
    /// In the order of the shots.
    pub recovered: Vec<Recovered>,
}

impl Evidence<'_> {
    pub(super) fn select(
        &self,
        grid: &Grid,
        raster: RasterSize,
        current: Option<[Rgb; 4]>,
    ) -> ColourSelection {
        let separability = &self.judged.predicted.separability;
        let best = self.judged.ranking[0];
        let in_use = current.and_then(|colours| self.set_in_use(colours));
        let kept = in_use
            .as_ref()
            .filter(|(set, _)| !self.judged.measured || !is_worth_changing(set, &best));
        let (set, chosen) = kept
            .cloned()
            .unwrap_or_else(|| (best, self.in_symbol_order(&best)));
        let thesis_choice = self.in_symbol_order(&self.most_recovered());
        let ranking = self.judged.ranking.iter().take(RANKED);
        let mut selection = ColourSelection {
            best: chosen.colours,
            unary: self.unary(),
            expected_error: chosen.expected_error,
            measured: self.judged.measured,
            changed: current.is_some_and(|colours| colours != chosen.colours),
            colours: self.scores(self.expected_px(grid, raster)),
            separability: separability.clone(),
            ranking: ranking.map(|set| self.in_symbol_order(set)).collect(),
            thesis_choice,
            current: in_use.map(|(_, named)| named),
            tiles: self.tiles(&set),
            reasons: Vec::new(),
        };
        selection.reasons = sentences(&Grounds {
            selection: &selection,
            chosen: &chosen,
            hardest: self.hardest_pair(&set),
            dimmest: self.dimmest(&set),
            noise: self.judged.noise,
            references: (!self.trial.black.is_empty(), !self.trial.white.is_empty()),
            clipped: self.judged.clipped,
        });
        selection
    }

    fn named(&self, set: &Set, order: [usize; 4]) -> ColourSet {
        ColourSet {
            colours: order.map(|k| self.shots[k].entry.colour),
            names: order.map(|k| self.shots[k].entry.name.clone()),
            expected_error: if self.judged.measured {
                set.error.min(1.0)
            } else {
                UNKNOWN_ERROR
            },
            least_distance: set.distance,
        }
    }

    fn in_symbol_order(&self, set: &Set) -> ColourSet {
        let separability = &self.judged.predicted.separability;
        self.named(set, symbol_order(set, separability))
    }

    /// The set in use, its colours left in their order.
    fn set_in_use(&self, colours: [Rgb; 4]) -> Option<(Set, ColourSet)> {
        let tried: Vec<Rgb> = self.shots.iter().map(|shot| shot.entry.colour).collect();
        let members = members_of(colours, &tried)?;
        let set = Set::new(members, &self.judged.predicted.separability);
        let order = colours.map(|colour| tried.iter().position(|t| *t == colour).unwrap_or(0));
        Some((set, self.named(&set, order)))
    }

    fn most_recovered(&self) -> Set {
        let mut order: Vec<usize> = (0..self.shots.len()).collect();
        order.sort_by_key(|&k| std::cmp::Reverse(self.recovered[k].count));
        let mut members = [order[0], order[1], order[2], order[3]];
        members.sort_unstable();
        Set::new(members, &self.judged.predicted.separability)
    }

    /// The colour whose lines are found best; of equals the earlier.
    fn unary(&self) -> Rgb {
        let errors = &self.judged.predicted.line_error_px;
        let best = (0..self.shots.len()).min_by(|&a, &b| errors[a].total_cmp(&errors[b]));
        best.map_or(Rgb::WHITE, |k| self.shots[k].entry.colour)
    }

    /// Camera pixels that the grid should cover: its share of the raster, of the pixels that light reaches.
    fn expected_px(&self, grid: &Grid, raster: RasterSize) -> f64 {
        let free = |axis: Axis| {
            let pitch = grid.pitch_px(axis, raster).max(1e-9);
            (1.0 - f64::from(grid.width_px(axis)) / pitch).clamp(0.0, 1.0)
        };
        let lit = &self.judged.predicted.lit;
        let lit = if self.trial.white.is_empty() || lit.is_empty() {
            1.0
        } else {
            lit.iter().sum::<f64>() / lit.len() as f64
        };
        let (width, height) = self.shots[0].frames[0].dimensions();
        let covered = 1.0 - free(Axis::Row) * free(Axis::Column);
        covered * lit * f64::from(width) * f64::from(height)
    }

    fn scores(&self, expected_px: f64) -> Vec<ColourScore> {
        let score = |(k, shot): (usize, &Shots<'_>)| ColourScore {
            name: shot.entry.name.clone(),
            colour: shot.entry.colour,
            recovered_px: self.recovered[k].count,
            share_of_expected: self.recovered[k].count as f64 / expected_px.max(1.0),
            hue_histogram: self.recovered[k].hue_histogram.clone(),
            response: self.judged.responses.r[k].map(f64::from),
            line_error_px: self.judged.predicted.line_error_px[k],
        };
        self.shots.iter().enumerate().map(score).collect()
    }

    fn hardest_pair(&self, set: &Set) -> (&str, &str, f64) {
        let error = &self.judged.predicted.separability.error;
        let [a, b, c, d] = set.members;
        let pairs = [(a, b), (a, c), (a, d), (b, c), (b, d), (c, d)];
        let worst = pairs
            .into_iter()
            .max_by(|m, n| error[m.0][m.1].total_cmp(&error[n.0][n.1]))
            .unwrap_or((a, b));
        let name = |k: usize| self.shots[k].entry.name.as_str();
        (name(worst.0), name(worst.1), error[worst.0][worst.1])
    }

    fn dimmest(&self, set: &Set) -> (&str, f64) {
        let lost = &self.judged.predicted.separability.dark_error;
        let [first, ..] = set.members;
        let worse = |a: usize, b: &usize| if lost[*b] > lost[a] { *b } else { a };
        let worst = set.members.iter().fold(first, worse);
        (&self.shots[worst].entry.name, lost[worst])
    }

    fn tiles(&self, set: &Set) -> Vec<TileScore> {
        let (width, height) = self.shots[0].frames[0].dimensions();
        let edge = |k: usize, tiles: usize, length: u32| (k * length as usize / tiles) as u32;
        let predicted = &self.judged.predicted;
        let tile = |(n, tile): (usize, &Option<Errors>)| {
            let (column, row) = (n % TILES.0, n / TILES.0);
            let (x_px, y_px) = (edge(column, TILES.0, width), edge(row, TILES.1, height));
            let error = |tile: &Errors| expected_error(set.members, &tile.pairs, &tile.dark);
            let seen = |tile: &Errors| tile.dark.iter().map(|lost| 1.0 - lost).collect();
            TileScore {
                x_px,
                y_px,
                width_px: edge(column + 1, TILES.0, width) - x_px,
                height_px: edge(row + 1, TILES.1, height) - y_px,
                lit: predicted.lit[n],
                expected_error: tile.as_ref().map(|tile| error(tile).min(1.0)),
                seen: tile.as_ref().map_or_else(Vec::new, seen),
            }
        };
        predicted.tiles.iter().enumerate().map(tile).collect()
    }
}
