//! The thread in which a V4L2 camera lives: opens it, drains it, and finds it again when it was
//! unplugged.
//!
//! Takes a device and wishes, leaves the latest raw frame in [`Shared`]. nokhwa's camera may not
//! move between threads and a blocked driver cannot be interrupted, so everything that touches the
//! device happens here, in steps that end within a fraction of a second; the reader never waits for
//! the device itself.

use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use nokhwa::utils::{ApiBackend, CameraIndex};

use super::backend::{Backend, Facts, Outcome};
use super::controls::ControlHandle;
use super::kept::KeptControls;
use super::list::{self, CameraInfo};
use super::modes;
use crate::camera::latest::{Condition, Latest};
use crate::camera::pixels::{Damage, Layout};
use crate::camera::{CameraError, CameraSettings, CaptureFormat, Losses};
use crate::clock::monotonic_now;

/// A camera that is silent for this long gets its stream started anew: USB cameras often need that
/// after a hiccup.
const STALL: Duration = Duration::from_secs(3);
/// Pause between two tries to start a failed stream, or to find a camera that is away.
const RETRY: Duration = Duration::from_millis(200);
/// Tries to start a failed stream before the device is closed and opened anew.
const RESTARTS: u32 = 5;
/// A greater jump of the driver's number is no loss but another way to count.
const GREATEST_GAP: u32 = 1000;

/// A frame as it came from the driver.
pub(super) struct RawFrame {
    pub(super) bytes: Vec<u8>,
    pub(super) layout: Layout,
    pub(super) number: u64,
    pub(super) captured_at: Duration,
}

/// What was opened.
#[derive(Clone, Debug)]
pub(super) struct Opened {
    pub(super) info: CameraInfo,
    pub(super) format: CaptureFormat,
}

/// What the capture thread and the reader share.
pub(super) struct Shared {
    pub(super) latest: Latest<RawFrame>,
    stop: AtomicBool,
    lost_by_driver: AtomicU64,
    damaged: AtomicU64,
    path: Mutex<Option<PathBuf>>,
    controls: Mutex<KeptControls>,
}

impl Shared {
    pub(super) fn new() -> Self {
        Self {
            latest: Latest::new(),
            stop: AtomicBool::new(false),
            lost_by_driver: AtomicU64::new(0),
            damaged: AtomicU64::new(0),
            path: Mutex::new(None),
            controls: Mutex::new(KeptControls::default()),
        }
    }

    pub(super) fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    pub(super) fn losses(&self) -> Losses {
        Losses {
            by_driver: self.lost_by_driver.load(Ordering::Relaxed),
            damaged: self.damaged.load(Ordering::Relaxed),
            overtaken: self.latest.overtaken(),
        }
    }

