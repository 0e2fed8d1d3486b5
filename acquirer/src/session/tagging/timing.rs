//! What is known of a rig's timing: a prior for tagging, and the time a pattern must be held.

use serde::Serialize;

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
    /// From frame to frame, in milliseconds.
    pub frame_ms: f64,
}

impl Timing {
    /// Least time between two changes such that between them lies one whole frame at least, whatever the phase, and
    /// such that the neighbours of a mixed frame hold no third pattern: a frame, its read-out and exposure, the jitter,
    /// and how uncertain these are together.
    #[must_use]
    pub fn least_hold_ms(&self) -> f64 {
        let parts = [self.readout, self.exposure, self.jitter];
        let span: f64 = parts.iter().map(|part| part.ms).sum();
        let squares: f64 = parts.iter().map(|part| part.uncertainty_ms.powi(2)).sum();
        self.frame_ms + span + squares.sqrt()
    }

    /// Camera frames for which a pattern is held so that `whole` frames show nothing else: 2 for one frame when
    /// exposure, read-out and jitter together last no longer than a frame, more otherwise.
    #[must_use]
    pub fn hold_frames(&self, whole: usize) -> usize {
        // the share of a frame that rounding may take without harm
        let least = (self.least_hold_ms() / self.frame_ms - 0.05).ceil() as usize;
        least.max(2) + whole.max(1) - 1
    }

    /// From the projector's word until its picture is certainly all over a frame, as a time of the frame's stamp.
    #[must_use]
    pub fn settled_ms(&self) -> f64 {
        self.latency.at_most() + self.jitter.at_most() / 2.0 + self.exposure.at_most()
    }
}
