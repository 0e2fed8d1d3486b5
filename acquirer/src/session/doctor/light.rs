//! The light of a steady picture: the mean over some frames in each pixel, and bands of rows frame by frame.
//!
//! Takes frames, gives linear light per pixel, how much it varies from frame to frame, where it was clipped, and for
//! each frame the mean of each band of rows with its time, in which a flickering light shows.

use crate::{camera::Frame, pipeline::response::Response, session::sequence::milliseconds};

/// Bands of rows of a frame: with a read-out of 20 ms a 120 Hz flicker then has 20 bands in each swing.
pub(super) const BANDS: usize = 48;
/// White must stand out of the noise by this many standard deviations for a pixel to count as lit.
const LIT_SIGMA: f32 = 6.0;
/// A lit pixel gets at least this share of the light that the brightest twentieth gets: less is stray light.
const LIT_SHARE: f32 = 0.04;
/// Least share of the picture that must be lit and not clipped for lines to be looked at.
pub(super) const LEAST_USABLE: f64 = 0.02;

/// Means of the bands of one frame.
#[derive(Debug, Clone)]
pub(super) struct BandMeans {
    pub(super) stamp_ms: f64,
    /// Mean red, green and blue of each band, from the first row to the last.
    pub(super) bands: Vec<[f32; 3]>,
}

/// The light of a steady picture.
pub(super) struct Light {
    response: Response,
    pub(super) width: usize,
    pub(super) height: usize,
    sums: Vec<[f32; 3]>,
    bytes: Vec<[u16; 3]>,
    clipped: Vec<u8>,
    previous: Vec<u8>,
    /// Sum of squared differences of neighbouring frames, of the mean of the channels.
    difference: f64,
    pub(super) series: Vec<BandMeans>,
}

impl Light {
    pub(super) fn new(response: Response) -> Self {
        Self {
            response,
            width: 0,
            height: 0,
            sums: Vec::new(),
            bytes: Vec::new(),
            clipped: Vec::new(),
            previous: Vec::new(),
            difference: 0.0,
            series: Vec::new(),
        }
    }

    pub(super) fn frames(&self) -> usize {
        self.series.len()
    }

    pub(super) fn add(&mut self, frame: &Frame) {
        let picture = &frame.picture;
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        if (self.width, self.height) != (width, height) {
            let empty = Self::new(self.response.clone());
            *self = Self {
                width,
                height,
                sums: vec![[0.0; 3]; width * height],
                bytes: vec![[0; 3]; width * height],
                clipped: vec![0; width * height],
                ..empty
            };
        }
        let mut bands = vec![[0.0_f64; 3]; BANDS];
        let mut rows = [0_usize; BANDS];
        for (y, row) in picture.as_raw().chunks_exact(3 * width.max(1)).enumerate() {
            let band = y * BANDS / height;
            rows[band] += 1;
            self.add_row(y, row, &mut bands[band]);
        }
        let means = bands.iter().zip(rows).map(|(sum, rows)| {
            let pixels = (rows * width).max(1) as f64;
            sum.map(|sum| (sum / pixels) as f32)
        });
        self.series.push(BandMeans {
            stamp_ms: milliseconds(frame.captured_at),
            bands: means.collect(),
        });
        self.note_difference(picture.as_raw());
    }

    fn add_row(&mut self, y: usize, row: &[u8], band: &mut [f64; 3]) {
        let first = y * self.width;
        let mut band_sums = [0.0_f32; 3];
        for (x, pixel) in row.chunks_exact(3).enumerate() {
            let at = first + x;
            let mut clipped = false;
            for c in 0..3 {
                let light = self.response.linear(pixel[c]);
                self.sums[at][c] += light;
                self.bytes[at][c] += u16::from(pixel[c]);
                band_sums[c] += light;
                clipped |= self.response.is_clipped(pixel[c]);
            }
            self.clipped[at] += u8::from(clipped);
        }
        for c in 0..3 {
            band[c] += f64::from(band_sums[c]);
        }
    }

    /// Takes the noise from one pixel of some.
    fn note_difference(&mut self, bytes: &[u8]) {
        let mean = |pixel: &[u8]| {
            let sum: f32 = pixel.iter().map(|byte| self.response.linear(*byte)).sum();
            f64::from(sum / 3.0)
        };
        let pairs = bytes.chunks_exact(3).zip(self.previous.chunks_exact(3));
        let squares = pairs
            .step_by(NOISE_STEP)
            .map(|(now, before)| (mean(now) - mean(before)).powi(2));
        self.difference += squares.sum::<f64>();
        bytes.clone_into(&mut self.previous);
    }

