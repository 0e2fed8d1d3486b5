//! Light from camera bytes: the response table.
//!
//! Takes 8-bit captures, gives linear light, 0 (black) to 1 (white point), one plane per channel, averaged
//! over repeats, and which channels were clipped. The table is the inverse of the sRGB curve
//! (IEC 61966-2-1) unless the settings give a gamma or a measured curve (`measured`, from captures of solid colours).
//! With a camera whose curve is another one, light adds up wrongly: edges move by a few hundredths of a pixel and
//! colours shift, quietly.

mod curve;

mod solids;

mod equations;

mod fit;

mod measured;

use image::RgbImage;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{channels::Channels, plane::Plane};

pub use curve::{KNOTS, NoResponse, ResponseCurve};
pub use measured::{MeasuredResponse, NoMeasurement, measure_response};
pub use solids::{SolidCaptures, ramp_colours};

/// How camera bytes become linear light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ResponseSettings {
    /// Exponent of a pure power law, 0.2 to 5; 0 takes the curve measured with the scan, else sRGB, which is what
    /// webcams aim at.
    pub gamma: f64,
    /// From this byte value on a channel counts as clipped, 1 to 255.
    pub clipped_from: u8,
    /// The linear light of the bytes 255 k / 16, 17 values from 0 to 1; left out, the scan's own measurement or
    /// sRGB holds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curve: Option<ResponseCurve>,
}

impl Default for ResponseSettings {
    fn default() -> Self {
        Self {
            gamma: 0.0,
            clipped_from: 250,
            curve: None,
        }
    }
}

impl ResponseSettings {
    /// The power law that the settings ask for.
    #[must_use]
    pub fn power(&self) -> Option<f64> {
        (0.2..=5.0).contains(&self.gamma).then_some(self.gamma)
    }
}

/// The linear light of each byte value.
#[derive(Debug, Clone)]
pub struct Response {
    table: [f32; 256],
    /// The table with [`UNKNOWN`] for clipped bytes.
    marked: [f32; 256],
    /// The table with full light for clipped bytes.
    full: [f32; 256],
    clipped_from: u8,
}

/// What stands for the light of a clipped byte: so much that the mean of 255 repeats still tells.
const UNKNOWN: f32 = 1e4;
/// From here on a mean light holds a clipped byte.
pub(super) const CLIPPED_LIGHT: f32 = 2.0;

impl Response {
    /// The table for these settings: of the gamma, else of the curve, else sRGB's. A gamma out of range is none.
    #[must_use]
    pub fn new(settings: &ResponseSettings) -> Self {
        let curve = settings.curve.unwrap_or_else(ResponseCurve::srgb).table();
        let table: [f32; 256] = std::array::from_fn(|byte| {
            let linear = match settings.power() {
                Some(gamma) => (byte as f64 / 255.0).powf(gamma),
                None => curve[byte],
            };
            linear as f32
        });
        let clipped_from = settings.clipped_from.max(1);
        let clipped_as = |light: f32| {
            std::array::from_fn(|byte| {
                if byte >= usize::from(clipped_from) {
                    light
                } else {
                    table[byte]
                }
            })
        };
        Self {
            table,
            marked: clipped_as(UNKNOWN),
            full: clipped_as(1.0),
            clipped_from,
        }
    }

    /// Linear light of a byte, 0 to 1.
    #[must_use]
    pub fn linear(&self, byte: u8) -> f32 {
        self.table[usize::from(byte)]
    }

    /// The mean linear light of one row of repeated captures, red, green and blue; at least [`CLIPPED_LIGHT`]
    /// where any of them was clipped. The rows of `light` must be as long as the captures'.
    pub(super) fn light_row(&self, repeats: &[RgbImage], y: usize, light: &mut [Vec<f32>; 3]) {
        let [red, green, blue] = light;
        let width = red.len();
        let share = 1.0 / repeats.len().max(1) as f32;
        for (n, picture) in repeats.iter().enumerate() {
            let bytes = &picture.as_raw()[3 * y * width..3 * (y + 1) * width];
            let lights = red.iter_mut().zip(green.iter_mut()).zip(blue.iter_mut());
            let pixels = bytes.chunks_exact(3).zip(lights);
            if n == 0 {
                pixels.for_each(|(pixel, ((r, g), b))| {
                    *r = share * self.marked[usize::from(pixel[0])];
                    *g = share * self.marked[usize::from(pixel[1])];
                    *b = share * self.marked[usize::from(pixel[2])];
                });
            } else {
                pixels.for_each(|(pixel, ((r, g), b))| {
                    *r += share * self.marked[usize::from(pixel[0])];
                    *g += share * self.marked[usize::from(pixel[1])];
                    *b += share * self.marked[usize::from(pixel[2])];
                });
            }
        }
    }

