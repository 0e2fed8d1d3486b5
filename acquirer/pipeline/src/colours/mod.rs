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

mod likelihood;
mod model;
mod unmix;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use shared::pattern::{Axis, MAX_COLOURS, Rgb};

use super::{
    crossings::Crossings,
    gain::GainImage,
    line_light::{LineLight, Looker},
    lines::Lines,
    response::Response,
};
use model::{Model, ModelBuffers};

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
    /// Most samples of a line on either side of a crossing, 2 to 9: more of them tell dim colours better.
    pub samples: usize,
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
            samples: 9,
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
#[derive(Debug, Clone, Copy, Default)]
struct Sample {
    light: [f32; 3],
    full: [f32; 3],
    variance: [f32; 3],
}

impl Sample {
    fn add(&mut self, other: &Self) {
        for c in 0..3 {
            self.light[c] += other.light[c];
            self.full[c] += other.full[c];
            self.variance[c] += other.variance[c];
        }
    }

    fn scaled(self, share: f32) -> Self {
        Self {
            light: self.light.map(|v| share * v),
            full: self.full.map(|v| share * v),
            variance: self.variance.map(|v| share * v),
        }
    }
}

/// The samples of one line at one crossing, told together.
#[derive(Debug, Clone, Copy, Default)]
struct Unit {
    /// How many there are.
    count: usize,
    /// Their mean; `None` without any.
    mean: Option<Sample>,
    /// Distance between samples along the line, in camera pixels.
    step_px: f64,
    clipped: f32,
}

/// The samples of all lines at all crossings.
#[derive(Debug, Default)]
struct Units {
    all: Vec<Unit>,
    /// [`MOST_SAMPLES`] places for each unit.
    samples: Vec<Sample>,
}

/// Samples on one arm: more of them hardly tell more.
const MOST_ON_ARM: usize = 9;
/// Pixels of one sample, across the line.
const ACROSS: usize = 3;
/// Samples of one line at one crossing.
const MOST_SAMPLES: usize = 2 * MOST_ON_ARM;

impl Units {
    /// Each unit with its samples.
    fn iter(&self) -> impl Iterator<Item = (&Unit, &[Sample])> {
        let samples = self.samples.chunks_exact(MOST_SAMPLES);
        self.all
            .iter()
            .zip(samples)
            .map(|(unit, samples)| (unit, &samples[..unit.count]))
    }
}

/// What finding colours keeps between frames.
#[derive(Debug, Default)]
pub struct ColourBuffers {
    units: Units,
    model: ModelBuffers,
}

/// What the colours are seen in.
#[derive(Debug, Clone, Copy)]
pub struct ColouredLines<'a> {
    /// Light of the coded grid.
    pub light: &'a LineLight<'a>,
    /// The unary grid's gain, if there is one.
    pub gain: Option<&'a GainImage>,
    /// The lines.
    pub lines: &'a Lines,
    /// Their crossings.
    pub crossings: &'a Crossings,
}

/// Finds the colours of all lines at all crossings. `nominal` are the linear responses of the pattern's colours.
pub fn find_colours(
    seen: &ColouredLines<'_>,
    nominal: &[[f32; 3]],
    settings: &ColourSettings,
    (buffers, colours): (&mut ColourBuffers, &mut Colours),
) {
    let ColourBuffers { units, model } = buffers;
    let sampler = Sampler {
        seen,
        looker: seen.light.looker(),
        least_step_px: settings.correlation_px.max(1.0),
        most_steps: (settings.samples.clamp(2, MOST_ON_ARM) - 1) as f64,
    };
    let count = 2 * seen.crossings.all.len();
    units.all.clear();
    units.all.resize(count, Unit::default());
    units
        .samples
        .resize(count * MOST_SAMPLES, Sample::default());
    let places = units.samples.par_chunks_exact_mut(MOST_SAMPLES);
    let units_and_places = units.all.par_iter_mut().zip(places).enumerate();
    units_and_places.for_each(|(k, (unit, samples))| {
        *unit = sampler.sample_unit(k / 2, Axis::BOTH[k % 2], samples);
    });
    let spread = if seen.gain.is_some() {
        settings.gain_spread
    } else {
        settings.free_gain_spread
    };
    let mut model = Model::new(
        nominal,
        spread,
        seen.light.white_is_measured,
        (settings, model),
    );
    for _ in 0..settings.rounds.min(20) {
        if !model.refine(units) {
            break;
        }
    }
    colours.rows.clear();
    colours.columns.clear();
    for (k, (unit, samples)) in units.iter().enumerate() {
        let evidence = model.weigh(unit, samples);
        match Axis::BOTH[k % 2] {
            Axis::Row => colours.rows.push(evidence),
            Axis::Column => colours.columns.push(evidence),
        }
    }
    colours.responses.clear();
    colours.responses.extend_from_slice(model.responses());
}

