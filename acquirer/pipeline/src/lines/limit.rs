//! How strong a ridge must be to count as a line's.

use super::{LineSettings, along::AlongKernel, boxes::Boxes};

/// Strength of a line of gain 1 as wide as the boxes: the cubic spline's bend, 2 / side^2, times the variance.
pub(crate) const FULL_STRENGTH: f32 = 0.5;
/// Demosaicing and JPEG correlate neighbouring pixels: their noise survives smoothing about so many times
/// better than independent noise would.
const CORRELATED: f32 = 2.0;

/// How strong a ridge must be to begin a track.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RidgeLimit {
    /// Whatever the noise.
    pub(crate) least: f32,
    /// Standard deviations of noise.
    sigmas: f32,
    /// Standard deviation of a strength for one of 1 in each pixel's gain.
    pub(crate) smoothing: f32,
    /// The gain image's pull towards 0.
    shrink: f32,
}

impl RidgeLimit {
    /// For lines of this width, sampled every `step` pixels along them, in a gain image made with this `shrink`.
    pub(crate) fn new(width_px: f64, step: usize, shrink: f32, settings: &LineSettings) -> Self {
        let (boxes, along) = (Boxes::for_width(width_px), AlongKernel { step });
        Self {
            least: settings.share_of_full as f32 * FULL_STRENGTH,
            sigmas: settings.noise_sigma as f32,
            smoothing: CORRELATED * strength_per_fall(boxes, along) * boxes.noise() * along.noise(),
            shrink,
        }
    }

    /// The least strength above noise where a full line has this squared signal to noise.
    #[inline(always)]
    pub(crate) fn above_noise(&self, power: f32) -> f32 {
        self.sigmas * self.smoothing * power.sqrt() / (power + self.shrink)
    }

    /// Enough strength whatever a full line's squared signal to noise is.
    pub(crate) fn always_enough(&self) -> f32 {
        self.least.max(self.above_noise(self.shrink))
    }

    /// The least strength where a full line has this squared signal to noise.
    #[inline(always)]
    pub(crate) fn strength(&self, power: f32) -> f32 {
        self.least.max(self.above_noise(power))
    }
}

/// From a fall of the raw derivative to a ridge's strength, -s^2 g''.
pub(super) fn strength_per_fall(boxes: Boxes, along: AlongKernel) -> f32 {
    boxes.variance() / (boxes.weight() * along.weight())
}