    /// The sums of linear light over squares of `bin` x `bin` pixels and all repeats, red, green and blue, for the
    /// `y`-th row of squares; clipped bytes count as full light. The rows of `sums` tell how many squares.
    pub(super) fn sum_squares(
        &self,
        repeats: &[RgbImage],
        (y, bin): (usize, usize),
        sums: &mut [Vec<f32>; 3],
    ) {
        let mut first = true;
        for picture in repeats {
            let row_bytes = 3 * picture.width() as usize;
            for row in y * bin..(y + 1) * bin {
                let bytes = &picture.as_raw()[row * row_bytes..(row + 1) * row_bytes];
                match (bin, first) {
                    (1, true) => self.pixels(bytes, sums),
                    (1, false) => self.squares::<1, false>(bytes, sums),
                    (2, true) => self.squares::<2, true>(bytes, sums),
                    (2, false) => self.squares::<2, false>(bytes, sums),
                    (3, true) => self.squares::<3, true>(bytes, sums),
                    (3, false) => self.squares::<3, false>(bytes, sums),
                    (4, true) => self.squares::<4, true>(bytes, sums),
                    (4, false) => self.squares::<4, false>(bytes, sums),
                    _ => self.wide_squares((bytes, bin), first, sums),
                }
                first = false;
            }
        }
    }

    /// The light of one row's pixels.
    fn pixels(&self, bytes: &[u8], [red, green, blue]: &mut [Vec<f32>; 3]) {
        const TOGETHER: usize = 8;
        let pieces = bytes.chunks_exact(3 * TOGETHER);
        let done = pieces.len() * TOGETHER;
        let lights = red
            .chunks_exact_mut(TOGETHER)
            .zip(green.chunks_exact_mut(TOGETHER));
        let lights = lights.zip(blue.chunks_exact_mut(TOGETHER));
        for (piece, ((r, g), b)) in pieces.zip(lights) {
            for k in 0..TOGETHER {
                r[k] = self.full[usize::from(piece[3 * k])];
                g[k] = self.full[usize::from(piece[3 * k + 1])];
                b[k] = self.full[usize::from(piece[3 * k + 2])];
            }
        }
        for (k, pixel) in bytes.chunks_exact(3).enumerate().skip(done) {
            red[k] = self.full[usize::from(pixel[0])];
            green[k] = self.full[usize::from(pixel[1])];
            blue[k] = self.full[usize::from(pixel[2])];
        }
    }

    /// Sums over pieces of one row: sets the first ones, adds others.
    fn squares<const BIN: usize, const FIRST: bool>(
        &self,
        bytes: &[u8],
        [red, green, blue]: &mut [Vec<f32>; 3],
    ) {
        let count = red.len().min(bytes.len() / (3 * BIN));
        let pieces = bytes.chunks_exact(3 * BIN);
        let (red, green, blue) = (&mut red[..count], &mut green[..count], &mut blue[..count]);
        for (k, piece) in pieces.take(count).enumerate() {
            let mut light = [0.0; 3];
            for pixel in 0..BIN {
                for c in 0..3 {
                    light[c] += self.full[usize::from(piece[3 * pixel + c])];
                }
            }
            if FIRST {
                (red[k], green[k], blue[k]) = (light[0], light[1], light[2]);
            } else {
                red[k] += light[0];
                green[k] += light[1];
                blue[k] += light[2];
            }
        }
    }

    fn wide_squares(
        &self,
        (bytes, bin): (&[u8], usize),
        first: bool,
        [red, green, blue]: &mut [Vec<f32>; 3],
    ) {
        let sums = red.iter_mut().zip(green.iter_mut()).zip(blue.iter_mut());
        for (piece, ((r, g), b)) in bytes.chunks_exact(3 * bin).zip(sums) {
            if first {
                (*r, *g, *b) = (0.0, 0.0, 0.0);
            }
            for pixel in piece.chunks_exact(3) {
                *r += self.full[usize::from(pixel[0])];
                *g += self.full[usize::from(pixel[1])];
                *b += self.full[usize::from(pixel[2])];
            }
        }
    }

