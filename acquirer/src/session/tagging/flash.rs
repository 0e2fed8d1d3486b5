//! The timing of a rig from black and white flashes in a pseudo-random order.
//!
//! Takes when each flash was shown and, for each frame, how far its bands are on the way from black to white; gives the
//! [`Timing`] with its uncertainty. First the whole sequence is correlated with the frames: the peak is the latency,
//! whatever it is. Then latency, read-out (later in lower bands), exposure (how long a band is between black and white)
//! and jitter (how much the changes spread) are those under which the frames are likeliest; a value's uncertainty is
//! how far it can move before they become clearly less likely. It fails quietly when something else in the scene
//! flickers in step with the flashes, which their irregular order makes unlikely.

use super::{
    Delay, Estimate, Timing,
    settling::{Settling, SinceFlash},
};

/// Latencies that are looked for, in milliseconds.
const SEARCHED_MS: (f64, f64) = (-200.0, 1200.0);
/// Standard deviation of a band's share, and the most one share can cost.
const SHARE_SIGMA: f64 = 0.04;
const SHARE_MOST: f64 = 12.0;
/// Steps between the delays tried for one change, over the width of the jitter: so many, and more where each would be
/// longer than this share of a frame, since a band's share can change by some standard deviations meanwhile.
const DELAY_STEPS: f64 = 8.0;
const DELAY_STEP: f64 = 0.05;
/// Rounds of the search, each twice as fine.
const ROUNDS: u32 = 6;
/// Where the search starts, as shares of the ranges of read-out and jitter.
const STARTS: [f64; 3] = [0.05, 0.3, 0.8];
/// Widest jitter looked for: in milliseconds, or a frame if that is longer.
const MOST_JITTER_MS: f64 = 60.0;
/// Mean jitter before any frame is seen, in milliseconds: decides where no frame tells, because all changes fall between
/// two exposures.
const USUAL_JITTER_MS: f64 = 5.0;
/// Doublings of a 64th of a frame that a value is moved by at most.
const FARTHEST: u32 = 7;
/// Halvings of the last step, where a value must be known better than by its doublings.
const HALVINGS: u32 = 3;
/// A value that costs this many nats more is outside of its uncertainty: two standard deviations.
const CLEARLY_LESS: f64 = 2.0;
/// Mean agreement of frames and flashes, -1 to 1, below which there is no peak.
const LEAST_AGREEMENT: f64 = 0.6;

/// A change to black or to white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flash {
    /// When the projector says that it is shown, in milliseconds on the clock of the stamps.
    pub shown_ms: f64,
    /// When it was due at the projector, on the same clock.
    pub due_ms: f64,
    /// White, or black.
    pub white: bool,
}

/// A frame: its stamp in milliseconds and each band's share of white, 0 to 1, `None` where black and white look alike.
type Shares = (f64, Vec<Option<f32>>);

/// The timing under which the frames are likeliest; `None` when they do not follow the flashes.
///
/// The flashes are in order and before the first one black was up for a while. Frames given twice must be left out.
#[must_use]
pub fn find_timing(flashes: &[Flash], frames: &[Shares], frame_ms: f64) -> Option<Timing> {
    let coarse = correlate(flashes, frames, frame_ms)?;
    let changes = changes(flashes, frames, coarse);
    let fit = Fit {
        changes: &changes,
        frame_ms,
    };
    let best = fit.best(coarse);
    let middle = fit.uncertainty(best, Axis::Middle);
    let readout = fit.uncertainty(best, Axis::Readout);
    let exposure = fit.uncertainty(best, Axis::Exposure);
    let change = best.exposure + best.readout + best.jitter;
    let jitter = Estimate {
        ms: best.jitter,
        uncertainty_ms: fit.uncertainty(best, Axis::Jitter),
    };
    let seen = changes.iter().map(|change| &change.frames[..]);
    let late = flashes.iter().map(|flash| flash.shown_ms - flash.due_ms);
    let settling = Settling::of_changes(seen, (best.middle, frame_ms), jitter);
    let mut timing = Timing {
        latency: Estimate {
            ms: best.latency(),
            uncertainty_ms: middle.hypot(readout / 2.0).hypot(exposure / 2.0),
        },
        jitter,
        readout: Estimate {
            ms: best.readout,
            uncertainty_ms: readout,
        },
        exposure: Estimate {
            ms: best.exposure,
            uncertainty_ms: exposure,
        },
        change: Estimate {
            ms: change,
            uncertainty_ms: fit.longest_change(best) - change,
        },
        frame_ms,
        settling,
        delay: Delay::of(late.collect()),
    };
    timing.settling = settling.map(|seen| seen.tightened(&timing));
    Some(timing)
}

