//! The gain image: how much of the light that white projection would give arrives at each pixel.
//!
//! Takes a grid capture and the references, gives one number per pixel, about 1 on a line and 0 beside it
//! whatever the surface's colour, and how far it can be trusted. Matched filter over the channels:
//! g = sum D s/v / (sum s^2/v + lambda), D the light above black, s the light that a line would give
//! ((W - K) x nominal colour), v the variance; so albedo, cosine, vignetting and ambient light cancel before
//! any edge is looked for (Caspi, Kiryati and Shamir 1998 for the model). lambda pulls pixels without
//! projector light to 0. Without W the brightest light of the neighbourhood stands for s and albedo stays
//! in. Where the scene moved since W and K, their edges stay in the picture quietly.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{plane::Plane, reference::Reference, response::Light, tiles::Tiles};

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

/// Light above black of a grid capture, and what white would give: the inputs of the stages that follow.
#[derive(Debug, Clone)]
pub struct LineLight {
    /// Light above black (D), per channel.
    pub above_black: [Plane; 3],
    /// Light that a white line would give there (s), per channel.
    pub white: [Plane; 3],
    /// Variance of one capture's D, per channel.
    pub variance: [Plane; 3],
    /// Bits 0, 1, 2: red, green, blue can't be used there.
    pub clipped: Vec<u8>,
    /// Whether `white` was measured; else it is a guess that carries no albedo.
    pub white_is_measured: bool,
}

/// Takes black off a grid capture and finds what white would give.
#[must_use]
pub fn line_light(capture: &Light, reference: &Reference, settings: &GainSettings) -> LineLight {
    let (black, noise) = (&reference.black, &reference.noise);
    let share = 1.0 / capture.repeats.max(1) as f32;
    let black_share = 1.0 / black.repeats.max(1) as f32;
    let mut above_black = capture.channels.clone();
    let mut variance = capture.channels.clone();
    for c in 0..3 {
        let blacks = black.channels[c].values();
        let pixels = above_black[c]
            .values_mut()
            .par_iter_mut()
            .zip(variance[c].values_mut())
            .zip(blacks);
        pixels.for_each(|((light, variance), &k)| {
            *variance = noise.variance(c, *light) * share + noise.variance(c, k) * black_share;
            *light -= k;
        });
    }
    let (white, white_is_measured) = white_light(&above_black, reference, settings);
    let clipped_white = reference.white.as_ref().map(|white| &white.clipped);
    let mut clipped = capture.clipped.clone();
    if let Some(white) = clipped_white {
        let bits = clipped.iter_mut().zip(white).zip(&black.clipped);
        bits.for_each(|((bit, w), k)| *bit |= w | k);
    }
    LineLight {
        above_black,
        white,
        variance,
        clipped,
        white_is_measured,
    }
}

impl LineLight {
    /// Without a measured white, the unary grid's light over its own colour stands for it, if that colour
    /// has all three channels; lines then have their own albedo and profile as reference.
    pub(super) fn take_white_from(&mut self, unary: &Self, colour: [f32; 3]) {
        const LEAST: f32 = 0.15; // of full light in each channel, for a usable signal
        if self.white_is_measured || colour.iter().any(|&share| share < LEAST) {
            return;
        }
        let channels = self.white.iter_mut().zip(&unary.above_black).zip(colour);
        for ((white, light), share) in channels {
            let pixels = white.values_mut().iter_mut().zip(light.values());
            pixels.for_each(|(white, &light)| *white = (light / share).max(0.0));
        }
        let bits = self.clipped.iter_mut().zip(&unary.clipped);
        bits.for_each(|(bit, other)| *bit |= other);
        self.white_is_measured = true;
    }
}

