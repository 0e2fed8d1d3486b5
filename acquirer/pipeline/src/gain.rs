//! The gain image: how much of the light that white projection would give arrives at each pixel.
//!
//! Takes a grid capture and the references, gives one number per pixel, about 1 on a line and 0 beside it
//! whatever the surface's colour, and how far it can be trusted. Matched filter over the channels:
//! g = sum D s/v / (sum s^2/v + lambda), D the light above black, s the light that a line would give
//! ((W - K) x nominal colour), v its squared error; so albedo, cosine, vignetting and ambient light cancel before
//! any edge is looked for (Caspi, Kiryati and Shamir 1998 for the model). lambda pulls pixels without
//! projector light to 0. Without W (see `line_light`) the albedo stays in, quietly.

use pulp::NullaryFnOnce;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{convolve::wide, line_light::LineLight, plane::Plane, response::CLIPPED_LIGHT};

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

/// Share of white light at each pixel.
#[derive(Debug, Clone, Default)]
pub struct GainImage {
    /// About 1 on a line, 0 beside it.
    pub gain: Plane,
    /// Squared signal to noise of a full line there (sum s^2/v): what the gain can be trusted with.
    pub power: Plane,
}

/// Picture rows that one thread takes at a time.
const STRIP: usize = 16;

impl GainImage {
    /// Makes room for a picture; what it held is of no use any more.
    fn resize(&mut self, width: usize, height: usize) {
        self.gain.resize(width, height);
        self.power.resize(width, height);
    }
}

/// Linear light of one row per strip, kept between frames.
#[derive(Debug, Default)]
pub struct GainBuffers {
    strips: Vec<[Vec<f32>; 3]>,
}

/// The gain image of lines that may have any of the given colours (linear, 0 to 1 per channel), 16 at most;
/// each pixel takes the colour that explains it with the most gain.
pub fn find_gain(
    light: &LineLight<'_>,
    colours: &[[f32; 3]],
    settings: &GainSettings,
    buffers: &mut GainBuffers,
    image: &mut GainImage,
) {
    match colours.len() {
        0 | 1 => find_gain_of::<1>(light, colours, settings, buffers, image),
        2 => find_gain_of::<2>(light, colours, settings, buffers, image),
        3 | 4 => find_gain_of::<4>(light, colours, settings, buffers, image),
        5..=8 => find_gain_of::<8>(light, colours, settings, buffers, image),
        _ => find_gain_of::<16>(light, colours, settings, buffers, image),
    }
}

fn find_gain_of<const N: usize>(
    light: &LineLight<'_>,
    colours: &[[f32; 3]],
    settings: &GainSettings,
    buffers: &mut GainBuffers,
    image: &mut GainImage,
) {
    let (width, height) = (light.width(), light.height());
    image.resize(width, height);
    if width == 0 {
        return;
    }
    buffers
        .strips
        .resize_with(height.div_ceil(STRIP), Default::default);
    let filter = Filter::<N>::new(light, colours, settings);
    let strips = image
        .gain
        .values_mut()
        .par_chunks_mut(STRIP * width)
        .zip(image.power.values_mut().par_chunks_mut(STRIP * width))
        .zip(&mut buffers.strips);
    strips
        .enumerate()
        .for_each(|(strip, ((gain, power), row))| {
            row.iter_mut()
                .for_each(|channel| channel.resize(width, 0.0));
            let rows = gain.chunks_mut(width).zip(power.chunks_mut(width));
            for (k, (gain, power)) in rows.enumerate() {
                let y = strip * STRIP + k;
                light.response.light_row(light.frames, y, row);
                wide(RowFilter {
                    filter: &filter,
                    light,
                    y,
                    row: &*row,
                    gain,
                    power,
                });
            }
        });
}

/// Errors of red, green and blue relative to each other: a colour mosaic samples green twice as densely.
const BAYER_ERROR: [f64; 3] = [1.0, 0.5, 1.0];

/// The matched filter over the channels, for `N` colours.
struct Filter<const N: usize> {
    /// Linear responses; the first colour fills what is left.
    colours: [[f32; 3]; N],
    shrink: f32,
    channels: [ChannelError; 3],
}

/// The squared error of one channel's light above black, for a capture of half of white's light:
/// `floor + of_black K + of_white s + of_square s^2`.
#[derive(Debug, Clone, Copy)]
struct ChannelError {
    floor: f32,
    of_black: f32,
    of_white: f32,
    of_square: f32,
}

