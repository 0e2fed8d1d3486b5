//! The colour responses, estimated from the picture, and the likelihoods they give.

use rayon::prelude::*;
use shared::pattern::MAX_COLOURS;

use super::{
    ColourSettings, Evidence, Sample, Unit,
    unmix::{KnownLight, Unmixing},
};

/// The colour responses and how well they explain the picture.
pub(super) struct Model<'a> {
    nominal: Vec<[f32; 3]>,
    unmixing: Unmixing,
    may_unmix: bool,
    responses: Vec<[f32; 3]>,
    /// Error of the model itself, as a share of white light: interreflection, chroma smear, crosstalk.
    misfit: f32,
    gain_variance: f32,
    settings: &'a ColourSettings,
}

/// Light of a line and light that white would give, weighted by what noise leaves of them.
#[derive(Debug, Default)]
struct LightSums {
    top: [f32; 3],
    bottom: [f32; 3],
    /// Squared signal to noise of white, summed over channels.
    power: f32,
}

impl LightSums {
    fn add(&mut self, sample: &Sample) {
        for c in 0..3 {
            let weight = sample.full[c] / sample.variance[c];
            self.top[c] += sample.light[c] * weight;
            self.bottom[c] += sample.full[c] * weight;
            self.power += sample.full[c] * weight;
        }
    }

    /// Light as a share of white's, per channel; not a number where the surface hardly returns the channel,
    /// which then tells nothing about the colour's response in it.
    fn ratio(&self) -> [f32; 3] {
        let strongest = self.bottom.iter().copied().fold(0.0, f32::max);
        std::array::from_fn(|c| {
            let tells = self.bottom[c] > 1e-3 && self.bottom[c] > 0.02 * strongest;
            if tells {
                self.top[c] / self.bottom[c]
            } else {
                f32::NAN
            }
        })
    }
}

/// Smallest and largest error of the model, as a share of white light.
const MISFIT_RANGE: (f32, f32) = (0.04, 0.3);

/// Keeps the product of three variances far from the smallest number that can be told from 0.
const VARIANCE_SCALE: f32 = 1e4;

/// Light of the brightest channel that the correction leaves in another one.
const LEAK: f32 = 0.03;

impl<'a> Model<'a> {
    /// Nominal colours, before any round. Crosstalk can be told only where white was measured.
    pub(super) fn new(
        nominal: &[[f32; 3]],
        gain_spread: f64,
        may_unmix: bool,
        settings: &'a ColourSettings,
    ) -> Self {
        let nominal: Vec<[f32; 3]> = nominal.iter().copied().take(MAX_COLOURS).collect();
        Self {
            responses: nominal.clone(),
            nominal,
            unmixing: Unmixing::NONE,
            may_unmix,
            misfit: 0.1,
            gain_variance: (gain_spread * gain_spread) as f32,
            settings,
        }
    }

    /// The responses found, in corrected channels.
    pub(super) fn into_responses(self) -> Vec<[f32; 3]> {
        self.responses
    }

    /// The evidence of all units.
    pub(super) fn weigh_all(&self, units: &[Unit]) -> Vec<Evidence> {
        units.par_iter().map(|unit| self.weigh(unit)).collect()
    }

    fn weigh(&self, unit: &Unit) -> Evidence {
        let samples = unit.samples.len() as f32;
        let share = (unit.step_px / self.settings.correlation_px.max(1.0)).min(1.0) as f32;
        self.weigh_samples(unit, &unit.samples, share, samples)
    }

    /// As [`Self::weigh`] from the mean of the samples: quick, and near enough to tell which lines are clear.
    fn weigh_mean(&self, unit: &Unit) -> Evidence {
        let mean = unit.mean.as_slice();
        let samples = unit.samples.len() as f32 * unit.step_px as f32;
        let independent = samples / self.settings.correlation_px.max(1.0) as f32;
        self.weigh_samples(unit, mean, independent.max(1.0), 1.0)
    }

    /// Sums over samples that tell `share` of a whole one each.
    fn weigh_samples(&self, unit: &Unit, samples: &[Sample], share: f32, count: f32) -> Evidence {
        let colours = self.responses.len();
        let mut evidence = Evidence {
            nats: [0.0; MAX_COLOURS],
            ratio: [0.0; 3],
            signal: 0.0,
            clipped: unit.clipped,
        };
        let mut sums = LightSums::default();
        let clip = -self.settings.sample_clip_nats as f32;
        for sample in samples {
            let sample = &self.corrected(sample);
            let mut nats = [0.0; MAX_COLOURS];
            for (value, &response) in nats.iter_mut().zip(&self.responses) {
                *value = self.log_likelihood(sample, response);
            }
            let best = nats[..colours].iter().copied().fold(f32::MIN, f32::max);
            for (sum, value) in evidence.nats.iter_mut().zip(nats).take(colours) {
                *sum += (value - best).max(clip);
            }
            sums.add(sample);
        }
        evidence.ratio = sums.ratio();
        evidence.signal = (sums.power / count.max(1.0)).sqrt();
        let best = evidence.nats[..colours]
            .iter()
            .copied()
            .fold(f32::MIN, f32::max);
        let clip = -self.settings.crossing_clip_nats as f32;
        for value in &mut evidence.nats[..colours] {
            *value = ((*value - best) * share).max(clip);
        }
        evidence
    }

