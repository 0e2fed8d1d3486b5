//! Which of the pattern's colours each line has at each crossing, as log-likelihoods.
//!
//! Takes the light of the coded grid, what white would give there, and the crossings' arms; gives for each
//! crossing and line one log-likelihood per colour. Along the arms light above black D is explained as
//! D = a s r_k + noise, s the light a white line would give, r_k the response of the camera to colour k
//! (one 3-vector per colour, the same on all surfaces: Caspi, Kiryati and Shamir 1998) and a a gain near
//! the unary grid's, integrated out. The r_k start from the nominal colours and are re-estimated from the
//! picture in a few rounds of assignment and median. Crosstalk between the camera's channels is estimated
//! in the same rounds and taken out first, since on a saturated surface it would change r_k. Samples are
//! clipped and their number is divided by their correlation length, so that margins stay honest. When two
//! of the chosen colours look alike on most of the scene, the rounds may settle between them; the margins
//! are then small, not wrong.

mod model;
mod unmix;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use shared::pattern::{Axis, MAX_COLOURS, Rgb};

use super::{
    crossings::{Arms, Crossings},
    line_light::{LineLight, PixelLight},
    lines::Lines,
    plane::Plane,
    response::Response,
};
use model::Model;

/// How colours are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ColourSettings {
    /// Rounds of estimating the colour responses, 0 (nominal colours) to 20.
    pub rounds: usize,
    /// Most one sample may speak against a colour, in nats, 1 to 50.
    pub sample_clip_nats: f64,
    /// Most one line at one crossing may speak against a colour, in nats, 1 to 100.
    pub crossing_clip_nats: f64,
    /// Neighbouring samples along a line that share one piece of information, in camera pixels, 1 to 20:
    /// demosaicing and subsampled chroma smear colour over two to three pixels.
    pub correlation_px: f64,
    /// Spread of the gain around the unary grid's, 0.01 to 2.
    pub gain_spread: f64,
    /// Spread of the gain when no unary grid gives it, 0.01 to 2.
    pub free_gain_spread: f64,
    /// A line is too dark when white would stand out of the noise by less than this, in standard deviations.
    pub dark_sigma: f64,
}

impl Default for ColourSettings {
    fn default() -> Self {
        Self {
            rounds: 4,
            sample_clip_nats: 6.0,
            crossing_clip_nats: 15.0,
            correlation_px: 2.5,
            gain_spread: 0.15,
            free_gain_spread: 0.5,
            dark_sigma: 1.0,
        }
    }
}

/// What one line's colour at one crossing may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Log-likelihood per colour in nats, 0 for the best, negative for the others.
    pub nats: [f32; MAX_COLOURS],
    /// Ratio to white per channel: the line's colour as seen.
    pub ratio: [f32; 3],
    /// Standard deviations by which white would stand out.
    pub signal: f32,
    /// Share of samples with a clipped channel, 0 to 1.
    pub clipped: f32,
}

/// The colours at all crossings.
#[derive(Debug, Clone, Default)]
pub struct Colours {
    /// Evidence for the flat line at each crossing.
    pub rows: Vec<Evidence>,
    /// Evidence for the steep line at each crossing.
    pub columns: Vec<Evidence>,
    /// The responses that were found: share of white light per channel, one per colour.
    pub responses: Vec<[f32; 3]>,
}

impl Colours {
    /// The evidence for lines of one direction, in the order of the crossings.
    #[must_use]
    pub fn on(&self, axis: Axis) -> &[Evidence] {
        match axis {
            Axis::Row => &self.rows,
            Axis::Column => &self.columns,
        }
    }
}

/// Light on the middle of a line, averaged a little across it.
#[derive(Debug, Clone, Copy)]
struct Sample {
    light: [f32; 3],
    full: [f32; 3],
    variance: [f32; 3],
}

/// The samples of one line at one crossing.
struct Unit {
    samples: Vec<Sample>,
    /// Their mean; `None` without any.
    mean: Option<Sample>,
    /// Distance between samples along the line, in camera pixels.
    step_px: f64,
    clipped: f32,
}

impl Unit {
    fn find_mean(&mut self) {
        let share = 1.0 / self.samples.len().max(1) as f32;
        let mean = |of: fn(&Sample) -> [f32; 3]| {
            std::array::from_fn(|c| self.samples.iter().map(|s| of(s)[c]).sum::<f32>() * share)
        };
        self.mean = (!self.samples.is_empty()).then(|| Sample {
            light: mean(|s| s.light),
            full: mean(|s| s.full),
            variance: mean(|s| s.variance),
        });
    }
}

