//! Captures of solid colours, reduced to what the measurement needs.
//!
//! Takes pictures one by one and keeps the mean bytes of blocks of 8 x 8 pixels, which are JPEG's own blocks and
//! average the mosaic's colours; the picture itself can go. A block counts only where it is even: the curve of a mean
//! is not the mean of a curve.

use std::collections::BTreeMap;

use image::RgbImage;
use shared::pattern::Rgb;

/// Side of a block, camera px.
const BLOCK: usize = 8;
/// Largest standard deviation within an even block, byte values; noise included.
const EVEN_LEVELS: f32 = 7.0;
/// Brighter bytes may be cut off by the camera. Those cut off at 0 stand for hardly any light.
const BRIGHTEST: u8 = 249;

/// The greys of a ramp, as drive values of the projector: enough to see the shape of the curve at every
/// brightness of the scene.
const GREYS: [u8; 5] = [48, 88, 128, 168, 208];
/// The primaries, and below each pair what both together give.
pub(super) const PRIMARIES: [Rgb; 3] = [Rgb([255, 0, 0]), Rgb([0, 255, 0]), Rgb([0, 0, 255])];
/// Sums of two primaries: red + green, red + blue, green + blue.
pub(super) const SUMS: [([usize; 2], Rgb); 3] = [
    ([0, 1], Rgb([255, 255, 0])),
    ([0, 2], Rgb([255, 0, 255])),
    ([1, 2], Rgb([0, 255, 255])),
];

/// The solid colours that the response is measured with, besides black and white, in the order of recording: bright
/// and dark by turns, so that each frame is told from the one before.
#[must_use]
pub fn ramp_colours() -> Vec<Rgb> {
    let [a, b, c, d, e] = GREYS.map(|grey| Rgb([grey; 3]));
    let [red, green, blue] = PRIMARIES;
    let [yellow, magenta, cyan] = SUMS.map(|(_, colour)| colour);
    vec![e, a, yellow, blue, d, red, cyan, b, magenta, green, c]
}

/// Mean bytes of the blocks of a picture, per channel; not a number where a block is uneven or cut off.
pub(super) type Blocks = Vec<[f32; 3]>;

/// What was seen of solid colours in one scene that stood still.
#[derive(Debug, Clone, Default)]
pub struct SolidCaptures {
    /// Sum over repeats, and their number.
    shots: BTreeMap<Rgb, (Blocks, usize)>,
}

impl SolidCaptures {
    /// Adds a capture. One of another size than the first of its colour is left out.
    pub fn add(&mut self, colour: Rgb, picture: &RgbImage) {
        let blocks = blocks(picture);
        let (sum, count) = self
            .shots
            .entry(colour)
            .or_insert_with(|| (vec![[0.0; 3]; blocks.len()], 0));
        if sum.len() == blocks.len() {
            *count += 1;
            for (sum, block) in sum.as_flattened_mut().iter_mut().zip(blocks.as_flattened()) {
                *sum += block;
            }
        }
    }

    /// The greys seen, black and white left out.
    pub(super) fn greys(&self) -> impl Iterator<Item = u8> + '_ {
        self.shots.keys().filter_map(|colour| {
            let [r, g, b] = colour.0;
            (r == g && g == b && r > 0 && r < 255).then_some(r)
        })
    }

    /// The mean bytes of all blocks under a colour; `None` when it was not seen.
    pub(super) fn means(&self, colour: Rgb) -> Option<Blocks> {
        let (sum, count) = self.shots.get(&colour)?;
        let share = 1.0 / (*count).max(1) as f32;
        Some(sum.iter().map(|block| block.map(|v| v * share)).collect())
    }
}

fn blocks(picture: &RgbImage) -> Blocks {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let bytes = picture.as_raw();
    let mut blocks = Vec::with_capacity(width / BLOCK * (height / BLOCK));
    for top in (0..height / BLOCK).map(|k| k * BLOCK) {
        for left in (0..width / BLOCK).map(|k| k * BLOCK) {
            let rows = (top..top + BLOCK).map(|y| &bytes[3 * (y * width + left)..][..3 * BLOCK]);
            blocks.push(block_mean(rows));
        }
    }
    blocks
}

fn block_mean<'a>(rows: impl Iterator<Item = &'a [u8]>) -> [f32; 3] {
    let (mut sum, mut squares, mut seen) = ([0_u32; 3], [0_u32; 3], [true; 3]);
    for pixel in rows.flat_map(|row| row.chunks_exact(3)) {
        for c in 0..3 {
            let byte = u32::from(pixel[c]);
            sum[c] += byte;
            squares[c] += byte * byte;
            seen[c] &= pixel[c] <= BRIGHTEST;
        }
    }
    let count = (BLOCK * BLOCK) as f32;
    std::array::from_fn(|c| {
        let mean = sum[c] as f32 / count;
        let variance = squares[c] as f32 / count - mean * mean;
        if seen[c] && variance < EVEN_LEVELS * EVEN_LEVELS {
            mean
        } else {
            f32::NAN
        }
    })
}
