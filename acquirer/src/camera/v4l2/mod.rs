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
mod kept;
mod list;
mod modes;

pub use controls::list_controls;
pub use list::{CameraInfo, FormatInfo, SizeInfo, list_cameras};

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::latest::{Condition, Nothing};
use super::{
    Camera, CameraError, CameraSettings, CaptureFormat, ControlInfo, Frame, Losses, find_control,
};
use capture::{Opened, Shared};
use controls::ControlHandle;

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
        })
    }

    /// The camera's node now; it may have come back under another number.
    fn path(&self) -> PathBuf {
        self.shared
            .path()
            .unwrap_or_else(|| self.opened.info.path.clone())
    }
}

impl V4l2Camera {
    /// An error of the control handle; while the camera is away that is the reason.
    fn or_unplugged(&self, error: CameraError) -> CameraError {
        if self.shared.latest.condition() == Condition::Unplugged {
            let name = self.opened.info.name.clone();
            CameraError::Unplugged { name }
        } else {
            error
        }
    }

    /// Why a control could not be set.
    fn control_error(&self, id: u32, error: &io::Error) -> CameraError {
        let controls = match self.controls() {
            Ok(controls) => controls,
            Err(error) => return error,
        };
        match find_control(&controls, &format!("{id:#010x}")) {
            Ok(control) => CameraError::ControlRefused {
                control: control.key.clone(),
                reason: if control.inactive {
                    "an automatic has it in hand; switch that off first".into()
                } else {
                    error.to_string()
                },
            },
            Err(none) => none,
        }
    }

    /// Gives the controls the values they had.
    fn restore_controls(&self) {
        let mut kept = self.shared.controls();
        if kept.is_empty() {
            return;
        }
        let camera = &self.opened.info.name;
        match ControlHandle::open(&self.path()) {
            Ok(handle) => {
                for (id, error) in kept.restore(&handle) {
                    tracing::warn!(%camera, %error, "control {id:#010x} does not get its old value back");
                }
            }
            Err(error) => {
                tracing::warn!(%camera, %error, "the camera's controls do not get their old values back");
            }
        }
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

    fn controls(&self) -> Result<Vec<ControlInfo>, CameraError> {
        let path = self.path();
        controls::list_controls(&path).map_err(|error| self.or_unplugged(error))
    }

    fn set_control(&mut self, id: u32, value: i64) -> Result<i64, CameraError> {
        let handle = ControlHandle::open(&self.path()).map_err(|error| self.or_unplugged(error))?;
        let outcome = self.shared.controls().set(&handle, id, value);
        outcome.map_err(|error| self.control_error(id, &error))
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
        self.restore_controls();
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