    /// The node of the camera now; it may come back under another number.
    pub(super) fn path(&self) -> Option<PathBuf> {
        self.path
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    fn set_path(&self, path: &Path) {
        *self.path.lock().unwrap_or_else(PoisonError::into_inner) = Some(path.into());
    }

    /// What was changed of the camera's controls.
    pub(super) fn controls(&self) -> MutexGuard<'_, KeptControls> {
        self.controls.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the controls of a camera that came back as they were.
    fn set_controls_again(&self, path: &Path) {
        let kept = self.controls();
        if kept.is_empty() {
            return;
        }
        match ControlHandle::open(path) {
            Ok(handle) => {
                let refused = kept.set_again(&handle);
                if refused > 0 {
                    tracing::warn!(
                        "{} refuses {refused} of the settings it had before it was unplugged",
                        path.display()
                    );
                }
            }
            Err(error) => tracing::warn!(%error, "the controls are not set again"),
        }
    }

    pub(super) fn count_damaged(&self, number: u64, damage: &Damage) {
        self.damaged.fetch_add(1, Ordering::Relaxed);
        tracing::debug!(number, %damage, "a frame is left out");
    }
}

/// The body of the capture thread: reports what it opened, then runs until it is stopped.
pub(super) fn run(
    path: &Path,
    settings: &CameraSettings,
    shared: &Shared,
    opened: &SyncSender<Result<Opened, CameraError>>,
) {
    let mut stream = match Stream::open(path, |camera| modes::choose(&camera.formats, settings)) {
        Ok(stream) => stream,
        Err(error) => return drop(opened.send(Err(error))), // a failed send means that nobody waits
    };
    let identity = stream.opened.clone();
    if opened.send(Ok(identity.clone())).is_err() {
        return;
    }
    shared.set_path(path);
    let mut numbering = Numbering::default();
    while stream.drain(shared, &mut numbering) == Ended::Away {
        let name = &identity.info.name;
        tracing::warn!(camera = %name, "the camera was unplugged or has failed; waiting for it to come back");
        drop(stream); // as long as it is open, a camera that comes back gets another number
        shared.latest.set_condition(Condition::Unplugged);
        let Some(found) = wait_for_return(&identity, shared) else {
            return;
        };
        tracing::info!(camera = %name, path = %found.opened.info.path.display(), "the camera is back");
        shared.set_path(&found.opened.info.path);
        shared.set_controls_again(&found.opened.info.path);
        shared.latest.set_condition(Condition::Running);
        stream = found;
    }
}

/// Looks for the camera by its name, in the same place first, until it can be opened in the same
/// mode.
fn wait_for_return(identity: &Opened, shared: &Shared) -> Option<Stream> {
    let mut last_problem = String::new();
    while !shared.stopped() {
        std::thread::sleep(RETRY);
        let mut here: Vec<_> = list::identities()
            .into_iter()
            .filter(|camera| camera.name == identity.info.name)
            .collect();
        here.sort_by_key(|camera| camera.bus != identity.info.bus);
        for camera in here {
            match Stream::open(&camera.path, |_| Some(identity.format)) {
                Ok(stream) => return Some(stream),
                Err(error) if error.to_string() != last_problem => {
                    last_problem = error.to_string();
                    tracing::warn!("{last_problem}");
                }
                Err(_) => {} // said before
            }
        }
    }
    None
}

/// Why draining a stream ended.
#[derive(Debug, PartialEq, Eq)]
enum Ended {
    /// The reader has gone.
    Stopped,
    /// The device has gone, or fails so that only opening it anew may help.
    Away,
}

/// A camera that streams.
struct Stream {
    camera: nokhwa::Camera,
    facts: Rc<Cell<Facts>>,
    layout: Layout,
    opened: Opened,
}

impl Stream {
    fn open(
        path: &Path,
        choose: impl FnOnce(&CameraInfo) -> Option<CaptureFormat>,
    ) -> Result<Self, CameraError> {
        let backend = Backend::open(path, choose)?;
        let (facts, layout) = (backend.facts(), backend.layout());
        let opened = Opened {
            info: backend.camera().clone(),
            format: backend.mode(),
        };
        let index = CameraIndex::String(path.display().to_string());
        let mut camera =
            nokhwa::Camera::with_custom(index, ApiBackend::Video4Linux, Box::new(backend));
        camera
            .open_stream()
            .map_err(|error| match facts.get().outcome {
                Outcome::Busy => CameraError::Busy { path: path.into() },
                _ => CameraError::Setup {
                    path: path.into(),
                    step: "starting the stream",
                    reason: error.to_string(),
                },
            })?;
        Ok(Self {
            camera,
            facts,
            layout,
            opened,
        })
    }