    fn corrected(&self, sample: &Sample) -> Sample {
        Sample {
            light: self.unmixing.light(sample.light),
            full: self.unmixing.light(sample.full).map(|full| full.max(0.0)),
            variance: self.unmixing.variance(sample.variance),
        }
    }

    /// Normal log-likelihood with the gain integrated out (matrix determinant and inversion lemmas).
    fn log_likelihood(&self, sample: &Sample, response: [f32; 3]) -> f32 {
        let brightest = sample.full.iter().copied().fold(0.0, f32::max);
        let leak = LEAK * brightest;
        let (mut ee, mut em, mut mm, mut product) = (0.0, 0.0, 0.0, 1.0);
        for (c, response) in response.into_iter().enumerate() {
            let model = sample.full[c] * response;
            let error = sample.light[c] - model;
            let misfit = self.misfit * sample.full[c];
            let variance = sample.variance[c] + misfit * misfit + leak * leak;
            ee += error * error / variance;
            em += error * model / variance;
            mm += model * model / variance;
            product *= variance * VARIANCE_SCALE;
        }
        let spread = 1.0 + self.gain_variance * mm;
        -0.5 * (ee - self.gain_variance * em * em / spread + (product * spread).ln())
    }

    /// The colour of a line that leaves no doubt about it.
    fn clear_colour(&self, unit: &Evidence) -> Option<usize> {
        const CLEAR_NATS: f32 = 3.0;
        const CLEAR_SIGNAL: f32 = 4.0;
        let colours = self.responses.len();
        let best = (0..colours).max_by(|&a, &b| unit.nats[a].total_cmp(&unit.nats[b]))?;
        let close = (0..colours).any(|k| k != best && unit.nats[k] > -CLEAR_NATS);
        (unit.signal > CLEAR_SIGNAL && !close).then_some(best)
    }

    /// Mean light of a line relative to white's strongest channel; `None` where a channel was clipped.
    fn known_light(&self, unit: &Unit, colour: usize) -> Option<KnownLight> {
        /// Largest nominal response of a primary that a colour counts as lacking.
        const LACKING: f32 = 0.05;
        let mean = unit.mean.filter(|_| unit.clipped == 0.0)?;
        let brightest = mean.full.iter().copied().fold(0.0, f32::max);
        (brightest > 0.0).then(|| KnownLight {
            light: mean.light.map(|light| light / brightest),
            lacks: self.nominal[colour].map(|response| response < LACKING),
        })
    }

    /// Medians of the ratios of the lines that clearly have a colour become that colour's response, after
    /// their light has told the crosstalk.
    pub(super) fn refine(&mut self, units: &[Unit]) {
        const FEWEST: usize = 4;
        let known: Vec<(usize, usize)> = units
            .iter()
            .enumerate()
            .filter_map(|(at, unit)| Some((at, self.clear_colour(&self.weigh_mean(unit))?)))
            .collect();
        if self.may_unmix {
            let lights: Vec<KnownLight> = known
                .iter()
                .filter_map(|&(at, colour)| self.known_light(&units[at], colour))
                .collect();
            self.unmixing = Unmixing::estimate(&lights);
        }
        let mut ratios = vec![[const { Vec::new() }; 3]; self.responses.len()];
        for &(at, colour) in &known {
            let mut sums = LightSums::default();
            if let Some(mean) = &units[at].mean {
                sums.add(&self.corrected(mean));
            }
            let ratio = sums.ratio();
            let finite = ratio.iter().enumerate().filter(|(_, r)| r.is_finite());
            finite.for_each(|(c, &ratio)| ratios[colour][c].push(ratio));
        }
        let mut deviations = Vec::new();
        for (response, ratios) in self.responses.iter_mut().zip(&mut ratios) {
            for (r, ratios) in response.iter_mut().zip(ratios) {
                if ratios.len() >= FEWEST {
                    *r = median(ratios).max(0.0);
                    deviations.extend(ratios.iter().map(|ratio| (ratio - *r).abs()));
                }
            }
        }
        if !deviations.is_empty() {
            self.misfit = (1.483 * median(&mut deviations)).clamp(MISFIT_RANGE.0, MISFIT_RANGE.1);
        }
    }
}

fn median(values: &mut [f32]) -> f32 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}