impl<const N: usize> Filter<N> {
    fn new(light: &LineLight<'_>, colours: &[[f32; 3]], settings: &GainSettings) -> Self {
        let first = colours.first().copied().unwrap_or([1.0; 3]);
        let [_, black_share] = light.shares();
        let noise = light.noise;
        Self {
            colours: std::array::from_fn(|k| colours.get(k).copied().unwrap_or(first)),
            shrink: settings.shrink.max(1e-6) as f32,
            channels: std::array::from_fn(|c| ChannelError {
                floor: noise.floor[c] * (1.0 + black_share),
                of_black: noise.growth[c] * (1.0 + black_share),
                of_white: 0.5 * noise.growth[c],
                of_square: (BAYER_ERROR[c] * settings.channel_error).powi(2) as f32,
            }),
        }
    }

    /// Filters what fits a block; all rows have the same length.
    #[inline(always)]
    fn block(
        &self,
        [lights, blacks, whites]: [[&[f32]; 3]; 3],
        gain: &mut [f32],
        powers: &mut [f32],
    ) {
        let mut signals = [[0.0f32; BLOCK]; 3];
        let mut powers_of = [[0.0f32; BLOCK]; 3];
        for c in 0..3 {
            let error = self.channels[c];
            let inputs = lights[c].iter().zip(blacks[c]).zip(whites[c]);
            let outputs = signals[c].iter_mut().zip(&mut powers_of[c]);
            for (((&l, &k), &white), (signal, power)) in inputs.zip(outputs) {
                let l = if l < CLIPPED_LIGHT { l } else { 1.0 };
                let squared = error.floor
                    + error.of_black * k
                    + (error.of_white + error.of_square * white) * white;
                let weight = white / squared;
                *signal = (l - k) * weight;
                *power = white * weight;
            }
        }
        gain.fill(f32::MIN);
        powers.fill(1.0);
        for [r, g, b] in self.colours {
            let squares = [r * r, g * g, b * b];
            let best = gain.iter_mut().zip(powers.iter_mut());
            for (x, (best, best_power)) in best.enumerate().take(BLOCK) {
                let signal = signals[0][x] * r + signals[1][x] * g + signals[2][x] * b;
                let power = powers_of[0][x] * squares[0]
                    + powers_of[1][x] * squares[1]
                    + powers_of[2][x] * squares[2]
                    + self.shrink;
                let better = signal * *best_power > *best * power;
                *best = if better { signal } else { *best };
                *best_power = if better { power } else { *best_power };
            }
        }
        for (gain, power) in gain.iter_mut().zip(powers) {
            *gain = (*gain / *power).clamp(GAIN_RANGE.0, GAIN_RANGE.1);
            *power -= self.shrink;
        }
    }
}

/// Gains beyond are no light of a line but a reference that does not fit.
const GAIN_RANGE: (f32, f32) = (-0.5, 1.5);

/// Pixels that are filtered together: what they need fits the first-level cache.
const BLOCK: usize = 128;

/// One row's way through the filter.
struct RowFilter<'a, const N: usize> {
    filter: &'a Filter<N>,
    light: &'a LineLight<'a>,
    y: usize,
    row: &'a [Vec<f32>; 3],
    gain: &'a mut [f32],
    power: &'a mut [f32],
}

impl<const N: usize> NullaryFnOnce for RowFilter<'_, N> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let lights = self.row.each_ref().map(|channel| &channel[..]);
        let blacks = self
            .light
            .black
            .channels
            .each_ref()
            .map(|plane| plane.row(self.y));
        let whites = self.light.white.each_ref().map(|plane| plane.row(self.y));
        let blocks = self
            .gain
            .chunks_mut(BLOCK)
            .zip(self.power.chunks_mut(BLOCK));
        for (n, (gain, power)) in blocks.enumerate() {
            let range = n * BLOCK..n * BLOCK + gain.len();
            let inputs = [lights, blacks, whites].map(|rows| rows.map(|row| &row[range.clone()]));
            self.filter.block(inputs, gain, power);
        }
    }
}

/// Adds the gain image of another capture of the same lines.
pub fn merge_gains(a: &mut GainImage, b: &GainImage, settings: &GainSettings) {
    let shrink = settings.shrink.max(1e-6) as f32;
    let first = a.gain.values_mut().par_iter_mut().zip(a.power.values_mut());
    let second = b.gain.values().par_iter().zip(b.power.values());
    first.zip(second).for_each(|((gain, power), (&g, &p))| {
        let signal = *gain * (*power + shrink) + g * (p + shrink);
        *power += p;
        *gain = signal / (*power + shrink);
    });
}
