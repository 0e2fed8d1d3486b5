//! What the scene gives back of black and of white light, and how noisy the camera is.
//!
//! Takes the captures under black (K) and white (W) projection, gives their means in linear light and the
//! noise law var = s0^2 + s1 I of each channel, fitted to the differences between repeats (G. Healey and
//! R. Kondepudy, "Radiometric CCD camera calibration and noise estimation", 1994). What was not captured is found in
//! the grids' captures (`stand_ins`). Something that moved between repeats raises the noise quietly; the trimmed fit
//! bears about a tenth of such pixels.

use image::RgbImage;
use serde::{Deserialize, Serialize};

use super::{
    channels::Channels,
    levels::{Level, levels},
    line_light::LineLight,
    plane::Plane,
    response::{Light, Response},
};

/// How references and noise are found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReferenceSettings {
    /// Noise of a dark pixel (standard deviation of linear light) when there are no repeats to measure it,
    /// 0 to 0.1.
    pub dark_noise: f64,
    /// Growth of the noise variance with light when there are no repeats to measure it, 0 to 0.1.
    pub noise_growth: f64,
    /// Side of the tiles in which the dark cells are looked for when there is no capture under black, in
    /// camera pixels, 8 to 512. It must span a line and the dark beside it.
    pub tile_px: usize,
    /// White minus black under this many standard deviations is shadow or out of the projector's reach.
    pub shadow_sigma: f64,
}

impl Default for ReferenceSettings {
    fn default() -> Self {
        Self {
            dark_noise: 0.002,
            noise_growth: 0.0004,
            tile_px: 48,
            shadow_sigma: 6.0,
        }
    }
}

/// The variance of one pixel's linear light: `floor + growth x light`, per channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseLaw {
    /// Variance of a dark pixel.
    pub floor: [f32; 3],
    /// Growth of the variance per unit of light.
    pub growth: [f32; 3],
}

impl NoiseLaw {
    /// Variance of one capture's channel at a mean light.
    #[must_use]
    pub fn variance(&self, channel: usize, light: f32) -> f32 {
        self.floor[channel] + self.growth[channel] * light.max(0.0)
    }
}

/// What a scene gives back of black and white projection, as far as it was captured: the same for all grid
/// captures of one stage.
#[derive(Debug, Clone)]
pub struct References {
    /// Light under black projection.
    pub black: Option<Light>,
    /// Light that white projection adds, per channel; at least so much where it was clipped.
    pub white: Option<Channels>,
    /// For each pixel bit 0, 1, 2 is set where red, green, blue was clipped under black or white.
    pub clipped: Vec<u8>,
    /// The camera's noise.
    pub noise: NoiseLaw,
    /// Black and white once more, side by side; empty when one of them was not captured.
    pub(super) levels: Vec<Level>,
}

/// Finds the references of one stage. White counts only beside black.
#[must_use]
pub fn find_references(
    black: &[RgbImage],
    white: &[RgbImage],
    response: &Response,
    settings: &ReferenceSettings,
) -> References {
    let noise = noise_law(&[black, white], response, settings);
    let black = response.light(black);
    let lit = response.light(white);
    let pixels = black
        .as_ref()
        .or(lit.as_ref())
        .map_or(0, |l| l.clipped.len());
    let mut clipped = vec![0; pixels];
    for light in [&black, &lit].into_iter().flatten() {
        let bits = clipped.iter_mut().zip(&light.clipped);
        bits.for_each(|(bit, other)| *bit |= other);
    }
    let white = lit.map(|light| white_above(light.channels, black.as_ref(), &clipped));
    let both = black.as_ref().zip(white.as_ref());
    References {
        levels: both.map_or_else(Vec::new, |(k, w)| levels(k, w, &clipped)),
        black,
        white,
        clipped,
        noise,
    }
}

fn white_above(mut white: Channels, black: Option<&Light>, clipped: &[u8]) -> Channels {
    for (c, plane) in white.planes_mut().iter_mut().enumerate() {
        let pixels = plane.values_mut().iter_mut().zip(clipped);
        pixels.for_each(|(w, &bits)| *w = if bits >> c & 1 == 1 { 1.0 } else { *w });
        if let Some(black) = black {
            let pixels = plane
                .values_mut()
                .iter_mut()
                .zip(black.channels[c].values());
            pixels.for_each(|(w, &k)| *w = (*w - k).max(0.0));
        }
    }
    white
}

