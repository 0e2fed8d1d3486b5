//! The light of a grid capture, ready to be measured: above black, and beside what white would give.
//!
//! Takes the repeated captures of one grid and the references; gives linear light pixel by pixel and its variance.
//! Without a measured white the brightest light of the neighbourhood stands for it, or the unary grid itself. A clipped channel counts as bright and uncertain; where only white was
//! clipped, white counts as full scale, so that a line in a highlight is still seen.

use std::borrow::Cow;

use image::RgbImage;

use super::{
    gain::GainSettings,
    plane::Plane,
    reference::{NoiseLaw, References},
    response::{CLIPPED_LIGHT, Light, Response},
    tiles::Tiles,
};

/// The repeated captures of one grid, and what black and white projection give there.
#[derive(Debug, Clone)]
pub struct LineLight<'a> {
    /// The captures; one at least.
    pub frames: &'a [RgbImage],
    /// Light from bytes.
    pub response: &'a Response,
    /// Light under black projection.
    pub black: &'a Light,
    /// Light that a white line would give, per channel; at least so much where it was clipped.
    pub white: Cow<'a, [Plane; 3]>,
    /// For each pixel bit 0, 1, 2 is set where the references of red, green, blue were clipped; may be empty.
    pub clipped: &'a [u8],
    /// Whether `white` was measured; else it is a guess that carries no albedo.
    pub white_is_measured: bool,
    /// The camera's noise.
    pub noise: NoiseLaw,
}

/// Linear light at one pixel of a grid capture.
#[derive(Debug, Clone, Copy, Default)]
pub struct PixelLight {
    /// Light above black, per channel.
    pub above_black: [f32; 3],
    /// Light that a white line would give.
    pub white: [f32; 3],
    /// Variance of `above_black`; large where the capture or its white reference was clipped.
    pub variance: [f32; 3],
    /// Which channels of the captures are below full scale.
    pub usable: [bool; 3],
}

/// Variance of clipped light: known to within half of full light at best.
const CLIPPED_VARIANCE: f32 = 0.25;
/// Error of light over clipped white, as a share of the light.
const WHITE_CLIPPED_ERROR: f32 = 0.3;

impl<'a> LineLight<'a> {
    /// Captures over measured black and white light. Without measured white the strongest light of the
    /// neighbourhood stands for it.
    #[must_use]
    pub fn new(
        (frames, response): (&'a [RgbImage], &'a Response),
        black: &'a Light,
        references: &'a References,
        settings: &GainSettings,
    ) -> Self {
        let white = references.white.as_ref();
        let mut light = Self {
            frames,
            response,
            black,
            white: Cow::Owned(Default::default()),
            clipped: &references.clipped,
            white_is_measured: white.is_some(),
            noise: references.noise,
        };
        light.white = match white {
            Some(white) => Cow::Borrowed(white),
            None => Cow::Owned(light.strongest(settings)),
        };
        light
    }

    /// Pixels in a row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.black.width()
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.black.height()
    }

    /// The light at a pixel of the picture.
    #[must_use]
    pub fn at(&self, x: usize, y: usize) -> PixelLight {
        let light = self.response.light_at(self.frames, x, y);
        let at = y * self.width() + x;
        let [share, black_share] = self.shares();
        let mut pixel = PixelLight::default();
        for c in 0..3 {
            let black = self.black.channels[c].values()[at];
            pixel.usable[c] = light[c] < CLIPPED_LIGHT;
            let light = light[c].min(1.0);
            pixel.above_black[c] = light - black;
            pixel.white[c] = self.white[c].values()[at];
            pixel.variance[c] =
                self.noise.variance(c, light) * share + self.noise.variance(c, black) * black_share;
            if !pixel.usable[c] {
                pixel.variance[c] += CLIPPED_VARIANCE;
            } else if self.clipped.get(at).is_some_and(|bits| bits >> c & 1 == 1) {
                // white is brighter than was seen: a dark line is dark all the same, a bright one may be less so
                pixel.variance[c] += (WHITE_CLIPPED_ERROR * pixel.above_black[c]).powi(2);
            }
        }
        pixel
    }

    /// Without a measured white, the unary grid's light over its own colour stands for it, if that colour
    /// has all three channels; lines then have their own albedo and profile as reference.
    pub(super) fn take_white_from(&mut self, unary: &Self, colour: [f32; 3]) {
        if self.white_is_measured || !stands_for_white(colour) {
            return;
        }
        let mut white = unary.above_black();
        for (plane, share) in white.iter_mut().zip(colour) {
            let pixels = plane.values_mut().iter_mut();
            pixels.for_each(|v| {
                *v = if *v < CLIPPED_LIGHT {
                    (*v / share).max(0.0)
                } else {
                    0.0
                }
            });
        }
        self.white = Cow::Owned(white);
        self.white_is_measured = true;
    }

    /// Shares of one capture's variance in the mean of the grid's and of black's repeats.
    pub(super) fn shares(&self) -> [f32; 2] {
        [self.frames.len(), self.black.repeats].map(|repeats| 1.0 / repeats.max(1) as f32)
    }

    /// Light above black as pictures; at least [`CLIPPED_LIGHT`] less black where clipped.
    fn above_black(&self) -> [Plane; 3] {
        let (width, height) = (self.width(), self.height());
        let mut planes = std::array::from_fn(|_| Plane::filled(width, height, 0.0));
        let mut light = std::array::from_fn(|_| vec![0.0; width]);
        for y in 0..height {
            self.response.light_row(self.frames, y, &mut light);
            for (c, plane) in planes.iter_mut().enumerate() {
                let blacks = self.black.channels[c].row(y).iter().zip(&light[c]);
                let values = plane.values_mut()[y * width..].iter_mut().zip(blacks);
                values.for_each(|(v, (&k, &l))| *v = if l < CLIPPED_LIGHT { l - k } else { l });
            }
        }
        planes
    }

    /// The strongest channel near the top of each tile: what a line gives there.
    fn strongest(&self, settings: &GainSettings) -> [Plane; 3] {
        let [mut strongest, green, blue] = self.above_black();
        for channel in [green, blue] {
            let pixels = strongest.values_mut().iter_mut().zip(channel.values());
            pixels.for_each(|(most, &light)| *most = most.max(light));
        }
        strongest
            .values_mut()
            .iter_mut()
            .for_each(|v| *v = v.min(1.0));
        let (width, height) = (strongest.width(), strongest.height());
        let mut level = Tiles::quantile(&strongest, settings.tile_px, 0.97).spread(width, height);
        let least = self.noise.floor.iter().copied().fold(0.0, f32::max);
        let least = 4.0 * least.sqrt();
        level
            .values_mut()
            .iter_mut()
            .for_each(|v| *v = v.max(least));
        [level.clone(), level.clone(), level]
    }
}

/// Whether light of this colour (linear, 0 to 1 per channel) tells what white would give in every channel.
pub(super) fn stands_for_white(colour: [f32; 3]) -> bool {
    const LEAST: f32 = 0.15; // of full light in each channel, for a usable signal
    colour.iter().all(|&share| share >= LEAST)
}
