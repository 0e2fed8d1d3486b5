//! The ridges of one family in order, without those that are faint beside the lines around them.

use super::{
    LineSettings,
    ridges::{Ridge, Strip, WEAK_SHARE},
};

/// Where samples lie.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Lattice {
    /// Samples along the lines.
    pub(super) along: usize,
    /// The picture's size across, in camera pixels.
    pub(super) across_px: usize,
    /// From sample to sample, in camera pixels.
    pub(super) spacing_px: usize,
}

/// The ridges of one family, kept between frames: for each sample along the lines those across, in order.
#[derive(Debug, Default)]
pub(super) struct RidgeRows {
    /// Where each sample's ridges begin in `all`, and one past the last.
    starts: Vec<usize>,
    all: Vec<Ridge>,
    pub(super) strips: Vec<Strip>,
    tiles: Vec<Vec<f32>>,
}

impl RidgeRows {
    /// Samples along the lines.
    pub(super) fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The ridges of one sample, sorted by position across.
    pub(super) fn row(&self, sample: usize) -> &[Ridge] {
        &self.all[self.starts[sample]..self.starts[sample + 1]]
    }

    /// Sorts what the strips found by the sample along; across it is in order already. Drops the faint ones.
    pub(super) fn gather(&mut self, lattice: Lattice, settings: &LineSettings) {
        let along = lattice.along;
        self.starts.clear();
        self.starts.resize(along + 1, 0);
        let found = || self.strips.iter().flat_map(|strip| &strip.found);
        for &(at, _) in found() {
            self.starts[at as usize + 1] += 1;
        }
        for at in 0..along {
            self.starts[at + 1] += self.starts[at];
        }
        self.all.clear();
        let blank = Ridge {
            across: 0.0,
            strength: 0.0,
            strong: false,
        };
        self.all.resize(self.starts[along], blank);
        for &(at, ridge) in found() {
            let start = &mut self.starts[at as usize];
            self.all[*start] = ridge;
            *start += 1; // now the end of its sample, which is the start of the next
        }
        self.starts.copy_within(0..along, 1);
        if let Some(first) = self.starts.first_mut() {
            *first = 0;
        }
        self.compare_with_neighbourhood(lattice, settings);
    }

    fn compare_with_neighbourhood(&mut self, lattice: Lattice, settings: &LineSettings) {
        let side = settings.tile_px.clamp(8, 512);
        let columns = lattice.across_px.div_ceil(side).max(1);
        let tile = |ridge: &Ridge| (ridge.across as usize / side).min(columns - 1);
        let share = settings.share_of_local as f32;
        let most = columns.max(self.tiles.len()); // the other family may need more of them
        self.tiles.resize_with(most, Vec::new);
        let mut kept = 0;
        let samples = side.div_ceil(lattice.spacing_px.max(1));
        for band in (0..self.len()).step_by(samples) {
            let rows = band..(band + samples).min(self.len());
            let range = self.starts[rows.start]..self.starts[rows.end];
            self.tiles.iter_mut().for_each(Vec::clear);
            for ridge in self.all[range].iter().filter(|ridge| ridge.strong) {
                self.tiles[tile(ridge)].push(ridge.strength);
            }
            for strengths in &mut self.tiles {
                upper_quartile_first(strengths);
            }
            for row in rows {
                let range = self.starts[row]..self.starts[row + 1];
                self.starts[row] = kept;
                for at in range {
                    let mut ridge = self.all[at];
                    let limit = share * self.tiles[tile(&ridge)].first().unwrap_or(&0.0);
                    ridge.strong &= ridge.strength > limit;
                    if ridge.strength > WEAK_SHARE * limit {
                        self.all[kept] = ridge;
                        kept += 1;
                    }
                }
            }
        }
        if let Some(last) = self.starts.last_mut() {
            *last = kept;
        }
    }
}

/// Puts the upper quartile of some values in the first place.
fn upper_quartile_first(values: &mut [f32]) {
    let at = values.len() * 3 / 4;
    if at < values.len() {
        values.select_nth_unstable_by(at, f32::total_cmp);
        values.swap(0, at);
    }
}
