//! Where the scene has changed since its references were captured.
//!
//! Takes the references and the grid captures, gives the tiles in which they do not belong together. The grid
//! adds light, so nothing may be much darker than under black projection, and the dark cells between the lines
//! get only a little scattered light. A tile where the darkest quarter of the pixels breaks either rule is read as if
//! nothing had been captured there. A change that keeps a tile's light (a plain surface that moves along itself) is not
//! seen, and does no harm.

use image::RgbImage;

use super::{
    reference::References,
    region::Region,
    response::{CLIPPED_LIGHT, Light, Response},
};

/// Tiles across a picture, about: they grow with the camera's size, as everything in its pictures does.
const TILES_ACROSS: usize = 20;
/// Pixels looked at along each side of a tile.
const LOOKS: usize = 6;
/// Smallest distance of the pixels that are looked at.
const LEAST_STEP: usize = 5;
/// Standard deviations of noise that count as a difference.
const SIGMAS: f32 = 4.0;
/// Share of white light that may be scattered into a dark cell.
const SCATTERED: f32 = 0.25;
/// Share of white light by which compression and sharpening darken what lies beside a line.
const RINGING: f32 = 0.05;

/// What to expect of the dark cells of a scene, at a lattice of its pixels: made once from the references.
#[derive(Debug, Default)]
pub(super) struct DarkCells {
    columns: usize,
    side: usize,
    /// [`LOOKS`] squared for each tile.
    expected: Vec<Expected>,
    /// Share of one frame's variance in black's.
    black_share: f32,
    looks: Vec<Look>,
}

/// What a pixel of a dark cell may give back, per channel.
#[derive(Debug, Clone, Copy)]
struct Expected {
    /// Number of the pixel, row by row.
    at: u32,
    black: [f32; 3],
    /// Least and most light above black without noise.
    range: [[f32; 3]; 2],
    /// Standard deviation of one frame's noise.
    sigma: [f32; 3],
    /// One over it.
    per_sigma: [f32; 3],
}

/// How a pixel compares with what is expected.
#[derive(Debug, Clone, Copy)]
struct Look {
    /// Light above black in standard deviations of one frame's noise, summed over channels.
    above: f32,
    /// Whether it can't be a dark cell of the scene that the references show.
    differs: bool,
}

impl DarkCells {
    /// What the references let expect; nothing without black.
    pub(super) fn new(references: &References) -> Self {
        let Some(black) = &references.black else {
            return Self::default();
        };
        let (width, height) = (black.width(), black.height());
        let step = (width / (TILES_ACROSS * LOOKS)).max(LEAST_STEP);
        let side = LOOKS * step;
        let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
        let mut expected = Vec::with_capacity(columns * rows * LOOKS * LOOKS);
        for tile in 0..columns * rows {
            for look in 0..LOOKS * LOOKS {
                let x = tile % columns * side + look % LOOKS * step;
                let y = tile / columns * side + look / LOOKS * step;
                // a tile at the border looks at its last pixels again
                let (x, y) = (x.min(width - 1), y.min(height - 1));
                expected.push(Expected::at(references, black, (x, y)));
            }
        }
        Self {
            columns,
            side,
            expected,
            black_share: 1.0 / black.repeats.max(1) as f32,
            looks: Vec::new(),
        }
    }

    /// The tiles in which the captures of a grid do not fit.
    pub(super) fn find_stale(
        &mut self,
        response: &Response,
        grid: &[RgbImage],
        stale: &mut StaleTiles,
    ) {
        let noise = (1.0 / grid.len().max(1) as f32 + self.black_share).sqrt();
        (stale.columns, stale.side) = (self.columns, self.side);
        stale.tiles.clear();
        for tile in self.expected.chunks_exact(LOOKS * LOOKS) {
            self.looks.clear();
            let looks = tile.iter().map(|expected| {
                expected.compare(response.light_at(grid, expected.at as usize), noise)
            });
            self.looks.extend(looks);
            let differ = self.looks.iter().filter(|look| look.differs).count();
            // few of them can't be most of the darkest
            stale
                .tiles
                .push(2 * differ > QUARTER && is_stale(&mut self.looks));
        }
    }
}

impl Expected {
    fn at(references: &References, black: &Light, (x, y): (usize, usize)) -> Self {
        let at = y * black.width() + x;
        let blacks = black.channels.at(at);
        let white = references.white.as_ref();
        let whites = white.map(|white| white.at(at));
        let sigma = [0, 1, 2].map(|c| references.noise.variance(c, blacks[c]).sqrt().max(1e-6));
        Self {
            at: at as u32,
            black: blacks,
            range: match whites {
                Some(whites) => {
                    [-RINGING, SCATTERED].map(|share| whites.map(|white| share * white))
                }
                // without a white reference light may be as bright as it likes
                None => [[0.0; 3], [f32::MAX; 3]],
            },
            sigma,
            per_sigma: sigma.map(|sigma| 1.0 / sigma),
        }
    }

    /// Compares light whose noise is so many times that of one frame.
    #[inline]
    fn compare(&self, light: [f32; 3], noise: f32) -> Look {
        let [least, most] = &self.range;
        let mut look = Look {
            above: 0.0,
            differs: false,
        };
        for c in 0..3 {
            let known = light[c] < CLIPPED_LIGHT;
            let above = light[c] - self.black[c];
            let spread = SIGMAS * noise * self.sigma[c];
            let far = (above < least[c] - spread) | (above > most[c] + spread);
            look.differs |= far & known;
            look.above += if known {
                above * self.per_sigma[c]
            } else {
                0.0
            };
        }
        look
    }
}

/// A quarter of the looks at one tile.
const QUARTER: usize = LOOKS * LOOKS / 4;

/// Whether most of the darkest quarter differs.
fn is_stale(looks: &mut [Look]) -> bool {
    looks.select_nth_unstable_by(QUARTER, |a, b| a.above.total_cmp(&b.above));
    let differ = looks[..QUARTER].iter().filter(|look| look.differs).count();
    2 * differ > QUARTER
}

/// Tiles of a picture, row by row.
#[derive(Debug, Default)]
pub(super) struct StaleTiles {
    columns: usize,
    side: usize,
    tiles: Vec<bool>,
}

impl StaleTiles {
    /// Makes it like another one, in the memory that it has.
    pub(super) fn copy(&mut self, other: &Self) {
        (self.columns, self.side) = (other.columns, other.side);
        self.tiles.clone_from(&other.tiles);
    }

    /// Whether any tile is stale.
    pub(super) fn any(&self) -> bool {
        self.tiles.contains(&true)
    }

    /// Whether a pixel lies in a stale tile.
    pub(super) fn holds(&self, x: usize, y: usize) -> bool {
        let tile = |at: usize| at.checked_div(self.side).unwrap_or(0);
        let tile = tile(y) * self.columns + tile(x);
        self.tiles.get(tile).copied().unwrap_or(false)
    }

    /// The stale parts of a picture of the given width and height that are not stale among the `others`.
    pub(super) fn regions_without(
        &self,
        others: &Self,
        (width, height): (usize, usize),
        regions: &mut Vec<Region>,
    ) {
        regions.clear();
        let stale = self.tiles.iter().enumerate().filter(|(_, stale)| **stale);
        let left = stale.filter(|(tile, _)| others.tiles.get(*tile) != Some(&true));
        let pixels = |at: usize, length: usize| {
            (at * self.side).min(length)..((at + 1) * self.side).min(length)
        };
        regions.extend(left.map(|(tile, _)| Region {
            columns: pixels(tile % self.columns, width),
            rows: pixels(tile / self.columns, height),
        }));
    }
}
