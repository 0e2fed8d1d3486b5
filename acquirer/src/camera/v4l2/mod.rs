//! A webcam through V4L2: nokhwa's `Camera` over our own backend, drained by its own thread.
//!
//! Takes a device and wishes, gives frames. nokhwa's own V4L2 backend waits without a time-out,
//! drops the sequence number, the error mark and the length of a frame, and cannot open a camera
//! that stands at a fractional rate; ours gives all of these and is plugged in behind nokhwa's
//! interface. A camera that is unplugged is closed at once and found again by its name, under
//! whatever number it comes back.

mod backend;
mod capture;
mod controls;
mod list;
mod modes;

pub use controls::Held;
pub use list::{CameraInfo, FormatInfo, SizeInfo, list_cameras};

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use v4l::Control;

use super::latest::{Condition, Nothing};
use super::{Camera, CameraError, CameraSettings, CaptureFormat, Frame, Losses};
use capture::{Opened, Shared};

/// How long dropping a camera waits for its thread: an unplugged device may take its time to close.
const CLOSE_WITHIN: Duration = Duration::from_secs(2);

/// A V4L2 camera that is streaming.
pub struct V4l2Camera {
    opened: Opened,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    /// Disconnected when the thread has ended.
    ended: Receiver<()>,
    last_given: Option<u64>,
    /// Controls that were changed, with the values they had.
    controls_before: Vec<Control>,
}

impl V4l2Camera {
    /// Opens a device with the mode nearest to the wishes and starts to stream.
    ///
    /// # Errors
    /// When there is no such camera, it is in use, may not be opened, or offers nothing usable.
    pub fn open(path: &Path, settings: &CameraSettings) -> Result<Self, CameraError> {
        let shared = Arc::new(Shared::new());
        let (opened_sender, opened) = sync_channel(1);
        let (ended_sender, ended) = sync_channel(0);
        let failed = |reason: String| CameraError::Setup {
            path: path.into(),
            step: "starting the capture thread",
            reason,
        };
        // nokhwa's Camera must stay on the thread that made it.
        let name = path
            .file_name()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let thread = std::thread::Builder::new()
            .name(format!("camera {name}"))
            .spawn({
                let (path, settings, shared) =
                    (PathBuf::from(path), settings.clone(), Arc::clone(&shared));
                move || {
                    let _disconnects_at_the_end = ended_sender;
                    let run = || capture::run(&path, &settings, &shared, &opened_sender);
                    if catch_unwind(AssertUnwindSafe(run)).is_err() {
                        let reason = "the driver answered in an unknown way; unplug the camera and open it again";
                        shared.latest.set_condition(Condition::Ended(reason.into()));
                    }
                }
            })
            .map_err(|error| failed(error.to_string()))?;
        let opened = opened
            .recv()
            .map_err(|_| failed("it ended at once".into()))??;
        Ok(Self {
            opened,
            shared,
            thread: Some(thread),
            ended,
            last_given: None,
            controls_before: vec![],
        })
    }

    /// The camera's node now; it may have come back under another number.
    fn path(&self) -> PathBuf {
        self.shared
            .path()
            .unwrap_or_else(|| self.opened.info.path.clone())
    }
}

impl Camera for V4l2Camera {
    fn description(&self) -> String {
        let info = &self.opened.info;
        format!(
            "{} ({}, {}, {})",
            info.name,
            info.path.display(),
            info.driver,
            info.bus
        )
    }

    fn format(&self) -> CaptureFormat {
        self.opened.format
    }

    fn losses(&self) -> Losses {
        self.shared.losses()
    }

    fn hold_automatics(&mut self) -> Result<Vec<Held>, CameraError> {
        let (held, before) = controls::hold_automatics(&self.path())?;
        if self.controls_before.is_empty() {
            self.controls_before = before;
        }
        Ok(held)
    }

    fn next_frame(&mut self, timeout: Duration) -> Result<Frame, CameraError> {
        let deadline = Instant::now() + timeout;
        let name = || self.opened.info.name.clone();
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let raw = self
                .shared
                .latest
                .take(left)
                .map_err(|nothing| match nothing {
                    Nothing::InTime => CameraError::NoFrame {
                        name: name(),
                        waited: timeout,
                    },
                    Nothing::Unplugged => CameraError::Unplugged { name: name() },
                    Nothing::Ended(reason) => CameraError::Ended {
                        name: name(),
                        reason,
                    },
                })?;
            match raw.layout.decode(&raw.bytes) {
                Ok(picture) => {
                    let dropped = self
                        .last_given
                        .map_or(0, |last| raw.number.saturating_sub(last + 1));
                    self.last_given = Some(raw.number);
                    return Ok(Frame {
                        picture,
                        number: raw.number,
                        captured_at: raw.captured_at,
                        dropped,
                    });
                }
                Err(damage) => self.shared.count_damaged(raw.number, &damage),
            }
        }
    }
}

impl Drop for V4l2Camera {
    fn drop(&mut self) {
        let before = std::mem::take(&mut self.controls_before);
        if !before.is_empty()
            && let Err(error) = controls::restore(&self.path(), before)
        {
            tracing::debug!(%error, "the camera's automatics stay off");
        }
        self.shared.stop();
        // Nothing is ever sent: an end shows as a disconnection, a time-out as a driver that hangs.
        let hangs = matches!(
            self.ended.recv_timeout(CLOSE_WITHIN),
            Err(std::sync::mpsc::RecvTimeoutError::Timeout)
        );
        if hangs {
            tracing::warn!(camera = %self.opened.info.name, "the driver does not let go of the camera; leaving it behind");
        } else if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::warn!(camera = %self.opened.info.name, "the capture thread had died");
        }
    }
}
