//! Light at some 10 000 places of the scene, in linear units.
//!
//! Takes the frames of a trial, gives for each place of a jittered lattice the light with the projector
//! black, the light that white adds, and the light that each shot adds; 1 is the camera's full scale,
//! sRGB-linearised. Without a black frame the darkest shot stands in for it, channel by channel; without a
//! white frame the brightest, which is white's light on the lines and nothing between them.

use std::sync::LazyLock;

use image::RgbImage;
use rayon::prelude::*;

use super::{ColourTrial, Shots, TILES};

/// About how many places are looked at.
const PLACES: f64 = 10_000.0;
/// A byte from which a channel counts as clipped.
const CLIPPED: u8 = 250;

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
#[derive(Debug, Clone)]
pub(super) struct Place {
    /// Number of its tile, row by row.
    pub tile: usize,
    /// Light with the projector black, per channel.
    pub dark: [f32; 3],
    /// Light that white adds.
    pub white: [f32; 3],
    /// Whether a channel is below full scale in every frame.
    pub usable: [bool; 3],
    /// Light that each colour's shot adds, in the order of the shots; may be negative by noise.
    pub shots: Vec<[f32; 3]>,
}

/// The places of a scene.
#[derive(Debug, Clone)]
pub(super) struct Places {
    /// In the order of the picture, row by row.
    pub places: Vec<Place>,
}

impl Places {
    pub(super) fn new(trial: &ColourTrial, shots: &[Shots<'_>]) -> Self {
        let places = match trial.shots.first() {
            Some((_, frame)) => {
                let (width, height) = frame.dimensions();
                let spots = lattice(width, height);
                let place = |&(x, y): &(u32, u32)| place(trial, shots, x, y);
                spots.par_iter().map(place).collect()
            }
            None => Vec::new(),
        };
        Self { places }
    }

    /// One place of a grey wall in a dim room, for when nothing was seen.
    pub(super) fn grey_wall() -> Self {
        let place = Place {
            tile: 0,
            dark: [0.05; 3],
            white: [0.3; 3],
            usable: [true; 3],
            shots: Vec::new(),
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

/// Places a fixed step apart, each row shifted by the golden section, so that they fall into step with no
/// grid.
pub(super) fn lattice(width: u32, height: u32) -> Vec<(u32, u32)> {
    let pixels = f64::from(width) * f64::from(height);
    let step = (pixels / PLACES).sqrt().round().max(1.0) as u32;
    let mut spots = Vec::new();
    for (n, y) in (step / 2..height).step_by(step as usize).enumerate() {
        let shift = (n as f64 * 0.618_034).fract() * f64::from(step);
        spots.extend((shift as u32..width).step_by(step as usize).map(|x| (x, y)));
    }
    spots
}

/// The tile that a pixel lies in.
pub(super) fn tile_of(x: u32, y: u32, width: u32, height: u32) -> usize {
    let along = |at: u32, length: u32, tiles: usize| {
        (at as usize * tiles / length.max(1) as usize).min(tiles - 1)
    };
    along(y, height, TILES.1) * TILES.0 + along(x, width, TILES.0)
}

fn place(trial: &ColourTrial, shots: &[Shots<'_>], x: u32, y: u32) -> Place {
    let mut usable = [true; 3];
    let mut light = |frames: &mut dyn Iterator<Item = &RgbImage>| {
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for frame in frames {
            let bytes = frame.get_pixel(x, y).0;
            count += 1.0;
            for c in 0..3 {
                sum[c] += linear(bytes[c]);
                usable[c] &= bytes[c] < CLIPPED;
            }
        }
        (count > 0.0).then(|| sum.map(|s| s / count))
    };
    let seen: Vec<[f32; 3]> = shots
        .iter()
        .filter_map(|shot| light(&mut shot.frames.iter().copied()))
        .collect();
    let extreme = |least: bool| {
        std::array::from_fn(|c| {
            let values = seen.iter().map(|light| light[c]);
            if least {
                values.fold(f32::INFINITY, f32::min)
            } else {
                values.fold(0.0, f32::max)
            }
        })
    };
    let dark: [f32; 3] = light(&mut trial.black.iter()).unwrap_or_else(|| extreme(true));
    let white = light(&mut trial.white.iter()).unwrap_or_else(|| extreme(false));
    let above = |light: [f32; 3]| std::array::from_fn(|c| light[c] - dark[c]);
    let (width, height) = trial.shots.first().map_or((1, 1), |(_, f)| f.dimensions());
    Place {
        tile: tile_of(x, y, width, height),
        dark,
        white: above(white),
        usable,
        shots: seen.into_iter().map(above).collect(),
    }
}