    /// Standard deviation of a pixel's light (mean of the channels) from frame to frame.
    fn noise(&self) -> f64 {
        let pixels = self.sums.len().div_ceil(NOISE_STEP);
        let count = self.frames().saturating_sub(1) * pixels;
        (self.difference / (2 * count.max(1)) as f64).sqrt()
    }

    /// Light of a pixel, red, green and blue.
    pub(super) fn at(&self, pixel: usize) -> [f32; 3] {
        let share = 1.0 / self.frames().max(1) as f32;
        self.sums[pixel].map(|sum| sum * share)
    }

    /// Mean byte of a pixel's channel that differs most from another picture's, as (this, that).
    fn levels(&self, other: &Self, pixel: usize) -> f32 {
        let mean = |light: &Self, c: usize| {
            f32::from(light.bytes[pixel][c]) / light.frames().max(1) as f32
        };
        (0..3)
            .map(|c| mean(self, c) - mean(other, c))
            .fold(0.0, f32::max)
    }

    /// Whether a pixel was clipped in most of the frames.
    fn is_clipped(&self, pixel: usize) -> bool {
        2 * usize::from(self.clipped[pixel]) > self.frames()
    }

    /// Mean light of the channels.
    pub(super) fn brightness(&self, pixel: usize) -> f32 {
        self.at(pixel).iter().sum::<f32>() / 3.0
    }
}

/// The noise is taken from one pixel of so many: a prime number, so that no pattern keeps step.
const NOISE_STEP: usize = 7;

/// What of the camera's picture the projector lights.
pub(super) struct Lit {
    /// White minus black of each pixel, mean of the channels; 0 where it is not lit.
    pub(super) white: Vec<f32>,
    /// Whether a pixel is lit and not clipped.
    pub(super) usable: Vec<bool>,
    /// Share of the picture that is lit.
    pub(super) share: f64,
    /// Share of the lit pixels that are clipped.
    pub(super) clipped: f64,
    /// Difference of white and black, in levels of 255, at the lit pixels' middle one.
    pub(super) levels: f64,
    /// Brightest byte, mean over the frames, that a twentieth of the lit pixels reach under white.
    pub(super) bright: f64,
}

impl Lit {
    pub(super) fn new(black: &Light, white: &Light) -> Self {
        let pixels = white.sums.len().min(black.sums.len());
        let mut gain: Vec<f32> = (0..pixels)
            .map(|k| white.brightness(k) - black.brightness(k))
            .collect();
        let frames = white.frames().min(black.frames()).max(1) as f64;
        let noise = white.noise().hypot(black.noise()) / frames.sqrt();
        let least = (LIT_SIGMA * noise as f32).max(LIT_SHARE * quantile(&gain, 0.95));
        let lit: Vec<usize> = (0..pixels).filter(|&k| gain[k] > least).collect();
        gain.iter_mut()
            .filter(|gain| **gain <= least)
            .for_each(|gain| *gain = 0.0);
        let usable = (0..pixels).map(|k| gain[k] > 0.0 && !white.is_clipped(k));
        let count = lit.len().max(1) as f64;
        let clipped = lit.iter().filter(|&&k| white.is_clipped(k)).count();
        let levels: Vec<f32> = lit.iter().map(|&k| white.levels(black, k)).collect();
        let frames = white.frames().max(1) as f32;
        let bright = lit.iter().map(|&k| {
            let sums = white.bytes[k];
            f32::from(sums.into_iter().max().unwrap_or(0)) / frames
        });
        Self {
            usable: usable.collect(),
            share: lit.len() as f64 / pixels.max(1) as f64,
            clipped: clipped as f64 / count,
            levels: f64::from(quantile(&levels, 0.5)),
            bright: f64::from(quantile(&bright.collect::<Vec<_>>(), 0.95)),
            white: gain,
        }
    }

    /// The pixels that are lit and not clipped.
    pub(super) fn usable_pixels(&self) -> impl Iterator<Item = usize> {
        let pixels = self.usable.iter().enumerate();
        pixels.filter(|(_, usable)| **usable).map(|(k, _)| k)
    }

    /// Share of the picture that is lit and not clipped.
    pub(super) fn usable_share(&self) -> f64 {
        self.usable_pixels().count() as f64 / self.usable.len().max(1) as f64
    }
}

/// The value below which a share of the values lies; 0 without values.
pub(super) fn quantile(values: &[f32], share: f64) -> f32 {
    let mut sorted = values.to_vec();
    let place = (share * values.len().saturating_sub(1) as f64).round() as usize;
    if place >= sorted.len() {
        return 0.0;
    }
    *sorted.select_nth_unstable_by(place, f32::total_cmp).1
}
