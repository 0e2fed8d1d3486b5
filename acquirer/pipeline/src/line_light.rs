//! The light of a grid capture, ready to be measured: above black, and beside what white would give.
//!
//! Takes the repeated captures of one grid and the references; gives linear light pixel by pixel and its variance.
//! Without a measured white the brightest light of the neighbourhood stands for it, or the unary grid itself. A clipped
//! channel counts as bright and uncertain; where only white was clipped, white counts as full scale, so that a line in a
//! highlight is still seen.

use image::RgbImage;

use super::{
    channels::Channels,
    levels::Level,
    reference::{NoiseLaw, References},
    response::{CLIPPED_LIGHT, Light, Response},
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
    pub white: &'a Channels,
    /// For each pixel bit 0, 1, 2 is set where the references of red, green, blue were clipped; may be empty.
    pub clipped: &'a [u8],
    /// Whether `white` was measured; else it is a guess that carries no albedo.
    pub white_is_measured: bool,
    /// The camera's noise.
    pub noise: NoiseLaw,
    /// `black`, `white` and `clipped` once more, side by side; may be empty.
    pub(super) levels: &'a [Level],
}

/// Linear light at some pixels of a grid capture.
#[derive(Debug, Clone, Copy, Default)]
pub struct PixelLight {
    /// Light above black, per channel.
    pub above_black: [f32; 3],
    /// Light that a white line would give.
    pub white: [f32; 3],
    /// Variance of `above_black`; large where the capture or its white reference was clipped.
    pub variance: [f32; 3],
    /// Which channels are below full scale in all of them.
    pub usable: [bool; 3],
}

/// Variance of clipped light: known to within half of full light at best.
const CLIPPED_VARIANCE: f32 = 0.25;
/// Error of light over clipped white, as a share of the light.
const WHITE_CLIPPED_ERROR: f32 = 0.3;

impl<'a> LineLight<'a> {
    /// Captures over black and white light that were captured both; `None` if one was not.
    #[must_use]
    pub fn new(
        (frames, response): (&'a [RgbImage], &'a Response),
        references: &'a References,
    ) -> Option<Self> {
        Some(Self {
            frames,
            response,
            black: references.black.as_ref()?,
            white: references.white.as_ref()?,
            clipped: &references.clipped,
            white_is_measured: true,
            noise: references.noise,
            levels: &references.levels,
        })
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

    /// For looking at many single pixels.
    #[must_use]
    pub fn looker(&self) -> Looker<'_> {
        let [share, black_share] = self.shares();
        Looker {
            light: self,
            blacks: [0, 1, 2].map(|c| self.black.channels[c].values()),
            whites: [0, 1, 2].map(|c| self.white[c].values()),
            floor: self.noise.floor.map(|floor| floor * (share + black_share)),
            of_light: self.noise.growth.map(|growth| growth * share),
            of_black: self.noise.growth.map(|growth| growth * black_share),
        }
    }

    /// Shares of one capture's variance in the mean of the grid's and of black's repeats.
    pub(super) fn shares(&self) -> [f32; 2] {
        [self.frames.len(), self.black.repeats].map(|repeats| 1.0 / repeats.max(1) as f32)
    }
}

/// Looks at pixels of a grid capture.
#[derive(Debug, Clone, Copy)]
pub struct Looker<'a> {
    light: &'a LineLight<'a>,
    blacks: [&'a [f32]; 3],
    whites: [&'a [f32]; 3],
    /// Variance of light above black: a constant, and its growth with light and with black.
    floor: [f32; 3],
    of_light: [f32; 3],
    of_black: [f32; 3],
}

impl Looker<'_> {
    /// Black and white light of a pixel, and where they were clipped.
    #[inline(always)]
    fn references(&self, at: usize) -> ([f32; 3], [f32; 3], u8) {
        if let Some(level) = self.light.levels.get(at) {
            return (level.black(), level.white(), level.clipped);
        }
        let bits = self.light.clipped.get(at).copied().unwrap_or(0);
        (self.blacks.map(|b| b[at]), self.whites.map(|w| w[at]), bits)
    }

    /// Reads from each of these pixels, which are to be looked at next: they come from memory all at once then, not one
    /// after the other.
    #[inline]
    pub(super) fn fetch(&self, pixels: impl Iterator<Item = usize>) {
        let levels = self.light.levels;
        let mut touched = 0;
        for at in pixels {
            for frame in self.light.frames {
                touched ^= frame.as_raw().get(3 * at).copied().unwrap_or(0);
            }
            touched ^= levels.get(at).map_or(0, |level| level.clipped);
        }
        std::hint::black_box(touched);
    }

    /// The mean light at some pixels, numbered row by row. All errors but the clipped ones' are linear in the light,
    /// so that the mean's is theirs; neighbouring pixels share most of it.
    #[must_use]
    pub fn mean_at<const N: usize>(&self, pixels: [usize; N]) -> PixelLight {
        let part = 1.0 / N as f32;
        let (mut seen, mut blacks, mut whites) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let mut brightest = [0.0f32; 3];
        let mut white_clipped = [0; 3];
        for at in pixels {
            let light = self.light.response.light_at(self.light.frames, at);
            let (black, white, bits) = self.references(at);
            for c in 0..3 {
                brightest[c] = brightest[c].max(light[c]);
                seen[c] += light[c].min(1.0);
                blacks[c] += black[c];
                whites[c] += white[c];
                white_clipped[c] += bits >> c & 1;
            }
        }
        let mut mean = PixelLight::default();
        for c in 0..3 {
            let (seen, black) = (part * seen[c], part * blacks[c]);
            mean.above_black[c] = seen - black;
            mean.white[c] = part * whites[c];
            mean.usable[c] = brightest[c] < CLIPPED_LIGHT;
            mean.variance[c] = self.floor[c] + self.of_light[c] * seen + self.of_black[c] * black;
            if !mean.usable[c] {
                mean.variance[c] += CLIPPED_VARIANCE;
            } else if white_clipped[c] > 0 {
                // white is brighter than was seen: a dark line is dark all the same, a bright one may be less so
                let error = WHITE_CLIPPED_ERROR * mean.above_black[c];
                mean.variance[c] += part * f32::from(white_clipped[c]) * error * error;
            }
        }
        mean
    }
}