    /// Adds the linear light of every `step`-th pixel from the `first` on, row by row, over all repeats; clipped
    /// bytes count as full light.
    pub(super) fn add_every(
        &self,
        repeats: &[RgbImage],
        (first, step): (usize, usize),
        [red, green, blue]: &mut [Vec<f32>; 3],
    ) {
        for picture in repeats {
            let pixels = picture.as_raw()[3 * first..].chunks(3 * step);
            let sums = red.iter_mut().zip(green.iter_mut()).zip(blue.iter_mut());
            for (pixel, ((r, g), b)) in pixels.zip(sums) {
                *r += self.full[usize::from(pixel[0])];
                *g += self.full[usize::from(pixel[1])];
                *b += self.full[usize::from(pixel[2])];
            }
        }
    }

    /// The mean linear light of one pixel, numbered row by row, of repeated captures; marked like [`Self::light_row`]'s.
    #[inline]
    pub(super) fn light_at(&self, repeats: &[RgbImage], pixel: usize) -> [f32; 3] {
        let seen = |picture: &RgbImage| match picture.as_raw()[3 * pixel..] {
            [r, g, b, ..] => [r, g, b].map(|byte| self.marked[usize::from(byte)]),
            _ => [0.0; 3],
        };
        if let [picture] = repeats {
            return seen(picture);
        }
        let share = 1.0 / repeats.len().max(1) as f32;
        let mut light = [0.0; 3];
        for picture in repeats {
            let sums = light.iter_mut().zip(seen(picture));
            sums.for_each(|(sum, light)| *sum += share * light);
        }
        light
    }

    /// Step from one byte value to the next at a linear light, for the quantisation noise.
    #[must_use]
    pub fn step_at(&self, light: f32) -> f32 {
        let above = self.table.partition_point(|&v| v <= light).clamp(1, 255);
        self.table[above] - self.table[above - 1]
    }

    /// The mean linear light of repeated captures of one size; `None` when there are none.
    #[must_use]
    pub fn light(&self, repeats: &[RgbImage]) -> Option<Light> {
        let first = repeats.first()?;
        let (width, height) = (first.width() as usize, first.height() as usize);
        let mut light = Light {
            channels: Channels::new(std::array::from_fn(|_| Plane::filled(width, height, 0.0))),
            clipped: vec![0; width * height],
            repeats: repeats.len(),
        };
        let share = 1.0 / repeats.len() as f32;
        let [red, green, blue] = light.channels.planes_mut();
        let rows = red
            .values_mut()
            .par_chunks_mut(width.max(1))
            .zip(green.values_mut().par_chunks_mut(width.max(1)))
            .zip(blue.values_mut().par_chunks_mut(width.max(1)))
            .zip(light.clipped.par_chunks_mut(width.max(1)));
        rows.enumerate()
            .for_each(|(y, (((red, green), blue), clipped))| {
                for picture in repeats {
                    let bytes = &picture.as_raw()[3 * y * width..3 * (y + 1) * width];
                    self.add_row(bytes, share, [red, green, blue], clipped);
                }
            });
        Some(light)
    }

    fn add_row(&self, bytes: &[u8], share: f32, sums: [&mut [f32]; 3], clipped: &mut [u8]) {
        let [red, green, blue] = sums;
        let pixels = bytes.chunks_exact(3).zip(clipped);
        for ((((pixel, clipped), r), g), b) in pixels.zip(red).zip(green).zip(blue) {
            *r += share * self.linear(pixel[0]);
            *g += share * self.linear(pixel[1]);
            *b += share * self.linear(pixel[2]);
            for (channel, &byte) in pixel.iter().enumerate() {
                *clipped |= u8::from(byte >= self.clipped_from) << channel;
            }
        }
    }
}

/// Linear light of one capture, or the mean of repeats.
#[derive(Debug, Clone)]
pub struct Light {
    /// Red, green and blue, 0 to 1.
    pub channels: Channels,
    /// For each pixel bit 0, 1, 2 is set where red, green, blue was clipped in any repeat.
    pub clipped: Vec<u8>,
    /// How many captures the mean was taken over.
    pub repeats: usize,
}

impl Light {
    /// Pixels in a row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.channels[0].width()
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.channels[0].height()
    }
}
