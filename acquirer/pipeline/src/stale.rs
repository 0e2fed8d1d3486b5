//! Where the scene has changed since its references were captured.
//!
//! Takes the references and the grid captures, gives the tiles in which they do not belong together. The grid
//! adds light, so nothing may be much darker than under black projection, and the dark cells between the lines
//! get only a little scattered light. In a tile where the darkest quarter of the pixels breaks either rule, black
//! is read from the dark cells and white from the unary grid, as if nothing had been captured there. A change
//! that keeps a tile's light (a plain surface that moves along itself) is not seen, and does no harm.

use image::RgbImage;

use super::{
    plane::Plane,
    reference::References,
    response::{CLIPPED_LIGHT, Light, Response},
};

/// Side of a tile, in camera pixels.
const TILE: usize = 32;
/// Every so many pixels, in both directions, are looked at.
const STEP: usize = 5;
/// Standard deviations of noise that count as a difference.
const SIGMAS: f32 = 4.0;
/// Share of white light that may be scattered into a dark cell.
const SCATTERED: f32 = 0.25;

/// Share of white light by which compression and sharpening darken what lies beside a line.
const RINGING: f32 = 0.05;

/// Tiles of a picture, row by row.
#[derive(Debug, Clone, Default)]
pub(super) struct StaleTiles {
    columns: usize,
    tiles: Vec<bool>,
}

impl StaleTiles {
    /// The tiles in which the references do not fit the captures of a grid. None without black.
    pub(super) fn find(references: &References, response: &Response, grid: &[RgbImage]) -> Self {
        let Some(black) = &references.black else {
            return Self::default();
        };
        let (width, height) = (black.width(), black.height());
        let (columns, rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let looker = Looker {
            references,
            black,
            response,
            grid,
        };
        let mut pixels = Vec::new();
        let tiles = (0..columns * rows)
            .map(|tile| {
                let (x, y) = (tile % columns * TILE, tile / columns * TILE);
                pixels.clear();
                for y in (y..(y + TILE).min(height)).step_by(STEP) {
                    for x in (x..(x + TILE).min(width)).step_by(STEP) {
                        pixels.push(looker.look(x, y));
                    }
                }
                is_stale(&mut pixels)
            })
            .collect();
        Self { columns, tiles }
    }

    /// Whether any tile is stale.
    pub(super) fn any(&self) -> bool {
        self.tiles.contains(&true)
    }

    /// Whether a pixel lies in a stale tile.
    pub(super) fn holds(&self, x: usize, y: usize) -> bool {
        let tile = y / TILE * self.columns + x / TILE;
        self.tiles.get(tile).copied().unwrap_or(false)
    }

    /// The references with black and white light of the stale tiles from elsewhere.
    pub(super) fn mend(
        &self,
        references: &References,
        black: &Light,
        white: &[Plane; 3],
    ) -> References {
        let mut mended = references.clone();
        for c in 0..3 {
            if let Some(light) = &mut mended.black {
                self.replace(&mut light.channels[c], &black.channels[c]);
            }
            if let Some(planes) = &mut mended.white {
                self.replace(&mut planes[c], &white[c]);
            }
        }
        mended
    }

    fn replace(&self, plane: &mut Plane, other: &Plane) {
        let width = plane.width();
        for (at, value) in plane.values_mut().iter_mut().enumerate() {
            if self.holds(at % width, at / width) {
                *value = other.values()[at];
            }
        }
    }
}

/// How a pixel compares with the references.
#[derive(Debug, Clone, Copy)]
struct Compared {
    /// Light above black in standard deviations, summed over channels.
    above: f32,
    /// Whether it can't be a dark cell of the scene that the references show.
    differs: bool,
}

struct Looker<'a> {
    references: &'a References,
    black: &'a Light,
    response: &'a Response,
    grid: &'a [RgbImage],
}

impl Looker<'_> {
    fn look(&self, x: usize, y: usize) -> Compared {
        let light = self.response.light_at(self.grid, x, y);
        let at = y * self.black.width() + x;
        let shares = [self.grid.len(), self.black.repeats].map(|n| 1.0 / n.max(1) as f32);
        let mut compared = Compared {
            above: 0.0,
            differs: false,
        };
        for c in (0..3).filter(|&c| light[c] < CLIPPED_LIGHT) {
            let black = self.black.channels[c].values()[at];
            let variance = self.references.noise.variance(c, black) * (shares[0] + shares[1]);
            let sigma = variance.sqrt().max(1e-6);
            let above = light[c] - black;
            let white = self.references.white.as_ref();
            let (least, most) = white.map_or((0.0, f32::MAX), |white| {
                let white = white[c].values()[at];
                (RINGING * white, SCATTERED * white)
            });
            compared.above += above / sigma;
            let noise = SIGMAS * sigma;
            compared.differs |= above < -least - noise || above > most + noise;
        }
        compared
    }
}

/// Whether most of the darkest quarter differs.
fn is_stale(pixels: &mut [Compared]) -> bool {
    let quarter = pixels.len() / 4;
    if quarter == 0 {
        return false;
    }
    pixels.select_nth_unstable_by(quarter, |a, b| a.above.total_cmp(&b.above));
    let differ = pixels[..quarter]
        .iter()
        .filter(|pixel| pixel.differs)
        .count();
    2 * differ > quarter
}
