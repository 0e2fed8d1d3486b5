//! The camera from the back of its lens to the bytes of a frame.
//!
//! Takes the light of each pixel, gives 8-bit RGB. In order: lens blur, crosstalk of the colour filters, exposure,
//! one colour per pixel (Bayer), shot and read noise, saturation, the missing colours filled in, white balance,
//! tone curve, JPEG. Noise: the variance of a signal s is s / full well + (read noise / full well)², see
//! EMVA standard 1288.

mod bayer;

use image::{ImageFormat, RgbImage};
use jpeg_encoder::{ChromaSubsamplingMethod, ColorType, Encoder, SamplingFactor};
use rayon::prelude::*;

use super::{
    random::Random,
    scene::{CameraTable, ToneCurve},
    tone::srgb_from_linear,
};

/// Steps of the tone curve's table; fine enough for the steep start of the sRGB curve.
const TONE_STEPS: usize = 8192;

/// A camera's sensor and its processing.
#[derive(Debug, Clone)]
pub(super) struct Sensor {
    width: usize,
    height: usize,
    /// Exposed red, green and blue from the light's.
    response: [[f32; 3]; 3],
    blur_weights: Vec<f32>,
    bayer: bool,
    noise: Noise,
    white_balance: [f32; 3],
    tone: Vec<u8>,
    jpeg_quality: u8,
    random: Random,
}

/// Noise as a share of saturation.
#[derive(Debug, Clone, Copy)]
struct Noise {
    /// Variance per signal: 1 / full well.
    shot: f32,
    /// Variance in the dark.
    read: f32,
}

impl Noise {
    fn deviation(self, signal: f32) -> f32 {
        (self.shot * signal.max(0.0) + self.read).sqrt()
    }
}

impl Sensor {
    /// The sensor that a scene describes.
    pub(super) fn new(camera: &CameraTable, random: Random) -> Self {
        let exposed = |share: f64| (share * camera.exposure) as f32;
        let well = camera.full_well_electrons;
        let noise = if well > 0.0 {
            let read = camera.read_noise_electrons / well;
            Noise {
                shot: (1.0 / well) as f32,
                read: (read * read) as f32,
            }
        } else {
            Noise {
                shot: 0.0,
                read: 0.0,
            }
        };
        Self {
            width: camera.width as usize,
            height: camera.height as usize,
            response: camera.crosstalk.map(|row| row.map(exposed)),
            blur_weights: half_bell(camera.blur_px),
            bayer: camera.bayer,
            noise,
            white_balance: camera.white_balance.map(|gain| gain as f32),
            tone: tone_table(camera.tone_curve),
            jpeg_quality: camera.jpeg_quality,
            random,
        }
    }

    /// The frame that the sensor makes of light behind the lens; `signal` holds one entry per pixel. `gains` amplify
    /// red, green and blue after the sensor.
    pub(super) fn expose(
        &self,
        signal: &[[f32; 3]],
        frame_number: u64,
        gains: [f32; 3],
    ) -> RgbImage {
        let random = self.random.part(frame_number);
        let exposed = if self.bayer {
            bayer::fill_in(&self.mosaic(signal, random), self.width)
        } else {
            self.expose_all_colours(signal, random)
        };
        self.compress(self.develop(&exposed, gains))
    }

    /// One exposed, noisy colour per pixel.
    fn mosaic(&self, signal: &[[f32; 3]], random: Random) -> Vec<f32> {
        let mut mosaic = vec![0.0; signal.len()];
        let rows = mosaic
            .par_chunks_mut(self.width)
            .zip(signal.par_chunks(self.width));
        rows.enumerate().for_each(|(y, (mosaic, signal))| {
            let random = random.part(y as u64);
            for (x, (value, light)) in mosaic.iter_mut().zip(signal).enumerate() {
                let exposed = self.exposed(*light, bayer::colour(x, y));
                *value = self.read_out(exposed, random.normal(x as u64));
            }
        });
        mosaic
    }

    fn expose_all_colours(&self, signal: &[[f32; 3]], random: Random) -> Vec<[f32; 3]> {
        let mut exposed = vec![[0.0; 3]; signal.len()];
        let rows = exposed
            .par_chunks_mut(self.width)
            .zip(signal.par_chunks(self.width));
        rows.enumerate().for_each(|(y, (exposed, signal))| {
            let random = random.part(y as u64);
            for (x, (exposed, &light)) in exposed.iter_mut().zip(signal).enumerate() {
                *exposed = [0, 1, 2].map(|colour| {
                    let noise = random.normal(3 * x as u64 + colour as u64);
                    self.read_out(self.exposed(light, colour), noise)
                });
            }
        });
        exposed
    }

    #[inline]
    fn exposed(&self, light: [f32; 3], colour: usize) -> f32 {
        let weights = &self.response[colour];
        light[0] * weights[0] + light[1] * weights[1] + light[2] * weights[2]
    }

    /// A signal with its noise, cut at saturation; below black stays, as in raw pictures with an offset.
    #[inline]
    fn read_out(&self, exposed: f32, noise: f32) -> f32 {
        (exposed + noise * self.noise.deviation(exposed)).min(1.0)
    }