/// Finds the colours of all lines at all crossings. `gain` is the unary grid's, if there is one.
#[must_use]
pub fn find_colours(
    light: &LineLight<'_>,
    gain: Option<&Plane>,
    lines: &Lines,
    crossings: &Crossings,
    nominal: &[[f32; 3]],
    settings: &ColourSettings,
) -> Colours {
    let sampler = Sampler { light, gain };
    let unit = |k: usize| {
        let (crossing, axis) = (&crossings.all[k / 2], Axis::BOTH[k % 2]);
        let family = lines.family(axis);
        sampler.unit(
            &family.tracks[crossing.arms(axis).track],
            crossing.arms(axis),
            crossing.along(axis),
            family.width_px,
            axis,
        )
    };
    let units: Vec<Unit> = (0..2 * crossings.all.len())
        .into_par_iter()
        .map(unit)
        .collect();
    let spread = if gain.is_some() {
        settings.gain_spread
    } else {
        settings.free_gain_spread
    };
    let mut model = Model::new(nominal, spread, light.white_is_measured, settings);
    for _ in 0..settings.rounds.min(20) {
        model.refine(&units);
    }
    let evidence = model.weigh_all(&units);
    let (rows, columns) = evidence
        .chunks_exact(2)
        .map(|pair| (pair[0], pair[1]))
        .unzip();
    Colours {
        rows,
        columns,
        responses: model.into_responses(),
    }
}

/// Linear light of a nominal colour, 0 to 1 per channel.
#[must_use]
pub fn nominal_response(colour: Rgb) -> [f32; 3] {
    let projector = Response::new(&super::response::ResponseSettings::default());
    colour.0.map(|byte| projector.linear(byte))
}

struct Sampler<'a> {
    light: &'a LineLight<'a>,
    gain: Option<&'a Plane>,
}

impl Sampler<'_> {
    fn unit(
        &self,
        track: &super::lines::Track,
        arms: &Arms,
        along: f64,
        width_px: f64,
        axis: Axis,
    ) -> Unit {
        /// Samples on one arm: more of them hardly tell more.
        const MOST: f64 = 8.0;
        let ways = [0, 1].map(|side| (arms.outer_px[side] - arms.inner_px).max(0.0));
        let step_px = (ways[0].max(ways[1]) / MOST).max(1.0);
        let mut unit = Unit {
            samples: Vec::with_capacity(2 * MOST as usize + 2),
            mean: None,
            step_px,
            clipped: 0.0,
        };
        let aside = (0.25 * width_px).clamp(1.0, 2.0);
        let mut tried = 0;
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            if !arms.seen[side] {
                continue;
            }
            for step in 0..=(ways[side] / step_px) as usize {
                let at = along + sign * (arms.inner_px + step as f64 * step_px);
                let Some(across) = track.at(at, 0.0) else {
                    continue;
                };
                tried += 1;
                match self.sample(axis, at, across, aside) {
                    Some(sample) => unit.samples.push(sample),
                    None => unit.clipped += 1.0,
                }
            }
        }
        unit.clipped /= tried.max(1) as f32;
        unit.find_mean();
        unit
    }

    /// The mean of three pixels across the line; `None` where all channels are clipped.
    fn sample(&self, axis: Axis, along: f64, across: f64, aside: f64) -> Option<Sample> {
        let add = |sum: &mut [f32; 3], values: [f32; 3]| {
            let pairs = sum.iter_mut().zip(values);
            pairs.for_each(|(sum, value)| *sum += value / 3.0);
        };
        let (mut sum, mut gain, mut usable) = (PixelLight::default(), 0.0, [true; 3]);
        for offset in [-aside, 0.0, aside] {
            let (x, y) = match axis {
                Axis::Row => (along, across + offset),
                Axis::Column => (across + offset, along),
            };
            let (x, y) = self.pixel(x, y);
            let pixel = self.light.at(x, y);
            add(&mut sum.above_black, pixel.above_black);
            add(&mut sum.white, pixel.white);
            add(&mut sum.variance, pixel.variance);
            usable = std::array::from_fn(|c| usable[c] && pixel.usable[c]);
            gain += self.gain.map_or(1.0, |plane| plane.row(y)[x]) / 3.0;
        }
        let gain = gain.clamp(0.1, 1.5);
        usable.contains(&true).then(|| Sample {
            light: sum.above_black,
            full: sum.white.map(|white| gain * white),
            variance: sum.variance,
        })
    }

    /// The pixel that holds a position, or the nearest one.
    fn pixel(&self, x: f64, y: f64) -> (usize, usize) {
        let inside = |position: f64, length: usize| (position.max(0.0) as usize).min(length - 1);
        (
            inside(x, self.light.width()),
            inside(y, self.light.height()),
        )
    }
}