/// Linear light of a nominal colour, 0 to 1 per channel.
#[must_use]
pub fn nominal_response(colour: Rgb) -> [f32; 3] {
    let projector = Response::new(&super::response::ResponseSettings::default());
    colour.0.map(|byte| projector.linear(byte))
}

struct Sampler<'a> {
    seen: &'a ColouredLines<'a>,
    looker: Looker<'a>,
    /// Shortest distance between samples along a line, in camera pixels: nearer ones share what they tell.
    least_step_px: f64,
    /// Most samples on an arm, less one.
    most_steps: f64,
}

impl Sampler<'_> {
    /// Samples both arms of one line at a crossing.
    fn sample_unit(&self, crossing: usize, axis: Axis, samples: &mut [Sample]) -> Unit {
        let crossing = &self.seen.crossings.all[crossing];
        let (arms, along) = (crossing.arms(axis), crossing.along(axis));
        let family = self.seen.lines.family(axis);
        let track = &family.tracks[arms.track];
        let ways = [0, 1].map(|side| (arms.outer_px[side] - arms.inner_px).max(0.0));
        let step_px = (ways[0].max(ways[1]) / self.most_steps).max(self.least_step_px);
        let aside = (0.25 * family.width_px).clamp(1.0, 2.0);
        let mut places = [[0; ACROSS]; MOST_SAMPLES];
        let mut found = 0;
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            if !arms.seen[side] {
                continue;
            }
            for step in 0..=(ways[side] / step_px) as usize {
                let at = along + sign * (arms.inner_px + step as f64 * step_px);
                if let Some(across) = track.at(at, 0.0) {
                    places[found] = self.pixels(axis, (at, across), aside);
                    found += 1;
                }
            }
        }
        let places = &places[..found];
        self.looker.fetch(places.as_flattened().iter().copied());
        let (mut count, mut clipped, mut sum) = (0, 0, Sample::default());
        for &pixels in places {
            match self.sample(pixels) {
                Some(sample) => {
                    sum.add(&sample);
                    samples[count] = sample;
                    count += 1;
                }
                None => clipped += 1,
            }
        }
        Unit {
            count,
            mean: (count > 0).then(|| sum.scaled(1.0 / count as f32)),
            step_px,
            clipped: clipped as f32 / (count + clipped).max(1) as f32,
        }
    }

    /// Pixels side by side across a line, numbered row by row.
    #[inline]
    fn pixels(&self, axis: Axis, (along, across): (f64, f64), aside: f64) -> [usize; ACROSS] {
        let (width, height) = (self.seen.light.width(), self.seen.light.height());
        // the pixel that holds a position, or the nearest one
        let inside = |position: f64, length: usize| (position.max(0.0) as usize).min(length - 1);
        let number = |across: f64| match axis {
            Axis::Row => inside(across, height) * width + inside(along, width),
            Axis::Column => inside(along, height) * width + inside(across, width),
        };
        [
            number(across - aside),
            number(across),
            number(across + aside),
        ]
    }

    /// The mean of pixels across the line; `None` where all channels are clipped.
    #[inline]
    fn sample(&self, pixels: [usize; ACROSS]) -> Option<Sample> {
        let light = self.looker.mean_at(pixels);
        let gain = self.seen.gain.map_or(1.0, |image| {
            let width = self.seen.light.width();
            let gains = pixels.iter().map(|at| image.at(at % width, at / width));
            (gains.sum::<f32>() / pixels.len() as f32).clamp(0.1, 1.5)
        });
        light.usable.contains(&true).then(|| Sample {
            light: light.above_black,
            full: light.white.map(|white| gain * white),
            variance: light.variance,
        })
    }
}