    fn develop(&self, signal: &[[f32; 3]], gains: [f32; 3]) -> Vec<u8> {
        let mut bytes = vec![0; 3 * signal.len()];
        let last = (TONE_STEPS - 1) as f32;
        let rows = bytes
            .par_chunks_mut(3 * self.width)
            .zip(signal.par_chunks(self.width));
        rows.for_each(|(bytes, signal)| {
            for (bytes, pixel) in bytes.chunks_exact_mut(3).zip(signal) {
                for c in 0..3 {
                    let level = (pixel[c] * self.white_balance[c] * gains[c]).clamp(0.0, 1.0);
                    bytes[c] = self.tone[(level * last + 0.5) as usize];
                }
            }
        });
        bytes
    }

    /// Through a JPEG file and back, with half the colour resolution as webcams do.
    fn compress(&self, bytes: Vec<u8>) -> RgbImage {
        let (width, height) = (self.width as u32, self.height as u32);
        let through_file = (self.jpeg_quality > 0)
            .then(|| self.through_jpeg(&bytes))
            .flatten();
        through_file
            .or_else(|| RgbImage::from_raw(width, height, bytes))
            .unwrap_or_else(|| RgbImage::new(width, height))
    }

    /// `None` if the encoder refuses, which it does for sides above 65535 px only; scenes allow 4096.
    fn through_jpeg(&self, bytes: &[u8]) -> Option<RgbImage> {
        let mut file = Vec::with_capacity(bytes.len() / 4);
        let mut encoder = Encoder::new(&mut file, self.jpeg_quality);
        encoder.set_sampling_factor(SamplingFactor::F_2_2);
        // the encoder's default takes the upper left of four pixels and so displaces colours by half a pixel
        encoder.set_chroma_subsampling_method(ChromaSubsamplingMethod::Average);
        let (width, height) = (
            u16::try_from(self.width).ok()?,
            u16::try_from(self.height).ok()?,
        );
        encoder.encode(bytes, width, height, ColorType::Rgb).ok()?;
        let decoded = image::load_from_memory_with_format(&file, ImageFormat::Jpeg).ok()?;
        Some(decoded.into_rgb8())
    }

    /// The light behind the lens.
    pub(super) fn blur(&self, signal: &[[f32; 3]]) -> Vec<[f32; 3]> {
        if self.blur_weights.len() < 2 {
            return signal.to_vec();
        }
        let mut across = vec![[0.0; 3]; signal.len()];
        across
            .par_chunks_mut(self.width)
            .enumerate()
            .for_each(|(y, out)| {
                for (k, weight) in self.blur_weights.iter().enumerate() {
                    for source in self.both_sides(y, k) {
                        add(out, &signal[source * self.width..][..self.width], *weight);
                    }
                }
            });
        let mut along = vec![[0.0; 3]; signal.len()];
        along
            .par_chunks_mut(self.width)
            .zip(across.par_chunks(self.width))
            .for_each(|(out, row)| {
                add(out, row, self.blur_weights[0]);
                for (k, weight) in self.blur_weights.iter().enumerate().skip(1) {
                    let k = k.min(self.width);
                    let (first, last) = (row[0], row[self.width - 1]);
                    add(&mut out[k..], &row[..self.width - k], *weight);
                    add(&mut out[..self.width - k], &row[k..], *weight);
                    add(&mut out[..k], &vec![first; k], *weight);
                    add(&mut out[self.width - k..], &vec![last; k], *weight);
                }
            });
        along
    }

    /// The rows `k` above and below row `y`, the outermost one repeated; row `y` itself once.
    fn both_sides(&self, y: usize, k: usize) -> impl Iterator<Item = usize> {
        let above = y.saturating_sub(k);
        let below = (y + k).min(self.height - 1);
        [above, below].into_iter().take(if k == 0 { 1 } else { 2 })
    }
}

#[inline]
fn add(out: &mut [[f32; 3]], source: &[[f32; 3]], weight: f32) {
    for (out, source) in out.as_flattened_mut().iter_mut().zip(source.as_flattened()) {
        *out += weight * source;
    }
}

/// The middle and one side of a Gaussian of deviation `sigma` px, whole sum 1.
fn half_bell(sigma: f64) -> Vec<f32> {
    let reach = (3.0 * sigma).ceil() as i32;
    let bell = |k: i32| {
        if k == 0 {
            1.0
        } else {
            (-0.5 * (f64::from(k) / sigma).powi(2)).exp()
        }
    };
    let sum: f64 = (-reach..=reach).map(bell).sum();
    (0..=reach).map(|k| (bell(k) / sum) as f32).collect()
}

/// The byte for each of [`TONE_STEPS`] levels of light from 0 to 1.
fn tone_table(curve: ToneCurve) -> Vec<u8> {
    let level = |step: usize| step as f32 / (TONE_STEPS - 1) as f32;
    let coded = |light: f32| match curve {
        ToneCurve::Srgb => srgb_from_linear(light),
        ToneCurve::Linear => light,
        ToneCurve::Power(degree) => light.powf(1.0 / degree as f32),
        ToneCurve::Contrast(strength) => {
            let byte = srgb_from_linear(light);
            let turn = std::f32::consts::TAU;
            byte - strength as f32 * (turn * byte).sin() / turn
        }
    };
    (0..TONE_STEPS)
        .map(|step| (coded(level(step)) * 255.0).round() as u8)
        .collect()
}
