//! The simulated room as a camera: `--camera sim:SCENE`.
//!
//! Takes a scene and the address of a running projector, gives the frames that a webcam would take
//! of that room. It learns what is projected from the projector's own notices, over a watcher's
//! connection of its own, so the real protocol and the real programs are used; light follows a
//! notice after the scene's display latency, and frames come at the camera's rate whatever is asked
//! of it, torn or mixed where the picture changed during the exposure. Frames that a slow machine
//! cannot take in time count as overtaken. It has the usual controls of a webcam, and the scene's
//! `[faults]` are its own and the projector's.

mod controls;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use image::RgbImage;
use shared::protocol::{Role, Shown};
use shared::simulation::{Room, RoomCamera, Scene, Timeline};
use shared::stage::Stage;

use super::controls::ControlInfo;
use super::latest::{Condition, Latest, Nothing};
use super::scenes::load_scene;
use super::{Camera, CameraError, CaptureFormat, Frame, Losses, PixelFormat, Rate};
use crate::clock::monotonic_now;
use crate::projector_link::{LinkError, LinkSettings, Notice, ProjectorLink};
use crate::scan::Shows;
use controls::Controls;

/// Pause between two tries to reach a projector that has gone.
const RECONNECT: Duration = Duration::from_millis(500);
/// Pictures are remembered for this long after their light has gone: longer than any exposure.
const MEMORY: Duration = Duration::from_secs(2);

/// A picture on its way to the reader.
struct Taken {
    picture: RgbImage,
    number: u64,
    captured_at: Duration,
}

/// What the thread and the reader share.
struct Shared {
    latest: Latest<Taken>,
    stop: AtomicBool,
    /// Frames that the machine was too slow to take.
    skipped: AtomicU64,
    /// Frames that the scene's camera lost.
    lost: AtomicU64,
    room: Mutex<Arc<Room>>,
    controls: Mutex<Controls>,
}

impl Shared {
    fn room(&self) -> Arc<Room> {
        Arc::clone(&self.room.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn controls(&self) -> MutexGuard<'_, Controls> {
        self.controls.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set_room(&self, room: Arc<Room>) {
        *self.room.lock().unwrap_or_else(PoisonError::into_inner) = room;
    }
}

/// A camera in a simulated room.
pub struct SimulatedCamera {
    name: String,
    scene: Scene,
    stage: Stage,
    /// The rooms worked out so far.
    rooms: Vec<(Stage, Arc<Room>)>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    last_given: Option<u64>,
}

impl SimulatedCamera {
    /// Builds the room without the object and starts to take frames of it.
    ///
    /// # Errors
    /// When the scene cannot be read, or no projector answers at the address.
    pub fn open(scene_name: &str, projector: &str) -> Result<Self, CameraError> {
        let scene = load_scene(scene_name)?;
        let failed = |reason: String| CameraError::Simulation {
            scene: scene_name.to_owned(),
            reason,
        };
        let settings = LinkSettings::new(
            projector,
            &format!("simulated room {scene_name}"),
            Role::Watcher,
        );
        let link = ProjectorLink::connect(&settings).map_err(|error| failed(error.to_string()))?;
        let stage = Stage::Background;
        let room = Arc::new(Room::new(&scene, stage));
        let shared = Arc::new(Shared {
            latest: Latest::new(),
            stop: AtomicBool::new(false),
            skipped: AtomicU64::new(0),
            lost: AtomicU64::new(0),
            room: Mutex::new(Arc::clone(&room)),
            controls: Mutex::new(Controls::new(&scene)),
        });
        let thread = std::thread::Builder::new()
            .name("simulated camera".into())
            .spawn({
                let (shared, mut exposing) = (Arc::clone(&shared), Exposing::new(&scene, link));
                move || {
                    exposing.run(&shared);
                    shared
                        .latest
                        .set_condition(Condition::Ended("its thread has ended".into()));
                }
            })
            .map_err(|error| failed(error.to_string()))?;
        let name = format!("simulated room '{scene_name}'");
        let rooms = vec![(stage, room)];
        Ok(Self {
            name,
            scene,
            stage,
            rooms,
            shared,
            thread: Some(thread),
            last_given: None,
        })
    }

    /// Puts the object into the room, or takes it away; takes about a second the first time.
    ///
    /// Frames whose exposure begins after this returns show the new stage.
    pub fn set_stage(&mut self, stage: Stage) {
        if stage == self.stage {
            return;
        }
        let known = self
            .rooms
            .iter()
            .find(|(known, _)| *known == stage)
            .map(|(_, room)| Arc::clone(room));
        let room = known.unwrap_or_else(|| {
            let room = Arc::new(Room::new(&self.scene, stage));
            self.rooms.push((stage, Arc::clone(&room)));
            room
        });
        self.shared.set_room(room);
        self.stage = stage;
    }

    /// The scene, with its truth.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }
}

impl Camera for SimulatedCamera {
    fn description(&self) -> String {
        format!("{}: {}", self.name, self.scene.title())
    }

    fn format(&self) -> CaptureFormat {
        let (width, height) = self.scene.camera_size();
        CaptureFormat {
            width,
            height,
            rate: Rate::near(1.0 / self.scene.frame_period().as_secs_f64().max(1e-3)),
            pixels: PixelFormat::Rgb,
        }
    }

    fn losses(&self) -> Losses {
        let count = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Losses {
            by_driver: count(&self.shared.lost),
            damaged: 0,
            overtaken: self.shared.latest.overtaken() + count(&self.shared.skipped),
        }
    }

    fn next_frame(&mut self, timeout: Duration) -> Result<Frame, CameraError> {
        let name = || self.name.clone();
        let taken = self
            .shared
            .latest
            .take(timeout)
            .map_err(|nothing| match nothing {
                Nothing::Ended(reason) => CameraError::Ended {
                    name: name(),
                    reason,
                },
                Nothing::InTime | Nothing::Unplugged => CameraError::NoFrame {
                    name: name(),
                    waited: timeout,
                },
            })?;
        let dropped = self
            .last_given
            .map_or(0, |last| taken.number.saturating_sub(last + 1));
        self.last_given = Some(taken.number);
        Ok(Frame {
            picture: taken.picture,
            number: taken.number,
            captured_at: taken.captured_at,
            dropped,
        })
    }

    fn controls(&self) -> Result<Vec<ControlInfo>, CameraError> {
        if self.scene.has_no_controls() {
            return Ok(vec![]);
        }
        Ok(self.shared.controls().list())
    }

    fn set_control(&mut self, id: u32, value: i64) -> Result<i64, CameraError> {
        self.shared.controls().set(id, value)
    }

    fn expect(&mut self, _shows: Shows, stage: Stage) {
        self.set_stage(stage);
    }
}

impl Drop for SimulatedCamera {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::warn!("the thread of the simulated camera had died");
        }
    }
}

