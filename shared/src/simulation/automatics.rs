//! A camera that changes exposure and white balance by itself.
//!
//! Takes frame after frame, gives the gains of the next one. The exposure drifts until the picture's mean light is
//! that of a grey card, the white balance until its three channels have the same mean (grey world); both exponentially,
//! as webcams do. A camera without automatics keeps its gains at 1.

use std::time::Duration;

use image::RgbImage;

use super::{scene::Scene, tone::linear_from_srgb};

/// Mean light that the exposure aims at: a grey card's.
const GREY_CARD: f32 = 0.18;
/// Smallest and largest gain of the exposure, and of a channel.
const EXPOSURE: (f32, f32) = (0.125, 8.0);
const CHANNEL: (f32, f32) = (0.5, 2.0);
/// Every so many bytes of a frame are looked at: a prime number of pixels.
const PIXELS: usize = 37;

/// The automatics of a camera and what they have come to.
#[derive(Debug, Clone)]
pub struct Automatics {
    exposure_s: f64,
    white_balance_s: f64,
    exposure: f32,
    white_balance: [f32; 3],
}

impl Automatics {
    /// The automatics of a scene's camera, before its first frame.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        Self {
            exposure_s: scene.faults.auto_exposure_s,
            white_balance_s: scene.faults.auto_white_balance_s,
            exposure: 1.0,
            white_balance: [1.0; 3],
        }
    }

    /// Whether anything changes by itself.
    #[must_use]
    pub fn are_on(&self) -> bool {
        self.exposure_s > 0.0 || self.white_balance_s > 0.0
    }

    /// Leaves the gains where they are from now on.
    pub fn hold(&mut self) {
        (self.exposure_s, self.white_balance_s) = (0.0, 0.0);
    }

    /// Takes a frame and the time to the next one into account.
    pub fn follow(&mut self, frame: &RgbImage, elapsed: Duration) {
        if !self.are_on() {
            return;
        }
        let [red, green, blue] = mean_light(frame);
        let towards = |gain: f32, change: f32, seconds: f64, (least, most): (f32, f32)| {
            if seconds <= 0.0 {
                return gain;
            }
            let step = 1.0 - (-elapsed.as_secs_f64() / seconds).exp() as f32;
            (gain * change.max(1e-3).powf(step)).clamp(least, most)
        };
        let brightness = (red + green + blue) / 3.0;
        let change = GREY_CARD / brightness.max(1e-4);
        self.exposure = towards(self.exposure, change, self.exposure_s, EXPOSURE);
        for (gain, mean) in self.white_balance.iter_mut().zip([red, green, blue]) {
            let change = green.max(1e-4) / mean.max(1e-4);
            *gain = towards(*gain, change, self.white_balance_s, CHANNEL);
        }
    }

    pub(super) fn exposure(&self) -> f32 {
        self.exposure
    }

    pub(super) fn white_balance(&self) -> [f32; 3] {
        self.white_balance
    }
}

fn mean_light(frame: &RgbImage) -> [f32; 3] {
    let pixels = frame.as_raw().chunks_exact(3).step_by(PIXELS);
    let (mut sums, mut count) = ([0.0; 3], 0.0_f32);
    for pixel in pixels {
        for (sum, &byte) in sums.iter_mut().zip(pixel) {
            *sum += linear_from_srgb(byte);
        }
        count += 1.0;
    }
    sums.map(|sum: f32| sum / count.max(1.0))
}
