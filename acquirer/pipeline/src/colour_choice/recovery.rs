//! The thesis's score of a colour: how many pixels of a grid in that colour survive (chapters 4.2, 5.2.1).
//!
//! Takes the frames of a trial, gives for each colour the pixels left after the hue and saturation background
//! is removed and the colour's light is cut by a masked threshold, with the histogram of their hues: what
//! the thesis's window showed under HIST. Without a black frame the darkest value of each channel over the
//! shots stands in for one.
//!
//! The method runs on the thinned frames (`thin`) and its counts are scaled up: at 640 x 480 from one pixel in 81. A
//! count of N pixels there is uncertain by about its root; since all colours are counted at the same pixels, their
//! order is surer than that. The background's variance borrows from neighbours, which stand farther apart in a thinned
//! frame, so that all colours lose some pixels along the borders of surfaces.

use std::f32::consts::TAU;

use image::RgbImage;
use shared::pattern::Rgb;

use super::{HISTOGRAM_BINS, thin::ThinTrial};
use crate::thesis::{
    background::Background, hsl::Hsl, settings::ThesisSettings, threshold::recover_grid,
};

/// What was recovered of one colour's grid.
#[derive(Debug, Clone)]
pub(super) struct Recovered {
    /// Number of pixels of the whole picture.
    pub count: usize,
    /// Hues of these pixels.
    pub hue_histogram: Vec<u32>,
}

/// Recovers the grid of each colour from the first of its frames.
pub(super) fn recover(trial: &ThinTrial, colours: &[Rgb]) -> Vec<Recovered> {
    let firsts = trial.shots.iter().filter_map(|frames| frames.first());
    let stand_in = match trial.black.is_empty() {
        true => darkest_of(firsts.clone()),
        false => None,
    };
    let black = stand_in.as_slice();
    let black = if black.is_empty() {
        &trial.black
    } else {
        black
    };
    let Some(background) = Background::new(black) else {
        return Vec::new();
    };
    let scale = trial.thinning.scale;
    let shots = firsts.zip(colours);
    shots
        .map(|(frame, &colour)| recover_one(frame, colour, &background, scale))
        .collect()
}

fn recover_one(frame: &RgbImage, colour: Rgb, background: &Background, scale: f64) -> Recovered {
    let mut hue_histogram = [0_u32; HISTOGRAM_BINS];
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
    let scaled = |count: f64| (count * scale).round();
    Recovered {
        count: scaled(grid.count as f64) as usize,
        // rounded down, so that the bins never hold more than there is
        hue_histogram: hue_histogram
            .iter()
            .map(|&count| (f64::from(count) * scale) as u32)
            .collect(),
    }
}

fn darkest_of<'a>(mut frames: impl Iterator<Item = &'a RgbImage>) -> Option<RgbImage> {
    let mut darkest = frames.next()?.clone();
    for frame in frames {
        for (least, byte) in darkest.iter_mut().zip(frame.as_raw()) {
            *least = (*least).min(*byte);
        }
    }
    Some(darkest)
}

#[cfg(test)]
mod tests {
    use super::super::{ColourTrial, thin::Thinning};
    use super::*;
    use shared::pattern::NamedColour;

    const COLOURS: [[u8; 3]; 4] = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 0, 255]];

    /// A wall of two paints under a grid of 5 px lines, with noise that repeats in no frame.
    fn wall(colour: [u8; 3], seed: u32) -> RgbImage {
        RgbImage::from_fn(640, 480, |x, y| {
            let on_line = x % 43 < 5 || y % 32 < 5;
            let paint = if x / 90 % 2 == 0 {
                [40, 70, 90]
            } else {
                [90, 80, 30]
            };
            image::Rgb(std::array::from_fn(|c| {
                let mix = (x * 7919 + y * 104_729 + c as u32 * 31) ^ (seed * 65_537);
                let noise = (mix.wrapping_mul(2_654_435_761) >> 16) % 5;
                let light = u32::from(colour[c]) * paint[c] / 255 * u32::from(on_line);
                (40 + paint[c] / 3 + light + noise) as u8
            }))
        })
    }

    #[test]
    fn a_count_on_the_lattice_is_nearly_that_of_all_pixels() {
        let shot = |(k, colour): (usize, &[u8; 3])| {
            let entry = NamedColour {
                name: format!("colour {k}"),
                colour: Rgb(*colour),
            };
            (entry, wall(*colour, 10 + k as u32))
        };
        let trial = ColourTrial {
            black: vec![wall([0; 3], 1), wall([0; 3], 2)],
            white: Vec::new(),
            shots: COLOURS.iter().enumerate().map(shot).collect(),
        };
        let shots = super::super::shots_by_colour(&trial).unwrap();
        let colours = COLOURS.map(Rgb);
        let counts = |step: u32| -> Vec<f64> {
            let thinned = ThinTrial::of_step(&trial, &shots, Thinning::of_step(640, 480, step));
            let found = recover(&thinned, &colours);
            found.iter().map(|colour| colour.count as f64).collect()
        };
        let (all, some) = (counts(1), counts(9));
        for (all, some) in all.iter().zip(&some) {
            assert!(*all > 5000.0, "{all}");
            assert!((some - all).abs() < 0.1 * all, "{some} of {all}");
        }
    }
}
