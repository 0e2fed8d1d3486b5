//! The rig: a projector at the end of a wire and a camera that looks at its light.

use std::time::Duration;

use shared::{pattern::PatternError, protocol::View, stage::Stage};
use thiserror::Error;

use super::{Cancel, Latency};
use crate::{
    camera::{Camera, CameraError, Frame},
    clock::monotonic_now,
    pipeline::PipelineError,
    projector_link::{LinkError, ProjectorLink},
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
        "the camera does not see the projector: white and black frames differ by {contrast:.1} grey levels on \
         average, or do not follow its changes; point the camera at the projected picture, switch off automatic exposure, \
         and check that the projector's mute and freeze are off"
    )]
    NotSeen {
        /// Mean difference between white and black frames in grey levels.
        contrast: f64,
    },
    /// The operator stopped it.
    #[error("stopped by the operator; what was recorded so far is kept")]
    Cancelled,
}

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
        self.projector.show(view)?;
        let settled = self
            .latency
            .as_ref()
            .map_or(Duration::ZERO, Latency::settled);
        let shown_at = monotonic_now() + settled;
        let mut frames = Vec::with_capacity(count);
        while frames.len() < count {
            if cancel.is_cancelled() {
                return Err(SessionError::Cancelled);
            }
            let frame = self.camera.frame_after(shown_at, FRAME_TIMEOUT)?;
            self.show_tap(&frame);
            frames.push(frame);
        }
        Ok(frames)
    }
}
