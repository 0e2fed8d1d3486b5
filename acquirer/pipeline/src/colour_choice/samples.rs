//! Light at some thousand places of the scene, in linear units.
//!
//! Takes the thinned frames of a trial, gives for each place the light with the projector
//! black, the light that white adds, and the light that each shot adds; 1 is the camera's full scale,
//! sRGB-linearised. Without a black frame the darkest shot stands in for it, channel by channel; without a
//! white frame the brightest, which is white's light on the lines and nothing between them.

use std::sync::LazyLock;

use image::RgbImage;
use shared::pattern::PALETTE_SIZE;

use super::thin::ThinTrial;

/// A byte from which a channel counts as clipped.
pub(super) const CLIPPED: u8 = 250;

/// Linear light of each sRGB byte, 0 to 1 (IEC 61966-2-1).
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let value = byte as f64 / 255.0;
        if value <= 0.04045 {
            (value / 12.92) as f32
        } else {
            ((value + 0.055) / 1.055).powf(2.4) as f32
        }
    })
});

/// Linear light of a drive value or camera byte.
pub(super) fn linear(byte: u8) -> f32 {
    LINEAR[usize::from(byte)]
}

/// One place of the scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Number of its tile, row by row.
    pub tile: usize,
    /// Light with the projector black, per channel.
    pub dark: [f32; 3],
    /// Light that white adds.
    pub white: [f32; 3],
    /// Whether a channel is below full scale in every frame.
    pub usable: [bool; 3],
    /// Light that each colour's shot adds, in the order of the shots; may be negative by noise. 0 beyond the
    /// last shot.
    pub shots: [[f32; 3]; PALETTE_SIZE],
}

/// The places of a scene.
#[derive(Debug, Clone)]
pub(super) struct Places {
    /// In the order of the picture, row by row.
    pub places: Vec<Place>,
}

impl Places {
    pub(super) fn new(trial: &ThinTrial) -> Self {
        let (width, height) = trial.thinning.size;
        let linear: &[f32; 256] = &LINEAR;
        let place = |at: usize| {
            let tile = trial.thinning.tile(at % width, at / width);
            place(trial, linear, 3 * at, tile)
        };
        Self {
            places: (0..width * height).map(place).collect(),
        }
    }

    /// One place of a grey wall in a dim room, for when nothing was seen.
    pub(super) fn grey_wall() -> Self {
        let place = Place {
            tile: 0,
            dark: [0.05; 3],
            white: [0.3; 3],
            usable: [true; 3],
            shots: [[0.0; 3]; PALETTE_SIZE],
        };
        Self {
            places: vec![place],
        }
    }

    /// Share of the places where some channel is clipped, 0 to 1.
    pub(super) fn clipped_share(&self) -> f64 {
        let clipped = self.places.iter().filter(|p| p.usable.contains(&false));
        clipped.count() as f64 / self.places.len().max(1) as f64
    }
}

/// The place whose first byte stands at `at` in every thinned frame.
fn place(trial: &ThinTrial, linear: &[f32; 256], at: usize, tile: usize) -> Place {
    let mean_light =
        |frames: &[RgbImage], usable: &mut [bool; 3]| mean_light(frames, linear, at, usable);
    let mut usable = [true; 3];
    let mut shots = [[0.0; 3]; PALETTE_SIZE];
    for (shot, frames) in shots.iter_mut().zip(&trial.shots) {
        *shot = mean_light(frames, &mut usable).unwrap_or_default();
    }
    let lights = || shots[..trial.shots.len()].iter().copied();
    let most = |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|c| a[c].max(b[c]));
    let least = |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|c| a[c].min(b[c]));
    let dark = mean_light(&trial.black, &mut usable)
        .or_else(|| lights().reduce(least))
        .unwrap_or_default();
    let white = mean_light(&trial.white, &mut usable)
        .or_else(|| lights().reduce(most))
        .unwrap_or_default();
    let above = |light: [f32; 3]| std::array::from_fn(|c| light[c] - dark[c]);
    for shot in &mut shots[..trial.shots.len()] {
        *shot = above(*shot);
    }
    Place {
        tile,
        dark,
        white: above(white),
        usable,
        shots,
    }
}

/// Light of one pixel averaged over frames; `None` without frames. Channels that clip are marked.
#[inline]
fn mean_light(
    frames: &[RgbImage],
    linear: &[f32; 256],
    at: usize,
    usable: &mut [bool; 3],
) -> Option<[f32; 3]> {
    let mut sum = [0.0; 3];
    for frame in frames {
        let bytes = &frame.as_raw()[at..at + 3];
        for c in 0..3 {
            sum[c] += linear[usize::from(bytes[c])];
            usable[c] &= bytes[c] < CLIPPED;
        }
    }
    let count = frames.len() as f32;
    (count > 0.0).then(|| sum.map(|s| s / count))
}