/// Number of classes of light in the fit of the noise law.
const LIGHT_CLASSES: usize = 32;
/// Share of the largest differences that is left out of each class: moving things, flicker.
const TRIMMED: f64 = 0.1;
/// What the mean square of a normal variable is divided by after its largest tenth was left out.
const TRIM_LOSS: f64 = 0.563;

fn noise_law(kinds: &[&[RgbImage]], response: &Response, settings: &ReferenceSettings) -> NoiseLaw {
    let mut law = NoiseLaw {
        floor: [(settings.dark_noise * settings.dark_noise) as f32; 3],
        growth: [settings.noise_growth as f32; 3],
    };
    for channel in 0..3 {
        let mut classes = vec![Vec::new(); LIGHT_CLASSES];
        for repeats in kinds {
            for pair in repeats.windows(2) {
                sort_differences(&pair[0], &pair[1], channel, response, &mut classes);
            }
        }
        if let Some((floor, growth)) = fit_noise(&mut classes) {
            law.floor[channel] = floor;
            law.growth[channel] = growth;
        }
        let step = response.step_at(0.0);
        law.floor[channel] = law.floor[channel].max(step * step / 12.0);
    }
    law
}

/// Half the squared difference of two captures estimates the variance; sorted by light.
fn sort_differences(
    a: &RgbImage,
    b: &RgbImage,
    channel: usize,
    response: &Response,
    classes: &mut [Vec<(f32, f32)>],
) {
    const EVERY: usize = 7; // pixels: a seventh of the picture is plenty, and 7 meets every Bayer site
    let samples = a.as_raw().chunks_exact(3).zip(b.as_raw().chunks_exact(3));
    for (p, q) in samples.step_by(EVERY) {
        if p[channel].max(q[channel]) >= 250 {
            continue;
        }
        let (p, q) = (response.linear(p[channel]), response.linear(q[channel]));
        let light = 0.5 * (p + q);
        let class = ((light.sqrt() * LIGHT_CLASSES as f32) as usize).min(LIGHT_CLASSES - 1);
        classes[class].push((light, 0.5 * (p - q) * (p - q)));
    }
}

/// Straight line through the trimmed means of the classes, weighted by their numbers over the variance
/// squared; `None` without differences.
fn fit_noise(classes: &mut [Vec<(f32, f32)>]) -> Option<(f32, f32)> {
    const FEWEST: usize = 50; // samples in a class, for a mean within about 20 %
    let mut points = Vec::new();
    for class in classes.iter_mut().filter(|class| class.len() >= FEWEST) {
        class.sort_by(|a, b| a.1.total_cmp(&b.1));
        let kept = ((1.0 - TRIMMED) * class.len() as f64) as usize;
        let mean = |f: fn(&(f32, f32)) -> f32| {
            class[..kept].iter().map(|s| f64::from(f(s))).sum::<f64>() / kept as f64
        };
        points.push((mean(|s| s.0), mean(|s| s.1) / TRIM_LOSS, class.len() as f64));
    }
    let most = points.iter().map(|p| p.1).fold(0.0, f64::max);
    let (mut sw, mut sx, mut sy, mut sxx, mut sxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for &(light, variance, count) in &points {
        let w = count / (variance + 0.01 * most + 1e-12).powi(2);
        sw += w;
        sx += w * light;
        sy += w * variance;
        sxx += w * light * light;
        sxy += w * light * variance;
    }
    if sw == 0.0 {
        return None;
    }
    let spread = sw * sxx - sx * sx;
    let growth = if spread > 1e-9 * sw * sxx {
        ((sw * sxy - sx * sy) / spread).max(0.0)
    } else {
        0.0
    };
    Some((((sy - growth * sx) / sw).max(0.0) as f32, growth as f32))
}

/// Where the projector's light does not reach: 1 in the light, 0 in shadow.
pub(super) fn lit_mask(light: &LineLight<'_>, settings: &ReferenceSettings) -> Plane {
    let mut mask = Plane::filled(light.width(), light.height(), 1.0);
    let limit = settings.shadow_sigma as f32;
    for (at, lit) in mask.values_mut().iter_mut().enumerate() {
        let (black, white) = (light.black.channels.at(at), light.white.at(at));
        let above = (0..3).any(|c| {
            let (k, w) = (black[c], white[c]);
            let variance = light.noise.variance(c, k) + light.noise.variance(c, k + w);
            w > limit * variance.sqrt()
        });
        let clipped = light.clipped.get(at).is_some_and(|&bits| bits != 0);
        *lit = f32::from(u8::from(above || clipped));
    }
    mask
}
