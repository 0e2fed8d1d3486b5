//! The thread that owns the rig: it shows live frames, reads them if that is wanted, and does one job at a time.

mod controls;
mod files;
mod jobs;
mod live;

use std::{
    collections::VecDeque,
    path::PathBuf,
    sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError},
    time::Duration,
};

use shared::{geometry::RigCalibration, protocol::ProjectorState};

use super::{
    events::{Event, Job, RigInfo, Who},
    live_picture::LivePlace,
    sources::Source,
    waker::Waker,
};
use crate::{
    camera::{CameraSpec, load_scene},
    cli::RigArgs,
    config::Config,
    pipeline::colour_choice::ColourSelection,
    projector_link::Notice,
    scan::ScanFolder,
    session::{Cancel, LiveMode, Rig},
};
use controls::ControlsSet;
pub(super) use files::FileWorker;
use live::LiveTap;

/// Wait between two tries to reach the rig.
const RETRY: Duration = Duration::from_secs(2);
/// Longest wait for a live frame before the jobs are looked at.
const LIVE_TIMEOUT: Duration = Duration::from_millis(200);
/// Frames that can be silent before the rig is opened anew: about five seconds.
const SILENT_FRAMES: u32 = 25;

/// How a thread tells the window something.
#[derive(Debug, Clone)]
pub(super) struct Teller {
    /// To the window.
    pub(super) events: SyncSender<Event>,
    /// Of the window.
    pub(super) waker: Waker,
}

impl Teller {
    /// Hands an event over; the window takes them at every repaint. A window that is gone needs none.
    pub(super) fn tell(&self, event: Event) {
        if self.events.send(event).is_ok() {
            self.waker.wake();
        }
    }
}

/// Opens the rig that the operator has chosen.
pub(super) type OpenRig = Box<dyn Fn(&RigArgs, &Config) -> anyhow::Result<Rig> + Send>;

/// Everything the rig's thread needs.
pub(super) struct RigWorker {
    /// How the rig is opened.
    pub(super) open: OpenRig,
    /// Which projector.
    pub(super) rig: RigArgs,
    /// Which camera, and what is asked of it.
    pub(super) source: Source,
    pub(super) config: Config,
    /// Folder of the first scan; further ones get a number.
    pub(super) out: PathBuf,
    pub(super) calibration: Option<RigCalibration>,
    /// How frames are read when there is nothing else to do, if they are.
    pub(super) read_live: Option<LiveMode>,
    pub(super) cancel: Cancel,
    pub(super) jobs: Receiver<Job>,
    pub(super) live: LivePlace,
    pub(super) teller: Teller,
}

/// What the thread remembers between jobs.
#[derive(Default)]
struct Session {
    folder: Option<ScanFolder>,
    selection: Option<ColourSelection>,
    queue: VecDeque<Job>,
    controls: ControlsSet,
    /// Another source was asked for.
    reopen: bool,
}

/// Why the rig is left.
enum Left {
    /// The window is gone.
    Ended,
    /// Another camera is wanted.
    Reopen,
}

impl RigWorker {
    /// Runs until the window is gone.
    pub(super) fn run(mut self) {
        let mut session = Session::default();
        loop {
            let args = RigArgs {
                camera: self.source.camera.clone(),
                ..self.rig.clone()
            };
            self.config.camera = self.source.settings.clone();
            let mut rig = match (self.open)(&args, &self.config) {
                Ok(rig) => rig,
                Err(error) => {
                    self.teller.tell(Event::Disconnected(format!("{error:#}")));
                    match self.jobs.recv_timeout(RETRY) {
                        Err(RecvTimeoutError::Disconnected) => return,
                        _ if self.cancel.is_quitting() => return,
                        Ok(Job::Open(source)) => self.source = source,
                        Ok(Job::ReadLive(mode)) => self.read_live = mode,
                        Ok(_) => self.teller.tell(Event::Idle(Who::Rig)),
                        Err(RecvTimeoutError::Timeout) => {}
                    }
                    continue;
                }
            };
            match self.serve(&mut rig, &mut session) {
                Ok(Left::Ended) => return,
                Ok(Left::Reopen) => session.reopen = false,
                Err(error) => self.teller.tell(Event::Disconnected(format!("{error:#}"))),
            }
        }
    }

