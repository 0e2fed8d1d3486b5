//! Black and white light of every pixel side by side, for looking at scattered pixels: one access to memory instead of
//! seven. Rounded to 1/65535 of full light, which is a small part of the noise.

use rayon::prelude::*;

use super::{channels::Channels, response::Light};

/// Steps of light from 0 to 1.
const STEPS: f32 = 65535.0;

/// What the references say of one pixel.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(16))]
pub(super) struct Level {
    black: [u16; 3],
    white: [u16; 3],
    /// Bit 0, 1, 2 is set where red, green, blue was clipped.
    pub(super) clipped: u8,
}

impl Level {
    /// From linear light under black projection, what white adds to it, and the clipped channels' bits.
    pub(super) fn new(black: [f32; 3], white: [f32; 3], clipped: u8) -> Self {
        let step = |v: f32| (v * STEPS + 0.5) as u16; // saturates
        Self {
            black: black.map(step),
            white: white.map(step),
            clipped,
        }
    }

    /// Light under black projection.
    #[inline(always)]
    pub(super) fn black(&self) -> [f32; 3] {
        self.black.map(|v| f32::from(v) * (1.0 / STEPS))
    }

    /// Light that white projection adds.
    #[inline(always)]
    pub(super) fn white(&self) -> [f32; 3] {
        self.white.map(|v| f32::from(v) * (1.0 / STEPS))
    }
}

/// The levels of all pixels, row by row.
pub(super) fn levels(black: &Light, white: &Channels, clipped: &[u8]) -> Vec<Level> {
    let mut levels = vec![Level::default(); clipped.len()];
    levels.par_iter_mut().enumerate().for_each(|(at, level)| {
        *level = Level::new(black.channels.at(at), white.at(at), clipped[at]);
    });
    levels
}
