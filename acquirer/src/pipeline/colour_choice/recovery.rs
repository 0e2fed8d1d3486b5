//! The thesis's score of a colour: how many pixels of a grid in that colour survive (chapters 4.2, 5.2.1).
//!
//! Takes the frames of a trial, gives for each colour the pixels left after the hue and saturation background
//! is removed and the colour's light is cut by a masked threshold, with the histogram of their hues: what
//! the thesis's window showed under HIST. Without a black frame the darkest value of each channel over the
//! shots stands in for one.

use std::f32::consts::TAU;

use image::RgbImage;
use rayon::prelude::*;

use super::{ColourTrial, HISTOGRAM_BINS, Shots};
use crate::pipeline::thesis::{
    background::Background, hsl::Hsl, settings::ThesisSettings, threshold::recover_grid,
};

/// What was recovered of one colour's grid.
#[derive(Debug, Clone)]
pub(super) struct Recovered {
    /// Number of pixels.
    pub count: usize,
    /// Hues of these pixels.
    pub hue_histogram: Vec<u32>,
}

/// Recovers the grid of each colour from the first of its frames.
pub(super) fn recover(trial: &ColourTrial, shots: &[Shots<'_>]) -> Vec<Recovered> {
    let darkest;
    let black = if trial.black.is_empty() {
        darkest = darkest_of(shots);
        std::slice::from_ref(&darkest)
    } else {
        &trial.black[..]
    };
    let background = Background::new(black);
    shots
        .par_iter()
        .map(|shot| recover_one(shot, background.as_ref()))
        .collect()
}

fn recover_one(shot: &Shots<'_>, background: Option<&Background>) -> Recovered {
    let mut hue_histogram = vec![0; HISTOGRAM_BINS];
    let (Some(frame), Some(background)) = (shot.frames.first(), background) else {
        return Recovered {
            count: 0,
            hue_histogram,
        };
    };
    let colour = shot.entry.colour;
    let k = ThesisSettings::default().background_sigmas;
    let mask = background.foreground(frame, k, false).mask;
    let grid = recover_grid(frame, Some(background), &mask, colour);
    for (at, bytes) in frame.as_raw().chunks_exact(3).enumerate() {
        if !grid.covers(at) {
            continue;
        }
        if let Some(hue) = Hsl::new([bytes[0], bytes[1], bytes[2]]).hue {
            let bin = (hue / TAU * HISTOGRAM_BINS as f32) as usize;
            hue_histogram[bin.min(HISTOGRAM_BINS - 1)] += 1;
        }
    }
    Recovered {
        count: grid.count,
        hue_histogram,
    }
}

fn darkest_of(shots: &[Shots<'_>]) -> RgbImage {
    let mut frames = shots.iter().filter_map(|shot| shot.frames.first());
    let mut darkest: RgbImage = frames
        .next()
        .map_or_else(RgbImage::default, |f| (*f).clone());
    for frame in frames {
        for (least, byte) in darkest.iter_mut().zip(frame.as_raw()) {
            *least = (*least).min(*byte);
        }
    }
    darkest
}