    /// Live frames and jobs until the window or the rig is gone.
    fn serve(&mut self, rig: &mut Rig, session: &mut Session) -> anyhow::Result<Left> {
        self.tell_connected(rig)?;
        self.begin_controls(rig, session);
        let tap = LiveTap::new(self.live.clone(), self.teller.waker.clone());
        let mut silent = 0;
        loop {
            if self.cancel.is_quitting() || !self.take_jobs(session) {
                return Ok(Left::Ended);
            }
            rig.tap = Some(tap.clone().for_frames());
            if let Some(job) = session.queue.pop_front() {
                self.do_job(&job, rig, session);
            }
            if session.reopen {
                return Ok(Left::Reopen);
            }
            if session.queue.is_empty() && self.read_live.is_some() {
                rig.tap = None;
                self.read_frames(rig, session, &tap);
                continue;
            }
            self.hear_projector(rig)?;
            self.watch_controls(rig, session);
            match rig.next_frame(LIVE_TIMEOUT) {
                Ok(_) => silent = 0,
                Err(error) => {
                    silent += 1;
                    if silent > SILENT_FRAMES {
                        return Err(error.into());
                    }
                }
            }
        }
    }

    /// Takes what was asked for; `false` when the window is gone.
    fn take_jobs(&mut self, session: &mut Session) -> bool {
        loop {
            match self.jobs.try_recv() {
                Ok(Job::ReadLive(mode)) => {
                    self.read_live = mode;
                    if session.queue.is_empty() {
                        self.teller.tell(Event::Idle(Who::Rig));
                    }
                }
                Ok(Job::Open(source)) => {
                    self.source = source;
                    session.reopen = true;
                }
                Ok(job) => session.queue.push_back(job),
                Err(TryRecvError::Disconnected) => return false,
                Err(TryRecvError::Empty) => return true,
            }
        }
    }

    fn do_job(&self, job: &Job, rig: &mut Rig, session: &mut Session) {
        self.cancel.reset();
        if let Err(error) = self.job(job, rig, session) {
            session.queue.clear();
            self.teller.tell(Event::Failed(format!("{error:#}")));
        }
        if let Ok(state) = rig.projector.state() {
            self.teller.tell(Event::Projector(Box::new(state)));
        }
        if session.queue.is_empty() {
            self.teller.tell(Event::Idle(Who::Rig));
        }
    }

    /// The calibration of what is recorded now: a simulated room has its own, for all else the one that was given.
    fn calibration(&self) -> Option<RigCalibration> {
        let own = match &self.source.camera {
            Some(CameraSpec::Simulated(room)) => load_scene(room).ok(),
            _ => None,
        };
        own.map(|scene| scene.calibration()).or(self.calibration)
    }

    fn tell_connected(&self, rig: &Rig) -> anyhow::Result<()> {
        let format = rig.camera.format();
        self.teller.tell(Event::Connected(Box::new(RigInfo {
            camera: rig.camera.description(),
            source: self.source.clone(),
            format: format.to_string(),
            size: [format.width, format.height],
            projector: rig.projector.state()?,
        })));
        Ok(())
    }

    /// Passes on what the projector tells unasked.
    fn hear_projector(&self, rig: &Rig) -> anyhow::Result<()> {
        let mut newest: Option<Box<ProjectorState>> = None;
        while let Some(notice) = rig.projector.next_notice(Duration::ZERO)? {
            if let Notice::StateChanged(state) = notice {
                newest = Some(state);
            }
        }
        if let Some(state) = newest {
            self.teller.tell(Event::Projector(state));
        }
        Ok(())
    }
}
