//! The gain image: how much of the light that white projection would give arrives at each pixel.
//!
//! Takes a grid capture and the references, gives one number per pixel, about 1 on a line and 0 beside it
//! whatever the surface's colour, and how far it can be trusted. Matched filter over the channels:
//! g = sum D s/v / (sum s^2/v + lambda), D the light above black, s the light that a line would give
//! ((W - K) x nominal colour), v its squared error; so albedo, cosine, vignetting and ambient light cancel before
//! any edge is looked for (Caspi, Kiryati and Shamir 1998 for the model). lambda pulls pixels without
//! projector light to 0. Where lines are many pixels wide, light is averaged over squares of pixels first: that
//! loses nothing but time. Without W (see `line_light`) the albedo stays in, quietly.

mod filter;
mod power;
mod profile;

use pulp::Arch;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{line_light::LineLight, plane::Plane, wide::wide};
pub(crate) use filter::ChannelError;
pub use filter::GainFilter;
use filter::{Inputs, ROUNDS, RowFilter};
pub use power::PowerPlane;
pub(crate) use power::power_of;
use power::{RowCodes, code_of};
pub(crate) use profile::{Band, ProfileBuffers, find_profile};

/// How the gain image is made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GainSettings {
    /// Pull towards 0 in units of squared signal to noise, 0 to 100: at 4 a pixel with a signal of two
    /// standard deviations counts half.
    pub shrink: f64,
    /// Side of the tiles in which the lines' strength is looked for when there is no white reference, in
    /// camera pixels, 8 to 512. It should hold a piece of a line.
    pub tile_px: usize,
    /// Whether the coded grid's lines are added to the unary grid's: same place, half the noise.
    pub both_grids: bool,
    /// Error of one channel's light beyond its noise, as a share of white light, 0 to 1: what demosaicing
    /// and compression do. It keeps one bright channel from deciding alone.
    pub channel_error: f64,
}

impl Default for GainSettings {
    fn default() -> Self {
        Self {
            shrink: 4.0,
            tile_px: 48,
            both_grids: true,
            channel_error: 0.15,
        }
    }
}

/// Share of white light at each pixel, or each square of pixels.
#[derive(Debug, Clone, Default)]
pub struct GainImage {
    /// About 1 on a line, 0 beside it; whole multiples of 1/2048, so that sums of them are exact.
    pub gain: Plane,
    /// Squared signal to noise of a full line there (sum s^2/v): what the gain can be trusted with.
    pub power: PowerPlane,
    /// Side of the squares that the values stand for, in camera pixels.
    pub bin: usize,
}

impl GainImage {
    /// The gain at a camera pixel.
    #[must_use]
    pub fn at(&self, x: usize, y: usize) -> f32 {
        let row = self.gain.row(y / self.bin.max(1));
        row[(x / self.bin.max(1)).min(row.len() - 1)]
    }

    /// Makes room for a picture of squares of `bin` pixels; what it held is of no use any more.
    fn resize(&mut self, light: &LineLight<'_>, bin: usize) {
        self.bin = bin;
        let (width, height) = (light.width() / bin, light.height() / bin);
        self.gain.resize(width, height);
        self.power.resize(width, height);
    }
}

/// Picture rows that one thread takes at a time.
const STRIP: usize = 16;

/// One row per strip, kept between frames.
#[derive(Debug, Default)]
pub struct GainBuffers {
    strips: Vec<Row>,
}

#[derive(Debug, Default)]
struct Row {
    /// Sums of linear light.
    sums: [Vec<f32>; 3],
    power: Vec<f32>,
}

/// The gain image of lines that may have any of the given colours (linear, 0 to 1 per channel), over squares of
/// `bin` x `bin` pixels, 1 to 8; each square takes the colour that explains it with the most gain.
pub fn find_gain(
    light: &LineLight<'_>,
    filter: &GainFilter,
    bin: usize,
    (buffers, image): (&mut GainBuffers, &mut GainImage),
) {
    image.resize(light, bin);
    let (width, height) = (image.gain.width(), image.gain.height());
    if width == 0 {
        return;
    }
    buffers
        .strips
        .resize_with(height.div_ceil(STRIP), Default::default);
    let mean = filter.mean_of(light.frames.len(), bin * bin);
    let (blacks, whites) = (light.black.channels.coarse(bin), light.white.coarse(bin));
    let strips = image
        .gain
        .values_mut()
        .par_chunks_mut(STRIP * width)
        .zip(image.power.codes_mut().par_chunks_mut(STRIP * width))
        .zip(&mut buffers.strips);
    strips
        .enumerate()
        .for_each(|(strip, ((gain, codes), row))| {
            let Row { sums, power } = row;
            let values = sums.iter_mut().chain([&mut *power]);
            values.for_each(|values| values.resize(width, 0.0));
            let rows = gain.chunks_mut(width).zip(codes.chunks_mut(width));
            for (k, (gain, codes)) in rows.enumerate() {
                let y = strip * STRIP + k;
                light.response.sum_squares(light.frames, (y, bin), sums);
                Arch::new().dispatch(RowFilter {
                    filter,
                    mean,
                    inputs: Inputs {
                        sums: sums.each_ref().map(|channel| &channel[..]),
                        blacks: blacks.each_ref().map(|plane| plane.row(y)),
                        whites: whites.each_ref().map(|plane| plane.row(y)),
                    },
                    gain,
                    power,
                });
                wide(RowCodes {
                    powers: power,
                    codes,
                });
            }
        });
}

/// Adds the gain image of another capture of the same lines. Most of the error is the colour mosaic's, which both
/// share as far as they share channels: so the better one decides, and only equals are averaged.
pub fn merge_gains(a: &mut GainImage, b: &GainImage, settings: &GainSettings) {
    let shrink = settings.shrink.max(1e-6) as f32;
    let first = a.gain.values_mut().par_iter_mut().zip(a.power.codes_mut());
    let second = b.gain.values().par_iter().zip(b.power.codes());
    first.zip(second).for_each(|((gain, code), (&g, &c))| {
        let [power, p] = [*code, c].map(power_of);
        let [own, other] = [power, p].map(|power| (power + shrink) * (power + shrink));
        let both = own + other;
        *gain = (*gain * own + g * other) / both + ROUNDS - ROUNDS;
        *code = code_of((power * own + p * other) / both);
    });
}
