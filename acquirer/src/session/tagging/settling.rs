//! From when on frames are whole after a change, straight from the flashes: what the clocks can vouch for.
//!
//! Takes the frames around each flash, gives the last time since a flash at which frames were still as before it, and the
//! first at which they were all new. Nothing is modelled there, so it holds for the phases that the flashes had, and they
//! are those of every later change where the projector's rate and the camera's are locked: there exposure and read-out may
//! stay unknown, since no flash falls into them, and it does no harm. Where they are known and the phases were few, they
//! say it closer. It fails quietly when jitter grows after the flashes; what frames look like is asked as well.

use serde::Serialize;

use super::{Estimate, Timing, runs::GAP_FRAMES};

/// Share of the new light in every band of a frame that is new, less this, and of one that is old, at most: what noise
/// and a camera's own curve can make of none.
const TOLERATED: f64 = 0.08;
/// A frame in which fewer bands than this share can be judged says nothing.
const LEAST_JUDGED: f64 = 0.5;
/// Frames further from the change than this many frame times are not needed.
const REACH_FRAMES: f64 = 3.0;
/// Where the latency spreads over more than this share of a frame, sixteen flashes say too little.
const MOST_JITTER_FRAMES: f64 = 0.8;
/// What stamps and clocks miss, in milliseconds, and how much further than seen the latency may spread, as a share of the
/// largest jitter that may be: that fifteen changes of sixteen flashes all stay in one half of it is one case in 30 000.
const MISS_MS: f64 = 2.0;
const JITTER_SHARE: f64 = 0.5;
/// Share of the changes that must have been watched for the clocks to vouch for frames.
const LEAST_WATCHED: f64 = 0.9;
/// Longest hold that is thought of, in frames.
const MOST_HELD: usize = 8;

/// Times of frames' stamps since a change was shown, in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Settling {
    /// Frames up to here have none of the new light.
    pub old_until_ms: f64,
    /// Frames from here on have the new light only.
    pub new_from_ms: f64,
    /// For how many frames a pattern is best held so that one of them is whole: those that are not have to be shown again.
    pub hold_frames: usize,
    /// Most frames of one change that were neither old nor new.
    pub most_mixed: usize,
    /// Hardly a change fell beside a frame that was lost or given twice. Otherwise too few changes were seen to tell how far
    /// they spread, and the clocks vouch for nothing.
    pub watched: bool,
}

/// A frame near a flash: its time since that was shown, and the share of the new light in each band.
pub(super) type SinceFlash = (f64, Vec<Option<f64>>);

impl Settling {
    /// From the frames around each change; `middle` is about where a frame is half old and half new. `None` when old or
    /// new frames were not seen, or the latency spreads too much.
    pub(super) fn of_changes<'a>(
        changes: impl Iterator<Item = &'a [SinceFlash]> + Clone,
        (middle, frame_ms): (f64, f64),
        jitter: Estimate,
    ) -> Option<Self> {
        if jitter.at_most() > MOST_JITTER_FRAMES * frame_ms {
            return None;
        }
        let near = |frame: &&SinceFlash| {
            (frame.0 - middle).abs() <= REACH_FRAMES * frame_ms && is_judged(&frame.1)
        };
        let all = || changes.clone().flatten().filter(near);
        let is_new = |frame: &SinceFlash| known(&frame.1).all(|share| share >= 1.0 - TOLERATED);
        let is_old = |frame: &SinceFlash| known(&frame.1).all(|share| share <= TOLERATED);
        let last_not_new = all().filter(|f| !is_new(f)).map(|f| f.0);
        let last_not_new = last_not_new.fold(f64::NEG_INFINITY, f64::max);
        let first_not_old = all().filter(|f| !is_old(f)).map(|f| f.0);
        let first_not_old = first_not_old.fold(f64::INFINITY, f64::min);
        let new_from = all().map(|f| f.0).filter(|since| *since > last_not_new);
        let new_from = new_from.fold(f64::INFINITY, f64::min);
        let old_until = all().map(|f| f.0).filter(|since| *since < first_not_old);
        let old_until = old_until.fold(f64::NEG_INFINITY, f64::max);
        if !new_from.is_finite() || !old_until.is_finite() {
            return None;
        }
        let margin = MISS_MS + JITTER_SHARE * jitter.at_most();
        let mixed = changes.clone().map(|frames| {
            let between = frames.iter().filter(|frame| {
                frame.0 > old_until + 0.5 * MISS_MS && frame.0 < new_from - 0.5 * MISS_MS
            });
            between.count()
        });
        let mut settling = Self {
            old_until_ms: old_until - margin,
            new_from_ms: new_from + margin,
            hold_frames: 2,
            most_mixed: mixed.max().unwrap_or(0),
            watched: watched_share(changes.clone(), middle, frame_ms) >= LEAST_WATCHED,
        };
        let phases = changes.filter_map(|frames| frames.first().map(|frame| frame.0));
        settling.hold_frames = settling.best_hold(&phases.collect::<Vec<_>>(), frame_ms);
        Some(settling)
    }

    /// With what the measured times say of it where that is closer: the flashes' phases may have been few.
    pub(super) fn tightened(mut self, timing: &Timing) -> Self {
        if self.watched {
            let spread = MISS_MS + (0.5 + JITTER_SHARE) * timing.jitter.at_most();
            let new_from = timing.latency.at_most() + timing.exposure.at_most() + spread;
            let latency = timing.latency.ms - timing.latency.uncertainty_ms;
            let old_until = latency - timing.readout.at_most() - spread;
            self.new_from_ms = self.new_from_ms.min(new_from);
            self.old_until_ms = self.old_until_ms.max(old_until);
        }
        self
    }

    /// The hold that takes the least time on average, where frames come at times since a change like these.
    fn best_hold(&self, phases: &[f64], frame_ms: f64) -> usize {
        let took = |hold: usize| {
            let has_whole = |phase: &f64| {
                let first = ((self.new_from_ms - phase) / frame_ms).ceil() * frame_ms + phase;
                first <= hold as f64 * frame_ms + self.old_until_ms
            };
            let whole = phases.iter().filter(|phase| has_whole(phase)).count() as f64;
            let missed = 1.0 - whole / phases.len().max(1) as f64;
            // what is shown again is held for a frame longer
            hold as f64 + missed * (hold + 1) as f64
        };
        let holds = 2..=MOST_HELD;
        let best = holds.min_by(|&a, &b| took(a).total_cmp(&took(b)));
        best.unwrap_or(MOST_HELD)
    }
}

/// Share of the changes whose middle lies between two frames that follow each other.
fn watched_share<'a>(
    changes: impl Iterator<Item = &'a [SinceFlash]> + Clone,
    middle: f64,
    frame_ms: f64,
) -> f64 {
    let is_watched = |frames: &&[SinceFlash]| {
        let after = frames.partition_point(|frame| frame.0 < middle);
        let pair = after.checked_sub(1).zip(frames.get(after));
        pair.is_some_and(|(before, next)| next.0 - frames[before].0 <= GAP_FRAMES * frame_ms)
    };
    let watched = changes.clone().filter(is_watched).count();
    watched as f64 / changes.count().max(1) as f64
}

fn known(shares: &[Option<f64>]) -> impl Iterator<Item = f64> + '_ {
    shares.iter().flatten().copied()
}

fn is_judged(shares: &[Option<f64>]) -> bool {
    known(shares).count() as f64 >= LEAST_JUDGED * shares.len().max(1) as f64
}
