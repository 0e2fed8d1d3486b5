//! Background removal: which pixels does the projector change (thesis, chapter 4.1.1.3)?
//!
//! Takes the frames with the projector black, gives for each pixel the mean and the variance of hue and
//! saturation; a later frame's pixel is foreground where hue or saturation lies more than k sigma from its
//! mean. Lightness is left out on purpose: it fluctuates. A handful of frames says little about a variance,
//! so each pixel borrows the samples of its eight neighbours. It fails quietly on light without a hue of its
//! own: a white grid on a grey wall changes neither hue nor saturation, so there (and only there)
//! lightness joins the test.

use image::RgbImage;
use rayon::prelude::*;

use super::hsl::{Hsl, hue_distance};

/// Least standard deviation of hue, in radians: two degrees, one step of a byte at medium chroma.
const HUE_SIGMA_FLOOR: f32 = 0.035;
/// Least standard deviation of saturation: one step of a byte at medium lightness.
const SATURATION_SIGMA_FLOOR: f32 = 0.01;
/// Least standard deviation of lightness, in steps of a byte summed over three channels.
const LIGHTNESS_SIGMA_FLOOR: f32 = 1.5;

/// Mean and standard deviation of one quantity.
#[derive(Debug, Clone, Copy, Default)]
struct Normal {
    mean: f32,
    sigma: f32,
}

/// What one pixel looks like without projected light.
#[derive(Debug, Clone, Copy, Default)]
struct PixelModel {
    hue: Normal,
    saturation: Normal,
    lightness: Normal,
}

/// The scene without projected light, pixel by pixel.
#[derive(Debug, Clone)]
pub(crate) struct Background {
    width: u32,
    height: u32,
    pixels: Vec<PixelModel>,
    mean: Vec<[f32; 3]>,
}

/// Where a frame differs from the background.
#[derive(Debug, Clone)]
pub(crate) struct Foreground {
    /// Row by row.
    pub mask: Vec<bool>,
    /// By how many standard deviations the hue differs, at most 20; for the picture.
    pub hue_sigmas: Vec<f32>,
}

/// Sums over the samples of a pixel.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    hues: f32,
    cos: f32,
    sin: f32,
    samples: f32,
    saturation: [f32; 2],
    lightness: [f32; 2],
}

impl Background {
    /// The model of frames of one size; `None` without frames.
    pub(crate) fn new(frames: &[RgbImage]) -> Option<Self> {
        let (width, height) = frames.first()?.dimensions();
        let sums = box_sums(&pixel_sums(frames), width as usize);
        let pixels = sums.par_iter().map(Sums::model).collect();
        let scale = 1.0 / frames.len() as f32;
        let mean = (0..width as usize * height as usize)
            .into_par_iter()
            .map(|at| {
                let bytes = |c: usize| {
                    frames
                        .iter()
                        .map(move |f| f32::from(f.as_raw()[3 * at + c]))
                };
                [0, 1, 2].map(|c| bytes(c).sum::<f32>() * scale)
            })
            .collect();
        Some(Self {
            width,
            height,
            pixels,
            mean,
        })
    }

    /// Mean camera bytes of a pixel without projected light.
    pub(crate) fn mean(&self, at: usize) -> [f32; 3] {
        self.mean[at]
    }

    /// Standard deviation of lightness, averaged over the picture.
    pub(crate) fn lightness_sigma(&self) -> f32 {
        let sum: f32 = self.pixels.iter().map(|p| p.lightness.sigma).sum();
        sum / self.pixels.len().max(1) as f32
    }

    /// Compares a frame of the same size with the background. `with_lightness` is for a grid without hue.
    pub(crate) fn foreground(&self, frame: &RgbImage, k: f32, with_lightness: bool) -> Foreground {
        debug_assert_eq!(frame.dimensions(), (self.width, self.height));
        let compare = |(bytes, model): (&[u8], &PixelModel)| {
            let colour = Hsl::new([bytes[0], bytes[1], bytes[2]]);
            let hue = colour.hue.map_or(0.0, |hue| {
                hue_distance(hue, model.hue.mean) / model.hue.sigma
            });
            let saturation = model.saturation.distance(colour.saturation);
            let brighter = with_lightness && model.lightness.distance(colour.lightness) > k;
            (hue > k || saturation > k || brighter, hue.min(20.0))
        };
        let (mask, hue_sigmas) = frame
            .as_raw()
            .par_chunks_exact(3)
            .zip(&self.pixels)
            .map(compare)
            .unzip();
        Foreground { mask, hue_sigmas }
    }
}

impl Normal {
    fn new([sum, squares]: [f32; 2], count: f32, floor: f32) -> Self {
        let mean = sum / count.max(1.0);
        let variance = (squares / count.max(1.0) - mean * mean).max(0.0);
        Self {
            mean,
            sigma: variance.sqrt().max(floor),
        }
    }

