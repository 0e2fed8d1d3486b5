//! Light at some 10 000 places of the scene, in linear units.
//!
//! Takes the frames of a trial, gives for each place of a jittered lattice the light with the projector
//! black, the light that white adds, and the light that each shot adds; 1 is the camera's full scale,
//! sRGB-linearised. Without a black frame the darkest shot stands in for it, channel by channel; without a
//! white frame the brightest, which is white's light on the lines and nothing between them.

use std::sync::LazyLock;

use image::RgbImage;
use rayon::prelude::*;
use shared::pattern::PALETTE_SIZE;

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
    pub(super) fn new(trial: &ColourTrial, shots: &[Shots<'_>]) -> Self {
        let Some((_, frame)) = trial.shots.first() else {
            return Self { places: Vec::new() };
        };
        let (width, height) = frame.dimensions();
        let frames = Frames {
            black: trial.black.iter().collect(),
            white: trial.white.iter().collect(),
            shots: shots.iter().map(|shot| &shot.frames[..]).collect(),
        };
        let spots = lattice(width, height);
        let place = |&(x, y): &(u32, u32)| {
            let at = 3 * (y as usize * width as usize + x as usize);
            frames.place(at, tile_of(x, y, width, height))
        };
        Self {
            places: spots.par_iter().map(place).collect(),
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

/// Pixels from one place to the next, across and down, for about [`PLACES`] places.
pub(super) fn lattice_step(width: u32, height: u32) -> u32 {
    let pixels = f64::from(width) * f64::from(height);
    (pixels / PLACES).sqrt().round().max(1.0) as u32
}

/// Where the lattice's row `n` begins, in pixels from the left: a share of the step by the golden section,
/// so that the rows fall into step with no grid.
pub(super) fn row_shift(n: usize, step: u32) -> u32 {
    ((n as f64 * 0.618_034).fract() * f64::from(step)) as u32
}

/// Places a fixed step apart, row by row.
pub(super) fn lattice(width: u32, height: u32) -> Vec<(u32, u32)> {
    let step = lattice_step(width, height);
    let mut spots = Vec::new();
    for (n, y) in (step / 2..height).step_by(step as usize).enumerate() {
        let xs = (row_shift(n, step)..width).step_by(step as usize);
        spots.extend(xs.map(|x| (x, y)));
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

/// The frames of a trial, by what they show.
struct Frames<'a> {
    black: Vec<&'a RgbImage>,
    white: Vec<&'a RgbImage>,
    shots: Vec<&'a [&'a RgbImage]>,
}

impl Frames<'_> {
    /// The place whose first byte stands at `at` in every frame.
    fn place(&self, at: usize, tile: usize) -> Place {
        let mut usable = [true; 3];
        let mut shots = [[0.0; 3]; PALETTE_SIZE];
        let (mut least, mut most) = ([f32::INFINITY; 3], [0.0; 3]);
        for (shot, frames) in shots.iter_mut().zip(&self.shots) {
            *shot = mean_light(frames, at, &mut usable).unwrap_or_default();
            least = std::array::from_fn(|c| f32::min(least[c], shot[c]));
            most = std::array::from_fn(|c| f32::max(most[c], shot[c]));
        }
        let dark = mean_light(&self.black, at, &mut usable).unwrap_or(least);
        let white = mean_light(&self.white, at, &mut usable).unwrap_or(most);
        let above = |light: [f32; 3]| std::array::from_fn(|c| light[c] - dark[c]);
        for shot in &mut shots[..self.shots.len().min(PALETTE_SIZE)] {
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
}

/// Light of one pixel averaged over frames; `None` without frames. Channels that clip are marked.
fn mean_light(frames: &[&RgbImage], at: usize, usable: &mut [bool; 3]) -> Option<[f32; 3]> {
    let mut sum = [0.0; 3];
    for frame in frames {
        let bytes = &frame.as_raw()[at..at + 3];
        for c in 0..3 {
            sum[c] += linear(bytes[c]);
            usable[c] &= bytes[c] < CLIPPED;
        }
    }
    let count = frames.len() as f32;
    (count > 0.0).then(|| sum.map(|s| s / count))
}