/// The delay at which frames and flashes agree best.
fn correlate(flashes: &[Flash], frames: &[Shares], frame_ms: f64) -> Option<f64> {
    let step = frame_ms / 8.0;
    let count = ((SEARCHED_MS.1 - SEARCHED_MS.0) / step) as usize;
    let means: Vec<(f64, f64)> = frames
        .iter()
        .filter_map(|(stamp, shares)| {
            let seen: Vec<f32> = shares.iter().flatten().copied().collect();
            let mean = seen.iter().sum::<f32>() / seen.len() as f32;
            (!seen.is_empty()).then(|| (*stamp, f64::from(mean.clamp(0.0, 1.0))))
        })
        .collect();
    let agreement = |delay: f64| {
        let products = means.iter().map(|(stamp, share)| {
            let white = newest(flashes, stamp - delay).is_some_and(|flash| flash.white);
            (2.0 * share - 1.0) * if white { 1.0 } else { -1.0 }
        });
        products.sum::<f64>() / means.len().max(1) as f64
    };
    let delays = (0..count).map(|k| SEARCHED_MS.0 + k as f64 * step);
    let scored: Vec<(f64, f64)> = delays.map(|delay| (delay, agreement(delay))).collect();
    let peak = scored.iter().map(|(_, score)| *score).fold(0.0, f64::max);
    // the top is flat where no frame falls into a change: its middle is the best guess
    let top: Vec<f64> = scored
        .iter()
        .filter(|(_, score)| *score >= peak - 1e-3)
        .map(|(delay, _)| *delay)
        .collect();
    let middle = (top.first()? + top.last()?) / 2.0;
    (peak >= LEAST_AGREEMENT).then_some(middle)
}

fn newest(flashes: &[Flash], moment: f64) -> Option<&Flash> {
    let after = flashes.partition_point(|flash| flash.shown_ms <= moment);
    after.checked_sub(1).map(|k| &flashes[k])
}

/// The frames around one change: time since the change was shown, and each band's share of the new light.
struct Change {
    frames: Vec<SinceFlash>,
}

/// Gives each frame to the change that is nearest to it under a delay; flashes that change nothing are none.
fn changes(flashes: &[Flash], frames: &[Shares], delay: f64) -> Vec<Change> {
    let mut last = false;
    let real: Vec<&Flash> = flashes
        .iter()
        .filter(|flash| std::mem::replace(&mut last, flash.white) != flash.white)
        .collect();
    let mut changes: Vec<Change> = real.iter().map(|_| Change { frames: Vec::new() }).collect();
    for (stamp, shares) in frames {
        let away = |flash: &Flash| (stamp - delay - flash.shown_ms).abs();
        let nearest = (0..real.len()).min_by(|&a, &b| away(real[a]).total_cmp(&away(real[b])));
        if let Some(k) = nearest {
            let white = real[k].white;
            let new = |share: &Option<f32>| {
                share.map(|share| f64::from(if white { share } else { 1.0 - share }))
            };
            let since = stamp - real[k].shown_ms;
            changes[k]
                .frames
                .push((since, shares.iter().map(new).collect()));
        }
    }
    changes
}

/// What the frames are predicted from, in milliseconds.
#[derive(Debug, Clone, Copy)]
struct Model {
    /// Stamp, since the change was shown, of a frame whose middle row is half old and half new.
    middle: f64,
    readout: f64,
    exposure: f64,
    jitter: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Axis {
    Middle,
    Readout,
    Exposure,
    Jitter,
}

impl Axis {
    const ALL: [Self; 4] = [Self::Middle, Self::Readout, Self::Exposure, Self::Jitter];
}

impl Model {
    fn latency(&self) -> f64 {
        self.middle - self.exposure / 2.0 + self.readout / 2.0
    }