/// The thread's own state: what was projected when, and the camera's clockwork.
struct Exposing {
    link: ProjectorLink,
    timeline: Timeline,
    period: Duration,
    readout: Duration,
    scene: Scene,
    /// When to try to reach a lost projector again.
    reconnect_at: Option<Duration>,
}

impl Exposing {
    fn new(scene: &Scene, link: ProjectorLink) -> Self {
        let mut exposing = Self {
            timeline: Timeline::new(scene),
            period: scene.delivered_period(),
            readout: scene.readout(),
            scene: scene.clone(),
            reconnect_at: None,
            link,
        };
        // What the projector shows already has been lit for long.
        let shown = exposing.link.first_state().shown.clone();
        exposing.project(&shown, Duration::ZERO);
        exposing
    }

    fn project(&mut self, shown: &Shown, at: Duration) {
        self.timeline.show(at, &shown.pattern.raster(shown.raster));
    }

    /// Takes frame after frame at the camera's rate until the reader has gone.
    fn run(&mut self, shared: &Shared) {
        let begin = monotonic_now();
        let mut camera = RoomCamera::new(shared.room());
        let mut number = 0_u64;
        while !shared.stop.load(Ordering::Relaxed) {
            let start = begin + self.period.mul_f64(number as f64);
            let tuning = shared.controls().tuning();
            self.follow_projector_until(start + tuning.exposure + self.readout);
            camera.look_at(&shared.room());
            let picture = camera.take(&self.timeline, start, number, &tuning);
            shared.controls().see(&picture);
            // As with a webcam, the stamp is the begin of the read-out: the end of the first row's
            // exposure.
            let captured_at = start + tuning.exposure.min(self.period);
            if self.scene.loses(number) {
                shared.lost.fetch_add(1, Ordering::Relaxed);
            } else {
                shared.latest.put(Taken {
                    picture,
                    number,
                    captured_at,
                });
            }
            self.timeline.forget_before(start.saturating_sub(MEMORY));
            let due = (monotonic_now().saturating_sub(begin).as_secs_f64()
                / self.period.as_secs_f64()) as u64;
            let next = due.max(number + 1);
            let lost = (number + 1..next).filter(|&k| self.scene.loses(k)).count() as u64;
            shared.lost.fetch_add(lost, Ordering::Relaxed);
            let skipped = next - number - 1 - lost;
            shared.skipped.fetch_add(skipped, Ordering::Relaxed);
            number = next;
        }
    }

    /// Notes what the projector shows, up to a moment. A projector that has gone leaves its last
    /// picture on the wall.
    fn follow_projector_until(&mut self, moment: Duration) {
        loop {
            let left = moment.saturating_sub(monotonic_now());
            match self.link.next_notice(left) {
                Ok(Some(Notice::Shown { shown, received_at })) => self.project(&shown, received_at),
                Ok(Some(_)) => {}
                Ok(None) => return,
                Err(error) => {
                    self.reconnect(&error);
                    std::thread::sleep(moment.saturating_sub(monotonic_now()).min(self.period));
                    if self.reconnect_at.is_some() && monotonic_now() >= moment {
                        return;
                    }
                }
            }
        }
    }

    /// Tries to reach the projector again, now and then.
    fn reconnect(&mut self, error: &LinkError) {
        let now = monotonic_now();
        match self.reconnect_at {
            None => {
                tracing::warn!("simulated room: {error}; its last picture stays on the wall");
                self.reconnect_at = Some(now + RECONNECT);
            }
            Some(due) if now >= due => {
                if self.link.reconnect().is_ok() {
                    self.reconnect_at = None;
                    let shown = self.link.first_state().shown.clone();
                    self.project(&shown, monotonic_now());
                } else {
                    self.reconnect_at = Some(now + RECONNECT);
                }
            }
            Some(_) => {}
        }
    }
}

#[cfg(test)]
mod tests;