fn white_light(
    above_black: &[Plane; 3],
    reference: &Reference,
    settings: &GainSettings,
) -> ([Plane; 3], bool) {
    if let Some(white) = &reference.white {
        let mut above = white.channels.clone();
        for (white, black) in above.iter_mut().zip(&reference.black.channels) {
            let pixels = white.values_mut().par_iter_mut().zip(black.values());
            pixels.for_each(|(w, &k)| *w = (*w - k).max(0.0));
        }
        return (above, true);
    }
    // no white: the strongest channel near the top of each tile is what a line gives there
    let mut strongest = above_black[0].clone();
    for channel in &above_black[1..] {
        let pixels = strongest.values_mut().iter_mut().zip(channel.values());
        pixels.for_each(|(most, &light)| *most = most.max(light));
    }
    let (width, height) = (strongest.width(), strongest.height());
    let mut level = Tiles::quantile(&strongest, settings.tile_px, 0.97).spread(width, height);
    let least = reference.noise.floor.iter().copied().fold(0.0, f32::max);
    let least = 4.0 * least.sqrt();
    level
        .values_mut()
        .iter_mut()
        .for_each(|v| *v = v.max(least));
    ([level.clone(), level.clone(), level], false)
}

/// The gain image of lines that may have any of the given colours (linear, 0 to 1 per channel); each pixel
/// takes the colour that explains it with the most gain.
#[must_use]
pub fn find_gain(light: &LineLight, colours: &[[f32; 3]], settings: &GainSettings) -> GainImage {
    let (width, height) = (light.white[0].width(), light.white[0].height());
    let mut image = GainImage {
        gain: Plane::filled(width, height, f32::MIN),
        power: Plane::filled(width, height, 0.0),
    };
    let shrink = settings.shrink.max(1e-6) as f32;
    let error = (settings.channel_error * settings.channel_error) as f32;
    let rows = image
        .gain
        .values_mut()
        .par_chunks_mut(width.max(1))
        .zip(image.power.values_mut().par_chunks_mut(width.max(1)));
    rows.enumerate().for_each(|(y, (gain, power))| {
        let row = LightRow::new(light, y);
        for &colour in colours {
            row.add(colour, shrink, error, gain, power);
        }
    });
    image
}

/// One row of the inputs, as plain slices for the inner loop.
struct LightRow<'a> {
    above_black: [&'a [f32]; 3],
    white: [&'a [f32]; 3],
    variance: [&'a [f32]; 3],
    clipped: &'a [u8],
}

impl<'a> LightRow<'a> {
    fn new(light: &'a LineLight, y: usize) -> Self {
        let width = light.white[0].width();
        Self {
            above_black: light.above_black.each_ref().map(|plane| plane.row(y)),
            white: light.white.each_ref().map(|plane| plane.row(y)),
            variance: light.variance.each_ref().map(|plane| plane.row(y)),
            clipped: &light.clipped[y * width..(y + 1) * width],
        }
    }

    /// Replaces gains that this colour explains with more gain.
    fn add(&self, colour: [f32; 3], shrink: f32, error: f32, gain: &mut [f32], powers: &mut [f32]) {
        let width = gain.len();
        let channels = |planes: [&'a [f32]; 3]| planes.map(|row| &row[..width]);
        let (above_black, white, noise) = (
            channels(self.above_black),
            channels(self.white),
            channels(self.variance),
        );
        let clipped = &self.clipped[..width];
        for x in 0..width {
            let (mut signal, mut power) = (0.0, 0.0);
            for c in 0..3 {
                let usable = f32::from(1 - (clipped[x] >> c & 1));
                let expected = usable * white[c][x] * colour[c];
                let weight = expected / (noise[c][x] + error * white[c][x] * white[c][x]);
                signal += above_black[c][x] * weight;
                power += expected * weight;
            }
            let g = signal / (power + shrink);
            let better = g > gain[x];
            gain[x] = if better { g } else { gain[x] };
            powers[x] = if better { power } else { powers[x] };
        }
    }
}

/// The gain image of two captures of the same lines together.
#[must_use]
pub fn merge_gains(mut a: GainImage, b: &GainImage, settings: &GainSettings) -> GainImage {
    let shrink = settings.shrink.max(1e-6) as f32;
    let first = a.gain.values_mut().par_iter_mut().zip(a.power.values_mut());
    let second = b.gain.values().par_iter().zip(b.power.values());
    first.zip(second).for_each(|((gain, power), (&g, &p))| {
        let signal = *gain * (*power + shrink) + g * (p + shrink);
        *power += p;
        *gain = signal / (*power + shrink);
    });
    a
}
