//! Slowly varying levels: one per tile, bilinear between the tiles' centres.
//!
//! Serves levels that the stages need locally: the dark between lines, the strength of lines. A change within a tile
//! (an edge between two surfaces) is smoothed over one tile. Tiles are found where they are asked for, in memory that
//! stays from frame to frame.

use super::region::Region;

/// `N` levels for each square tile of a picture.
#[derive(Debug, Clone)]
pub(super) struct Tiles<const N: usize> {
    /// Of the picture, px.
    size: (usize, usize),
    side: usize,
    columns: usize,
    rows: usize,
    /// `None` until found.
    levels: Vec<Option<[f32; N]>>,
    samples: [Vec<f32>; N],
}

impl<const N: usize> Default for Tiles<N> {
    fn default() -> Self {
        Self {
            size: (0, 0),
            side: 1,
            columns: 0,
            rows: 0,
            levels: Vec::new(),
            samples: std::array::from_fn(|_| Vec::new()),
        }
    }
}

impl<const N: usize> Tiles<N> {
    /// Tiles of `side` pixels over a picture of the given width and height; no level is known yet.
    pub(super) fn cover(&mut self, (width, height): (usize, usize), side: usize) {
        self.size = (width, height);
        self.side = side.clamp(4, 4096);
        (self.columns, self.rows) = (width.div_ceil(self.side), height.div_ceil(self.side));
        self.levels.clear();
        self.levels.resize(self.columns * self.rows, None);
    }

    /// Finds the levels that a part of the picture needs: of each tile the quantile `share` (0 to 1) of what `sample`
    /// gives for every second pixel of every second row.
    pub(super) fn find(
        &mut self,
        region: &Region,
        share: f64,
        sample: impl Fn(usize, usize) -> [f32; N],
    ) {
        if region.is_empty() || self.levels.is_empty() {
            return;
        }
        let (width, height) = self.size;
        let tiles = |pixels: &std::ops::Range<usize>, count| {
            cell(pixels.start, self.side, count).before
                ..=cell(pixels.end - 1, self.side, count).after
        };
        let (across, down) = (
            tiles(&region.columns, self.columns),
            tiles(&region.rows, self.rows),
        );
        for ty in down {
            for tx in across.clone() {
                if self.levels[ty * self.columns + tx].is_some() {
                    continue;
                }
                self.samples.iter_mut().for_each(Vec::clear);
                for y in (ty * self.side..((ty + 1) * self.side).min(height)).step_by(2) {
                    for x in (tx * self.side..((tx + 1) * self.side).min(width)).step_by(2) {
                        let samples = self.samples.iter_mut().zip(sample(x, y));
                        samples.for_each(|(all, sample)| all.push(sample));
                    }
                }
                let level = self.samples.each_mut().map(|all| quantile(all, share));
                self.levels[ty * self.columns + tx] = Some(level);
            }
        }
    }

    /// Tells the levels at the middles of some neighbouring pixels of a row, one after the other; 0 where no tile was
    /// found.
    pub(super) fn row(
        &self,
        y: usize,
        columns: std::ops::Range<usize>,
        mut tell: impl FnMut(usize, [f32; N]),
    ) {
        if self.levels.is_empty() {
            return;
        }
        let down = cell(y, self.side, self.rows);
        let level = |row: usize, column: usize| {
            self.levels[row * self.columns + column].unwrap_or([0.0; N])
        };
        for x in columns {
            let across = cell(x, self.side, self.columns);
            let at = |row| {
                mix(
                    level(row, across.before),
                    level(row, across.after),
                    across.way,
                )
            };
            tell(x, mix(at(down.before), at(down.after), down.way));
        }
    }
}

/// Between which tiles' centres a pixel's middle lies, along one axis.
struct Cell {
    before: usize,
    after: usize,
    /// The way to the second one, 0 to 1.
    way: f32,
}

#[inline]
fn cell(pixel: usize, side: usize, count: usize) -> Cell {
    let from_first = (pixel as f32 + 0.5) / side as f32 - 0.5;
    let from_first = from_first.clamp(0.0, (count - 1) as f32);
    let before = (from_first as usize).min(count - 1);
    Cell {
        before,
        after: (before + 1).min(count - 1),
        way: from_first - before as f32,
    }
}

#[inline]
fn mix<const N: usize>(a: [f32; N], b: [f32; N], way: f32) -> [f32; N] {
    std::array::from_fn(|k| a[k] + way * (b[k] - a[k]))
}

fn quantile(samples: &mut [f32], share: f64) -> f32 {
    let at = (share * samples.len() as f64) as usize;
    match samples.len().checked_sub(1) {
        None => 0.0,
        Some(last) => {
            *samples
                .select_nth_unstable_by(at.min(last), f32::total_cmp)
                .1
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (64, 48);

    #[test]
    fn a_level_is_found_beside_bright_lines_and_only_where_it_is_asked_for() {
        let mut tiles = Tiles::default();
        tiles.cover(SIZE, 16);
        let sample = |x: usize, _| [if x % 16 == 4 { 1.0 } else { 0.2 }];
        tiles.find(
            &Region {
                columns: 0..20,
                rows: 0..48,
            },
            0.25,
            sample,
        );
        let levels = |columns| {
            let mut levels = Vec::new();
            tiles.row(40, columns, |_, [level]| levels.push(level));
            levels
        };
        assert!(
            levels(0..20)
                .iter()
                .all(|&level| (level - 0.2).abs() < 1e-6)
        );
        assert_eq!(levels(60..64), [0.0; 4]);
    }

    #[test]
    fn levels_change_evenly_between_the_middles_of_tiles() {
        let mut tiles = Tiles::default();
        tiles.cover(SIZE, 16);
        tiles.find(&Region::whole(SIZE), 0.5, |x, _| [(x / 16) as f32]);
        let mut levels = Vec::new();
        tiles.row(0, 0..64, |_, [level]| levels.push(level));
        assert_eq!(levels[..8], [0.0; 8]);
        assert_eq!(levels[56..], [3.0; 8]);
        let steps = levels[8..56].windows(2).map(|pair| pair[1] - pair[0]);
        assert!(
            steps
                .into_iter()
                .all(|step| (step - 1.0 / 16.0).abs() < 1e-5)
        );
    }

    #[test]
    fn a_picture_smaller_than_a_tile_has_one_tile() {
        let mut tiles = Tiles::default();
        tiles.cover((1, 1), 32);
        tiles.find(&Region::whole((1, 1)), 0.5, |_, _| [0.5]);
        tiles.row(0, 0..1, |_, level| assert_eq!(level, [0.5]));
        tiles.cover((0, 0), 32);
        tiles.row(0, 0..0, |_, _| {
            panic!("a picture without pixels has no levels")
        });
    }
}
