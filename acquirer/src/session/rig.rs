//! The rig: a projector at the end of a wire and a camera that looks at its light.

use std::time::Duration;

use shared::{pattern::PatternError, protocol::View, stage::Stage};
use thiserror::Error;

use super::{Cancel, Latency};
use crate::{
    camera::{Camera, CameraError, Frame},
    clock::monotonic_now,
    pipeline::PipelineError,
    projector_link::{ClockOffset, LinkError, ProjectorLink},
    scan::{ScanError, Shows},
};

/// Longest wait for one frame before the operator is told that the camera is silent.
pub(super) const FRAME_TIMEOUT: Duration = Duration::from_secs(5);

/// Why an action of the session ended early.
#[derive(Debug, Error)]
pub enum SessionError {
    /// The projector did not do as asked.
    #[error("projector: {0}")]
    Projector(#[from] LinkError),
    /// The camera gave no frame.
    #[error("camera: {0}")]
    Camera(#[from] CameraError),
    /// The recording can't be stored.
    #[error("scan folder: {0}")]
    Scan(#[from] ScanError),
    /// The captures can't be used.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// A grid that can't be shown.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// The camera's picture does not follow the projector's.
    #[error(
        "the camera does not see the projector: white and black frames differ by {percent:.1} % of full light on \
         average, or do not follow its changes; point the camera at the projected picture, switch off automatic exposure, \
         and check that the projector's mute and freeze are off"
    )]
    NotSeen {
        /// Mean difference between white and black frames, in percent of the brightest light.
        percent: f64,
    },
    /// Frames of a view are too much like others, or none came through whole.
    #[error(
        "no frame could be told to show {views}: the pictures of these views are too much alike for the camera, the \
         scene or its light changes by itself, or the camera loses too many frames; keep the scene still, switch off \
         flickering lamps, and look at the frames lost"
    )]
    NotTold {
        /// The views.
        views: String,
    },
    /// The projector did not show a sequence to its end.
    #[error(
        "the projector showed {shown} of {of} pictures of a sequence in time: somebody may have pressed a key there, \
         or its window is covered"
    )]
    SequenceBroken {
        /// Pictures that were shown.
        shown: usize,
        /// Pictures that were asked for.
        of: usize,
    },
    /// The operator stopped it.
    #[error("stopped by the operator; what was recorded so far is kept")]
    Cancelled,
}

/// Round trips that relate the clocks at first, and again before each sequence.
const FIRST_PINGS: u32 = 16;
const PINGS: u32 = 3;
/// Growth of the clock relation's error: what two quartz clocks may differ by, as a share of the time gone.
const CLOCK_DRIFT: f64 = 1e-4;

/// Sees every frame that an action takes, for a live picture.
pub type Tap = Box<dyn FnMut(&Frame) + Send>;

/// A projector and a camera, and the time that light takes from the one to the other.
pub struct Rig {
    /// The projector.
    pub projector: ProjectorLink,
    /// The camera.
    pub camera: Box<dyn Camera>,
    /// Display-to-capture latency, once measured.
    pub latency: Option<Latency>,
    /// Who sees the frames besides the action.
    pub tap: Option<Tap>,
    /// The projector's clock against ours, and when that was found.
    clock: Option<(ClockOffset, Duration)>,
}

impl Rig {
    /// A rig whose latency is not known yet.
    #[must_use]
    pub fn new(projector: ProjectorLink, camera: Box<dyn Camera>) -> Self {
        Self {
            projector,
            camera,
            latency: None,
            tap: None,
            clock: None,
        }
    }

    /// From frame to frame, in milliseconds.
    #[must_use]
    pub fn frame_ms(&self) -> f64 {
        1000.0 * self.camera.format().rate.interval().as_secs_f64()
    }

    /// The relation of the clocks: the best of what is known and of some new round trips.
    ///
    /// # Errors
    /// A projector that does not answer.
    pub fn clock_offset(&mut self) -> Result<ClockOffset, LinkError> {
        let pings = if self.clock.is_some() {
            PINGS
        } else {
            FIRST_PINGS
        };
        let new = self.projector.clock_offset(pings)?;
        let now = monotonic_now();
        let known = self.clock.filter(|(known, found_at)| {
            let age = now.saturating_sub(*found_at).mul_f64(CLOCK_DRIFT);
            known.uncertainty + age < new.uncertainty
        });
        let best = known.unwrap_or((new, now));
        self.clock = Some(best);
        Ok(best.0)
    }

    /// The relation of the clocks as it was found last.
    ///
    /// # Errors
    /// As [`Rig::clock_offset`], when it was never found.
    pub fn known_clock_offset(&mut self) -> Result<ClockOffset, LinkError> {
        match self.clock {
            Some((known, _)) => Ok(known),
            None => self.clock_offset(),
        }
    }

    /// The camera's newest frame, as [`Camera::next_frame`].
    ///
    /// # Errors
    /// A camera that gives no frame in time.
    pub fn next_frame(&mut self, timeout: Duration) -> Result<Frame, CameraError> {
        let frame = self.camera.next_frame(timeout)?;
        self.show_tap(&frame);
        Ok(frame)
    }

    fn show_tap(&mut self, frame: &Frame) {
        if let Some(tap) = &mut self.tap {
            tap(frame);
        }
    }

    /// Shows a view and gives `count` frames that were exposed wholly under it.
    ///
    /// # Errors
    /// A projector that does not answer, a camera that is silent, or [`SessionError::Cancelled`].
    pub fn shoot(
        &mut self,
        view: View,
        count: usize,
        stage: Stage,
        shows: Shows,
        cancel: &Cancel,
    ) -> Result<Vec<Frame>, SessionError> {
        self.camera.expect(shows, stage);
        let shown = self.projector.show(view)?.shown;
        let settled = match self.latency.as_ref().map(Latency::settled) {
            Some(settled) if self.camera.follows_projector() => {
                let shown_at = self.clock_offset()?.local_time(shown.presented_ns);
                // the camera adds a frame to be sure, the latency has it in already
                let frame = self.camera.format().rate.interval();
                (shown_at + settled).saturating_sub(frame)
            }
            _ => monotonic_now(),
        };
        let mut frames = Vec::with_capacity(count);
        while frames.len() < count {
            if cancel.is_cancelled() {
                return Err(SessionError::Cancelled);
            }
            let frame = self.camera.frame_after(settled, FRAME_TIMEOUT)?;
            self.show_tap(&frame);
            frames.push(frame);
        }
        Ok(frames)
    }
}