    /// Takes every frame that comes until the reader or the device has gone.
    fn drain(&mut self, shared: &Shared, numbering: &mut Numbering) -> Ended {
        let (mut last_frame, mut failures) = (Instant::now(), 0);
        numbering.restart();
        while !shared.stopped() {
            let frame = self.camera.frame();
            let facts = self.facts.get();
            match (frame, facts.outcome) {
                (Ok(buffer), _) => {
                    (last_frame, failures) = (Instant::now(), 0);
                    self.keep(buffer.buffer(), facts, shared, numbering);
                }
                (Err(error), Outcome::Damaged) => {
                    last_frame = Instant::now();
                    let number = numbering.count(facts.sequence, &shared.lost_by_driver);
                    shared.count_damaged(number, &Damage::Marked(error.to_string()));
                }
                (Err(_), Outcome::Gone) => return Ended::Away,
                (Err(_), Outcome::Nothing | Outcome::Good) if last_frame.elapsed() < STALL => {}
                (Err(error), _) => {
                    failures += 1;
                    if failures == 1 {
                        tracing::warn!(camera = %self.opened.info.name, %error, "no frames; starting the stream anew");
                    }
                    if failures > RESTARTS && facts.outcome == Outcome::Failed {
                        return Ended::Away;
                    }
                    last_frame = Instant::now();
                    numbering.restart();
                    if !self.restart() {
                        return Ended::Away;
                    }
                }
            }
        }
        Ended::Stopped
    }

    /// Checks and leaves a frame for the reader.
    fn keep(&self, bytes: &[u8], facts: Facts, shared: &Shared, numbering: &mut Numbering) {
        let number = numbering.count(facts.sequence, &shared.lost_by_driver);
        match self.layout.trim(bytes) {
            Ok(bytes) => {
                let now = monotonic_now();
                // A stamp from the future is the driver's plan, not a measurement.
                let captured_at = facts.stamp.filter(|stamp| *stamp <= now).unwrap_or(now);
                shared.latest.put(RawFrame {
                    bytes: bytes.to_vec(),
                    layout: self.layout,
                    number,
                    captured_at,
                });
            }
            Err(damage) => shared.count_damaged(number, &damage),
        }
    }

    /// Starts the stream anew; false when the device has gone.
    fn restart(&mut self) -> bool {
        std::thread::sleep(RETRY);
        let stopped = self.camera.stop_stream();
        let started = self.camera.open_stream();
        (stopped.is_ok() && started.is_ok()) || self.facts.get().outcome != Outcome::Gone
    }
}

/// Turns the driver's numbers, which begin anew with each stream, into one count over the camera's
/// life.
#[derive(Debug, Default)]
struct Numbering {
    next: u64,
    last_sequence: Option<u32>,
}

impl Numbering {
    fn restart(&mut self) {
        self.last_sequence = None;
    }

    /// The number of a frame; adds to `lost` what the driver skipped before it.
    fn count(&mut self, sequence: u32, lost: &AtomicU64) -> u64 {
        let step = self
            .last_sequence
            .map_or(1, |last| sequence.wrapping_sub(last));
        // Standing still, running backwards or jumping far is a driver that does not count frames.
        let skipped = if (1..GREATEST_GAP).contains(&step) {
            u64::from(step - 1)
        } else {
            0
        };
        self.last_sequence = Some(sequence);
        lost.fetch_add(skipped, Ordering::Relaxed);
        let number = self.next + skipped;
        self.next = number + 1;
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(sequences: &[u32]) -> (Vec<u64>, u64) {
        let (mut numbering, lost) = (Numbering::default(), AtomicU64::new(0));
        let numbers = sequences
            .iter()
            .map(|sequence| numbering.count(*sequence, &lost))
            .collect();
        (numbers, lost.into_inner())
    }

    #[test]
    fn a_gap_in_the_drivers_numbers_is_a_loss() {
        assert_eq!(numbers(&[7, 8, 12, 13]), (vec![0, 1, 5, 6], 3));
        assert_eq!(numbers(&[u32::MAX, 0, 2]), (vec![0, 1, 3], 1));
    }

    #[test]
    fn a_driver_that_does_not_count_loses_nothing() {
        assert_eq!(numbers(&[0, 0, 0]), (vec![0, 1, 2], 0));
        assert_eq!(numbers(&[88, 89, 88, 90_000]), (vec![0, 1, 2, 3], 0));
    }

    #[test]
    fn the_count_goes_on_over_a_new_start_of_the_stream() {
        let (mut numbering, lost) = (Numbering::default(), AtomicU64::new(0));
        assert_eq!(numbering.count(40, &lost), 0);
        numbering.restart();
        assert_eq!(numbering.count(0, &lost), 1);
        assert_eq!(lost.into_inner(), 0);
    }
}
