//! Where pictures come from: a webcam, a recording, or the simulated room, all behind one
//! [`Camera`].
//!
//! Takes a [`CameraSpec`] and [`CameraSettings`], gives [`Frame`]s of sRGB bytes with a number and
//! a time. Every source that runs by itself is drained by its own thread into a place for one
//! frame: the latest frame wins, and each frame that nobody saw is counted. What the pixels mean is
//! the pipeline's business, not the camera's.
//!
//! # Conventions
//! Times are [`crate::clock::monotonic_now`]'s. A picture is row-major, its origin at the upper
//! left.

mod error;
mod frame;
mod jpeg;
mod latest;
mod pixels;
mod replay;
mod scenes;
mod settings;
mod simulated;
mod spec;
pub mod v4l2;

pub use error::CameraError;
pub use frame::{CaptureFormat, Frame, Losses, PixelFormat, Rate};
pub use replay::ReplayCamera;
pub use scenes::{load_scene, scene_file, scenes};
pub use settings::CameraSettings;
pub use simulated::SimulatedCamera;
pub use spec::CameraSpec;
pub use v4l2::Held;

use std::time::{Duration, Instant};

use shared::stage::Stage;

use crate::scan::Shows;

/// A source of frames.
pub trait Camera: Send {
    /// What the operator should read: name, driver and place of the source, in one line.
    fn description(&self) -> String;

    /// Size, rate and pixel format of the frames.
    fn format(&self) -> CaptureFormat;

    /// How many frames were lost since the source was opened, and where.
    fn losses(&self) -> Losses;

    /// The newest frame that was not given before; waits for one up to `timeout`.
    ///
    /// # Errors
    /// [`CameraError::NoFrame`] when none came in time, [`CameraError::Unplugged`] when the device
    /// has gone (it is looked for in the background; asking again is right), others when the source
    /// has ended.
    fn next_frame(&mut self, timeout: Duration) -> Result<Frame, CameraError>;

    /// The first frame whose exposure began after `instant` (on [`crate::clock::monotonic_now`]'s
    /// scale).
    ///
    /// A frame's stamp is never earlier than the begin of its exposure, and an exposure is never
    /// longer than one frame interval; so a frame qualifies when its stamp is at least one interval
    /// after `instant`.
    ///
    /// # Errors
    /// As [`Camera::next_frame`].
    fn frame_after(&mut self, instant: Duration, timeout: Duration) -> Result<Frame, CameraError> {
        let earliest_stamp = instant + self.format().rate.interval();
        let deadline = Instant::now() + timeout;
        loop {
            let frame = self.next_frame(deadline.saturating_duration_since(Instant::now()))?;
            if frame.captured_at >= earliest_stamp {
                return Ok(frame);
            }
        }
    }

    /// Holds exposure, gain, white balance and focus where the camera's automatics left them, so that
    /// the same light gives the same bytes in every capture; gives the controls there are. They are
    /// switched on again when the camera is closed; a camera that was unplugged has them on again too.
    ///
    /// # Errors
    /// When the device cannot be opened a second time.
    fn hold_automatics(&mut self) -> Result<Vec<Held>, CameraError> {
        Ok(vec![])
    }

    /// Whether the frames show what the projector shows at the time: a recording's do not.
    fn follows_projector(&self) -> bool {
        true
    }

    /// Tells the source what is about to be seen.
    ///
    /// A recording answers with the captures of that kind, and the simulated room places the object
    /// for [`Stage::Object`]. At a real rig a person does that, and nothing happens here.
    fn expect(&mut self, _shows: Shows, _stage: Stage) {}

    /// Whether the source is known to have this kind of picture: a recording has only what was recorded.
    fn has(&self, _shows: Shows, _stage: Stage) -> bool {
        true
    }
}

/// Opens a source of frames.
///
/// `projector` is the projector's `HOST:PORT`; the simulated room needs it to learn what is on its
/// wall.
///
/// # Errors
/// When there is no such source or it cannot be used; the message says what there is instead.
pub fn open_camera(
    spec: &CameraSpec,
    settings: &CameraSettings,
    projector: Option<&str>,
) -> Result<Box<dyn Camera>, CameraError> {
    match spec {
        CameraSpec::Device(path) => Ok(Box::new(v4l2::V4l2Camera::open(path, settings)?)),
        CameraSpec::Replay(folder) => Ok(Box::new(ReplayCamera::open(folder)?)),
        CameraSpec::Simulated(scene) => {
            let Some(projector) = projector else {
                let reason = "it needs a running projector: give --projector HOST:PORT".into();
                return Err(CameraError::Simulation {
                    scene: scene.clone(),
                    reason,
                });
            };
            Ok(Box::new(SimulatedCamera::open(scene, projector)?))
        }
    }
}
