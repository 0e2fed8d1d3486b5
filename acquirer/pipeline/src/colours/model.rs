//! The colour responses, estimated from the picture, and the likelihoods they give.

use shared::pattern::MAX_COLOURS;

use super::{
    ColourSettings, Evidence, Sample, Unit, Units,
    likelihood::Lanes,
    unmix::{KnownLight, Unmixing},
};

/// The colour responses and how well they explain the picture.
pub(super) struct Model<'a> {
    /// How many colours there are.
    count: usize,
    nominal: [[f32; 3]; MAX_COLOURS],
    unmixing: Unmixing,
    may_unmix: bool,
    responses: [[f32; 3]; MAX_COLOURS],
    /// The same, for likelihoods.
    lanes: Lanes,
    /// Error of the model itself, as a share of white light: interreflection, chroma smear, crosstalk.
    misfit: f32,
    gain_variance: f32,
    settings: &'a ColourSettings,
    buffers: &'a mut ModelBuffers,
    /// Before the first round.
    fresh: bool,
}

/// What the rounds keep between frames.
#[derive(Debug, Default)]
pub(super) struct ModelBuffers {
    /// Units whose colour is clear, and that colour.
    known: Vec<(usize, usize)>,
    /// The same of the round before.
    known_before: Vec<(usize, usize)>,
    lights: Vec<KnownLight>,
    /// Per colour and channel, the ratios to white of the clear units.
    ratios: [[Vec<f32>; 3]; MAX_COLOURS],
    deviations: Vec<f32>,
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

/// Light of the brightest channel that the correction leaves in another one.
const LEAK: f32 = 0.03;

impl<'a> Model<'a> {
    /// Nominal colours, before any round. Crosstalk can be told only where white was measured.
    pub(super) fn new(
        nominal: &[[f32; 3]],
        gain_spread: f64,
        may_unmix: bool,
        (settings, buffers): (&'a ColourSettings, &'a mut ModelBuffers),
    ) -> Self {
        let count = nominal.len().min(MAX_COLOURS);
        let mut colours = [[0.0; 3]; MAX_COLOURS];
        colours[..count].copy_from_slice(&nominal[..count]);
        Self {
            count,
            nominal: colours,
            unmixing: Unmixing::NONE,
            may_unmix,
            responses: colours,
            lanes: Lanes::new(&colours[..count]),
            misfit: 0.1,
            gain_variance: (gain_spread * gain_spread) as f32,
            settings,
            buffers,
            fresh: true,
        }
    }

    /// The responses found, in corrected channels.
    pub(super) fn responses(&self) -> &[[f32; 3]] {
        &self.responses[..self.count]
    }

    /// The evidence of a unit.
    pub(super) fn weigh(&self, unit: &Unit, samples: &[Sample]) -> Evidence {
        let share = (unit.step_px / self.settings.correlation_px.max(1.0)).min(1.0) as f32;
        self.weigh_samples(unit, samples, share, samples.len() as f32)
    }

    /// As [`Self::weigh`] from the mean of the samples: quick, and near enough to tell which lines are clear.
    fn weigh_mean(&self, unit: &Unit) -> Evidence {
        let mean = unit.mean.as_slice();
        let samples = unit.count as f32 * unit.step_px as f32;
        let independent = samples / self.settings.correlation_px.max(1.0) as f32;
        self.weigh_samples(unit, mean, independent.max(1.0), 1.0)
    }

    /// Sums over samples that tell `share` of a whole one each.
    fn weigh_samples(&self, unit: &Unit, samples: &[Sample], share: f32, count: f32) -> Evidence {
        let colours = self.count;
        let mut evidence = Evidence {
            nats: [0.0; MAX_COLOURS],
            ratio: [0.0; 3],
            signal: 0.0,
            clipped: unit.clipped,
        };
        let mut sums = LightSums::default();
        let lanes = &self.lanes;
        let clip = -self.settings.sample_clip_nats as f32;
        for sample in samples {
            let sample = &self.corrected(sample);
            let weights = self.weights(sample);
            let nats = lanes.log_likelihoods((sample, weights), self.gain_variance);
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

    /// Inverse variance of a sample's light per channel, the model's own error included.
    fn weights(&self, sample: &Sample) -> [f32; 3] {
        let brightest = sample.full.iter().copied().fold(0.0, f32::max);
        let leak = LEAK * brightest;
        std::array::from_fn(|c| {
            let misfit = self.misfit * sample.full[c];
            1.0 / (sample.variance[c] + misfit * misfit + leak * leak)
        })
    }

    /// The colour of a line that leaves no doubt about it.
    fn clear_colour(&self, unit: &Evidence) -> Option<usize> {
        const CLEAR_NATS: f32 = 3.0;
        const CLEAR_SIGNAL: f32 = 4.0;
        let colours = self.count;
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
    ///
    /// Gives whether anything may have changed.
    pub(super) fn refine(&mut self, units: &Units) -> bool {
        let mut buffers = std::mem::take(self.buffers);
        std::mem::swap(&mut buffers.known, &mut buffers.known_before);
        buffers.known.clear();
        let clear = units.all.iter().enumerate();
        let clear =
            clear.filter_map(|(at, unit)| Some((at, self.clear_colour(&self.weigh_mean(unit))?)));
        buffers.known.extend(clear);
        // responses and crosstalk follow from what is known alone
        let changed = self.fresh || buffers.known != buffers.known_before;
        self.fresh = false;
        if !changed {
            *self.buffers = buffers;
            return false;
        }
        if self.may_unmix {
            let known = buffers.known.iter();
            let lights = known.filter_map(|&(at, colour)| self.known_light(&units.all[at], colour));
            buffers.lights.clear();
            buffers.lights.extend(lights);
            self.unmixing = Unmixing::estimate(&buffers.lights);
        }
        self.find_ratios(units, &mut buffers);
        self.take_medians(&mut buffers);
        self.lanes = Lanes::new(self.responses());
        *self.buffers = buffers;
        true
    }

    fn find_ratios(&self, units: &Units, buffers: &mut ModelBuffers) {
        buffers.ratios.iter_mut().flatten().for_each(Vec::clear);
        for &(at, colour) in &buffers.known {
            let mut sums = LightSums::default();
            if let Some(mean) = &units.all[at].mean {
                sums.add(&self.corrected(mean));
            }
            for (ratios, ratio) in buffers.ratios[colour].iter_mut().zip(sums.ratio()) {
                if ratio.is_finite() {
                    ratios.push(ratio);
                }
            }
        }
    }

    fn take_medians(&mut self, buffers: &mut ModelBuffers) {
        const FEWEST: usize = 4;
        let ModelBuffers {
            ratios, deviations, ..
        } = buffers;
        deviations.clear();
        for (response, ratios) in self.responses.iter_mut().zip(ratios) {
            for (r, ratios) in response.iter_mut().zip(ratios) {
                if ratios.len() >= FEWEST {
                    *r = median(ratios).max(0.0);
                    deviations.extend(ratios.iter().map(|ratio| (ratio - *r).abs()));
                }
            }
        }
        if !deviations.is_empty() {
            self.misfit = (1.483 * median(deviations)).clamp(MISFIT_RANGE.0, MISFIT_RANGE.1);
        }
    }
}

fn median(values: &mut [f32]) -> f32 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}
