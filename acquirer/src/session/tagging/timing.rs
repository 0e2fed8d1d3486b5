//! What is known of a rig's timing: a prior for tagging, and the time a pattern must be held.

use serde::Serialize;

use super::{BANDS, Delay, Settling};

/// Share of a frame by which stamps and the projector's refreshes miss a hold. Where the rates are locked and no change
/// spoils two frames, the flashes bound a change by a frame, hardly closer: without this chance would decide whether two
/// frames are long enough.
const STAMPS_MISS: f64 = 0.02;

/// A measured time with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The best value, in milliseconds.
    pub ms: f64,
    /// The true value lies within this of the best one with a probability of 95 %, in milliseconds.
    pub uncertainty_ms: f64,
}

impl Estimate {
    /// A value as small as it may be, not below zero.
    #[must_use]
    pub fn at_least(self) -> f64 {
        (self.ms - self.uncertainty_ms).max(0.0)
    }

    /// A value as large as it may be.
    #[must_use]
    pub fn at_most(self) -> f64 {
        self.ms + self.uncertainty_ms
    }
}

/// The timing of projector and camera, see the conventions of [`super`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Timing {
    /// From the projector's word to its light, on the scale of the camera's stamps; it can be negative.
    pub latency: Estimate,
    /// Width of the range over which the latency spreads from picture to picture.
    pub jitter: Estimate,
    /// From the first row's exposure to the last row's.
    pub readout: Estimate,
    /// Exposure of one row.
    pub exposure: Estimate,
    /// Exposure, read-out and jitter together, the uncertainty upwards: for so long a change of the picture can be in
    /// frames.
    pub change: Estimate,
    /// From frame to frame, in milliseconds.
    pub frame_ms: f64,
    /// What the flashes show of it directly, if they tell enough.
    pub settling: Option<Settling>,
    /// How late the projector shows what is due, if that was seen.
    pub delay: Option<Delay>,
}

impl Timing {
    /// Least time between two changes such that between them lies one whole frame at least, whatever the phase, and
    /// such that the neighbours of a mixed frame hold no third pattern: a frame, its read-out and exposure, and the
    /// jitter, as long as these can be together, give or take what stamps miss.
    #[must_use]
    pub fn least_hold_ms(&self) -> f64 {
        (1.0 - STAMPS_MISS) * self.frame_ms + self.change.at_most()
    }

    /// The same for one band of the frames: a band is exposed in a fraction of the read-out.
    #[must_use]
    pub fn least_band_hold_ms(&self) -> f64 {
        let parts = [
            (self.exposure, 1.0),
            (self.readout, 1.0 / BANDS as f64),
            (self.jitter, 1.0),
        ];
        let parts = parts.map(|(part, share)| share * part.at_most());
        self.frame_ms + parts.iter().sum::<f64>()
    }

    /// Camera frames for which a pattern is held so that `whole` frames show nothing else: 2 for one frame when
    /// exposure, read-out and jitter together last no longer than a frame, when the flashes spoilt one each, or when
    /// changes can be kept between the frames that are wanted ([`Timing::begin_ms`]); more otherwise. Of several whole
    /// frames the inner ones are told by their neighbours, whatever the clocks say.
    #[must_use]
    pub fn hold_frames(&self, whole: usize) -> usize {
        let modelled = (self.least_hold_ms() / self.frame_ms).ceil() as usize;
        let least = match self.settling {
            Some(seen) if whole > 1 => modelled.min(seen.most_mixed + 1),
            Some(seen) if seen.watched => modelled.min(seen.hold_frames),
            _ => modelled,
        };
        let in_phase = self.hold_frames_in_phase().unwrap_or(least);
        least.min(in_phase).max(2) + whole.max(1) - 1
    }

    /// What the flashes show, where they were watched so well that the clocks can vouch for frames.
    pub(super) fn vouching(&self) -> Option<Settling> {
        self.settling.filter(|seen| seen.watched)
    }

    /// Whether the clocks vouch that a frame shows one pattern only, stamped so long after that was shown, and so long
    /// after the next one was, in milliseconds.
    #[must_use]
    pub fn is_settled(&self, since_ms: Option<f64>, since_next_ms: Option<f64>) -> bool {
        self.vouching().is_some_and(|seen| {
            since_ms.is_none_or(|since| since >= seen.new_from_ms)
                && since_next_ms.is_none_or(|since| since <= seen.old_until_ms)
        })
    }

    /// The timing of a rig that did worse than was measured, on a busy machine say: times count for less with each time
    /// but the first that frames were not recognised by them.
    #[must_use]
    pub fn after_failures(mut self, failures: usize) -> Self {
        let more = failures.saturating_sub(1) as f64;
        self.jitter.uncertainty_ms += more * self.frame_ms;
        self.settling = self.settling.filter(|_| failures < 2);
        self
    }

    /// From the projector's word until its picture is certainly all over a frame, as a time of the frame's stamp.
    #[must_use]
    pub fn settled_ms(&self) -> f64 {
        self.latency.at_most() + self.jitter.at_most() / 2.0 + self.exposure.at_most()
    }
}