    fn distance(self, value: f32) -> f32 {
        (value - self.mean).abs() / self.sigma
    }
}

impl Sums {
    fn of(hsl: Hsl) -> Self {
        let (sin, cos) = hsl.hue.map_or((0.0, 0.0), f32::sin_cos);
        Self {
            hues: f32::from(u8::from(hsl.hue.is_some())),
            cos,
            sin,
            samples: 1.0,
            saturation: [hsl.saturation, hsl.saturation * hsl.saturation],
            lightness: [hsl.lightness, hsl.lightness * hsl.lightness],
        }
    }

    fn add(&mut self, other: &Self) {
        self.hues += other.hues;
        self.cos += other.cos;
        self.sin += other.sin;
        self.samples += other.samples;
        for k in 0..2 {
            self.saturation[k] += other.saturation[k];
            self.lightness[k] += other.lightness[k];
        }
    }

    /// Hue is an angle, so its mean is that of unit vectors, and their length tells the spread.
    fn model(&self) -> PixelModel {
        let length = (self.cos.hypot(self.sin) / self.hues.max(1.0)).clamp(1e-6, 1.0);
        PixelModel {
            hue: Normal {
                mean: self.sin.atan2(self.cos),
                sigma: (-2.0 * length.ln()).sqrt().max(HUE_SIGMA_FLOOR),
            },
            saturation: Normal::new(self.saturation, self.samples, SATURATION_SIGMA_FLOOR),
            lightness: Normal::new(self.lightness, self.samples, LIGHTNESS_SIGMA_FLOOR),
        }
    }
}

fn pixel_sums(frames: &[RgbImage]) -> Vec<Sums> {
    let pixels = frames.first().map_or(0, |f| f.as_raw().len() / 3);
    let sum = |at: usize| {
        let mut sums = Sums::default();
        for frame in frames {
            let bytes = &frame.as_raw()[3 * at..3 * at + 3];
            sums.add(&Sums::of(Hsl::new([bytes[0], bytes[1], bytes[2]])));
        }
        sums
    };
    (0..pixels).into_par_iter().map(sum).collect()
}

/// Adds up each pixel's 3 x 3 neighbourhood, less what lies outside of the picture.
fn box_sums(pixels: &[Sums], width: usize) -> Vec<Sums> {
    let three = |pixels: &[Sums], at: usize, low: bool, high: bool, step: usize| {
        let mut sums = pixels[at];
        if low {
            sums.add(&pixels[at - step]);
        }
        if high {
            sums.add(&pixels[at + step]);
        }
        sums
    };
    let count = pixels.len();
    let across: Vec<Sums> = (0..count)
        .into_par_iter()
        .map(|at| three(pixels, at, at % width > 0, at % width + 1 < width, 1))
        .collect();
    (0..count)
        .into_par_iter()
        .map(|at| three(&across, at, at >= width, at + width < count, width))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    /// A wall with a little noise that does not repeat from frame to frame.
    fn wall(seed: u32) -> RgbImage {
        RgbImage::from_fn(32, 24, |x, y| {
            let noise = |c: u32| (x * 7919 + y * 104_729 + c * 31 + seed * 65_537) % 5;
            Rgb([60, 50, 45].map(|b: u8| b + noise(u32::from(b)) as u8))
        })
    }

    #[test]
    fn a_red_line_is_foreground_and_the_wall_beside_it_is_not() {
        let background = Background::new(&[wall(1), wall(2), wall(3)]).unwrap();
        let mut frame = wall(4);
        for y in 0..24 {
            frame.put_pixel(10, y, Rgb([200, 52, 46]));
        }
        let mask = background.foreground(&frame, 4.0, false).mask;
        let on_line = (0..24).filter(|y| mask[y * 32 + 10]).count();
        let elsewhere = mask.iter().filter(|m| **m).count() - on_line;
        assert_eq!(on_line, 24);
        assert!(elsewhere < 15, "{elsewhere} of 744");
    }

    #[test]
    fn a_lamp_that_turns_up_alone_is_not_foreground() {
        let frames = [1, 2, 3].map(|s| RgbImage::from_pixel(8, 8, Rgb([60 + s, 50 + s, 45 + s])));
        let background = Background::new(&frames).unwrap();
        let brighter = RgbImage::from_pixel(8, 8, Rgb([120, 100, 91]));
        let differs = |with| background.foreground(&brighter, 4.0, with).mask[27];
        assert!(!differs(false));
        assert!(differs(true));
    }

    #[test]
    fn without_frames_there_is_no_background() {
        assert!(Background::new(&[]).is_none());
    }
}