    fn at(mut self, axis: Axis, value: f64) -> Self {
        match axis {
            Axis::Middle => self.middle = value,
            Axis::Readout => self.readout = value,
            Axis::Exposure => self.exposure = value,
            Axis::Jitter => self.jitter = value,
        }
        self
    }

    fn value(&self, axis: Axis) -> f64 {
        match axis {
            Axis::Middle => self.middle,
            Axis::Readout => self.readout,
            Axis::Exposure => self.exposure,
            Axis::Jitter => self.jitter,
        }
    }

    /// Share of the new light in a band (0 to 1 down the picture) of a frame stamped so long after the change was
    /// shown.
    fn share(&self, since: f64, band: f64) -> f64 {
        let end = since + band * self.readout - self.latency();
        (end / self.exposure).clamp(0.0, 1.0)
    }
}

struct Fit<'a> {
    changes: &'a [Change],
    frame_ms: f64,
}

impl Fit<'_> {
    /// Minus the logarithm of the likelihood, and what a jitter costs beforehand.
    fn cost(&self, model: &Model) -> f64 {
        let changes = self.changes.iter();
        let seen: f64 = changes
            .map(|change| change_cost(change, model, self.frame_ms))
            .sum();
        seen + model.jitter / USUAL_JITTER_MS
    }

    /// What a value may be: no exposure or read-out is longer than a frame.
    fn range(&self, axis: Axis) -> (f64, f64) {
        match axis {
            Axis::Middle => (f64::NEG_INFINITY, f64::INFINITY),
            Axis::Readout => (0.0, self.frame_ms),
            Axis::Exposure => (0.5, self.frame_ms),
            Axis::Jitter => (0.0, MOST_JITTER_MS.max(self.frame_ms)),
        }
    }

    /// The likeliest model of all: from a few starts roughly, from the best of them finely. The peak of the correlation
    /// is where a band in the middle is half black and half white.
    fn best(&self, middle: f64) -> Model {
        let start = Model {
            middle,
            readout: 0.0,
            exposure: self.frame_ms / 4.0,
            jitter: 0.0,
        };
        let (_, most_jitter) = self.range(Axis::Jitter);
        let starts = STARTS.iter().flat_map(|&readout| {
            STARTS.map(|jitter| Model {
                readout: readout * self.frame_ms,
                jitter: jitter * most_jitter,
                ..start
            })
        });
        let rough = starts.map(|start| self.best_near(start, self.frame_ms / 2.0, None));
        let costs = rough.map(|model| (self.cost(&model), model));
        let best = costs.min_by(|a, b| a.0.total_cmp(&b.0));
        let best = best.map_or(start, |(_, model)| model);
        self.best_near(best, self.frame_ms / 8.0, None)
    }

    /// The likeliest model around one, along one axis after the other in finer and finer steps; one axis may be fixed.
    fn best_near(&self, start: Model, reach: f64, fixed: Option<Axis>) -> Model {
        let mut best = start;
        for round in 0..ROUNDS {
            let step = reach / f64::from(2_u32 << round);
            for axis in Axis::ALL {
                if Some(axis) != fixed {
                    best = self.best_along(best, axis, step);
                }
            }
        }
        best
    }

    fn best_along(&self, model: Model, axis: Axis, step: f64) -> Model {
        let (low, high) = self.range(axis);
        let centre = model.value(axis);
        let tried = (-2..=2).map(|k| {
            let value = (centre + f64::from(k) * step).clamp(low, high);
            model.at(axis, value)
        });
        let costs = tried.map(|model| (self.cost(&model), model));
        let best = costs.min_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or(model, |(_, best)| best)
    }

    /// How long exposure, read-out and jitter may be together before the frames are clearly less likely, in
    /// milliseconds. Where every change falls into the same part of a frame, each of them alone is hardly known, but
    /// what they add up to is: a longer sum would have mixed frames that were whole.
    fn longest_change(&self, best: Model) -> f64 {
        let limit = self.cost(&best) + CLEARLY_LESS;
        let shortest = best.exposure + best.readout + best.jitter;
        let longest = 2.0 * self.frame_ms + self.range(Axis::Jitter).1;
        let possible = |change: f64| {
            let scale = change / shortest;
            let stretched = Model {
                readout: (scale * best.readout).min(self.frame_ms),
                exposure: (scale * best.exposure).min(self.frame_ms),
                ..best
            };
            [best, stretched].into_iter().any(|start| {
                let moved = self.best_of_length(start, change);
                self.cost(&moved) <= limit
            })
        };
        let steps = (0..FARTHEST).map(|k| self.frame_ms / 64.0 * f64::from(1_u32 << k));
        let (mut inside, mut outside) = (shortest, longest);
        for step in steps {
            let change = shortest + step;
            if change > longest || !possible(change) {
                outside = outside.min(change);
                break;
            }
            inside = change;
        }
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(inside, outside);
            if possible(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        outside
    }

    /// The likeliest model around one whose exposure, read-out and jitter together last so long, in milliseconds.
    fn best_of_length(&self, start: Model, change: f64) -> Model {
        let of_length = |model: Model| Model {
            exposure: change - model.readout - model.jitter,
            ..model
        };
        let (least, most) = self.range(Axis::Exposure);
        let fits = |model: &Model| (least..=most).contains(&model.exposure);
        let mut best = of_length(start);
        if !fits(&best) {
            let spare = change - start.exposure;
            best = of_length(Model {
                readout: spare.clamp(0.0, self.frame_ms),
                jitter: (spare - self.frame_ms).clamp(0.0, self.range(Axis::Jitter).1),
                ..start
            });
        }
        for round in 0..ROUNDS {
            let step = self.frame_ms / f64::from(8_u32 << round);
            for axis in [Axis::Middle, Axis::Readout, Axis::Jitter] {
                let (low, high) = self.range(axis);
                let tried = (-2..=2).map(|k| {
                    let value = (best.value(axis) + f64::from(k) * step).clamp(low, high);
                    of_length(best.at(axis, value))
                });
                let costs = tried.filter(fits).map(|model| (self.cost(&model), model));
                let least = costs.min_by(|a, b| a.0.total_cmp(&b.0));
                best = least.map_or(best, |(_, model)| model);
            }
        }
        best
    }

    /// How far a value can move, the others following it, before the frames are clearly less likely, in milliseconds.
    fn uncertainty(&self, model: Model, axis: Axis) -> f64 {
        let (low, high) = self.range(axis);
        let centre = model.value(axis);
        let limit = self.cost(&model) + CLEARLY_LESS;
        let far = |sign: f64| {
            let steps = (0..FARTHEST).map(|k| self.frame_ms / 64.0 * f64::from(1_u32 << k));
            let outside = steps.clone().find(|step| {
                let value = centre + sign * step;
                if !(low..=high).contains(&value) {
                    return true;
                }
                let moved = self.best_near(model.at(axis, value), *step, Some(axis));
                self.cost(&moved) > limit
            });
            let outside = outside.or_else(|| steps.clone().next_back());
            let outside = outside.unwrap_or(self.frame_ms);
            // beyond its range a value cannot be
            let room = if sign > 0.0 {
                high - centre
            } else {
                centre - low
            };
            outside.min(room)
        };
        far(1.0).max(far(-1.0))
    }
}

/// The cost of one change: its own delay within the jitter is not known, so all are possible.
fn change_cost(change: &Change, model: &Model, frame_ms: f64) -> f64 {
    let steps = (model.jitter / (DELAY_STEP * frame_ms))
        .ceil()
        .max(DELAY_STEPS);
    let costs: Vec<f64> = (0..=steps as usize)
        .map(|k| {
            let delay = model.jitter * (k as f64 / steps - 0.5);
            let frames = change.frames.iter();
            frames
                .map(|(since, shares)| frame_cost(since - delay, shares, model))
                .sum()
        })
        .collect();
    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let likelihood: f64 = costs.iter().map(|cost| (least - cost).exp()).sum();
    least - (likelihood / costs.len() as f64).ln()
}

fn frame_cost(since: f64, shares: &[Option<f64>], model: &Model) -> f64 {
    let count = shares.len() as f64;
    let bands = shares.iter().enumerate();
    bands
        .filter_map(|(k, share)| {
            let miss = (*share)? - model.share(since, (k as f64 + 0.5) / count);
            Some((0.5 * (miss / SHARE_SIGMA).powi(2)).min(SHARE_MOST))
        })
        .sum()
}
