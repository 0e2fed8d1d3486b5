//! The thread that owns the rig: it shows live frames, and does one job at a time.

use std::{
    collections::VecDeque,
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex, PoisonError,
        mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError},
    },
    time::{Duration, Instant},
};

use eframe::egui;
use image::RgbImage;
use shared::{pattern::Palette, stage::Stage};

use super::{
    Startup,
    events::{Event, Job, LiveFrame, ReadScan, RigInfo},
};
use crate::{
    cli::open_rig,
    pipeline::colour_choice::ColourSelection,
    process::process_scan,
    scan::{ScanFolder, fresh_folder, read_picture},
    session::{
        Cancel, NewScan, Rig, Tap, apply_selection, measure_latency, projected, record_stage,
        recording_warnings, try_colours,
    },
};

/// Wait between two tries to reach the rig.
const RETRY: Duration = Duration::from_secs(2);
/// Longest wait for a live frame before the jobs are looked at.
const LIVE_TIMEOUT: Duration = Duration::from_millis(200);
/// Frames that can be silent before the rig is opened anew: about five seconds.
const SILENT_FRAMES: u32 = 25;

/// A place for the newest frame.
pub(super) type LiveSlot = Arc<Mutex<Option<LiveFrame>>>;

/// Everything the worker needs.
pub(super) struct Worker {
    pub(super) startup: Startup,
    pub(super) cancel: Cancel,
    pub(super) jobs: Receiver<Job>,
    pub(super) events: SyncSender<Event>,
    pub(super) live: LiveSlot,
    pub(super) repaint: egui::Context,
}

/// What the worker remembers between jobs.
#[derive(Default)]
struct Session {
    folder: Option<ScanFolder>,
    selection: Option<ColourSelection>,
}

impl Worker {
    /// Runs until the window is gone.
    pub(super) fn run(self) {
        let mut session = Session::default();
        let mut queue: VecDeque<Job> = VecDeque::new();
        if self.startup.run_all {
            queue.extend([
                Job::PickColours,
                Job::Record(Stage::Background),
                Job::Record(Stage::Object),
                Job::Read,
            ]);
        }
        loop {
            let mut rig = match open_rig(&self.startup.rig, &self.startup.config) {
                Ok(rig) => rig,
                Err(error) => {
                    self.tell(Event::Disconnected(format!("{error:#}")));
                    match self.jobs.recv_timeout(RETRY) {
                        Err(RecvTimeoutError::Disconnected) => return,
                        _ if self.cancel.is_quitting() => return,
                        _ => continue,
                    }
                }
            };
            match self.serve(&mut rig, &mut session, &mut queue) {
                Ok(()) => return,
                Err(error) => self.tell(Event::Disconnected(format!("{error:#}"))),
            }
        }
    }

    /// Live frames and jobs until the window is gone (`Ok`) or the rig is (`Err`).
    fn serve(
        &self,
        rig: &mut Rig,
        session: &mut Session,
        queue: &mut VecDeque<Job>,
    ) -> anyhow::Result<()> {
        let projector = rig.projector.state()?;
        let camera = rig.camera.description();
        self.tell(Event::Connected(Box::new(RigInfo { camera, projector })));
        rig.tap = Some(self.live_tap());
        let mut silent = 0;
        while !self.cancel.is_quitting() {
            match self.jobs.try_recv() {
                Ok(job) => queue.push_back(job),
                Err(TryRecvError::Disconnected) => return Ok(()),
                Err(TryRecvError::Empty) => {}
            }
            if let Some(job) = queue.pop_front() {
                self.cancel.reset();
                if let Err(error) = self.job(job, rig, session) {
                    queue.clear();
                    self.tell(Event::Failed(format!("{error:#}")));
                }
                if queue.is_empty() {
                    self.tell(Event::Idle);
                }
            }
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
        Ok(())
    }

    fn job(&self, job: Job, rig: &mut Rig, session: &mut Session) -> anyhow::Result<()> {
        let config = &self.startup.config;
        if rig.latency.is_none() && !matches!(job, Job::Read | Job::NewScan) {
            let mut report = |p| self.tell(Event::Progress(p));
            let latency = measure_latency(rig, &config.latency, &self.cancel, &mut report)?;
            self.tell(Event::Latency(latency));
        }
        match job {
            Job::PickColours => self.pick_colours(rig, session),
            Job::Record(stage) => self.record(stage, rig, session),
            Job::Read => self.read(session),
            Job::NewScan => {
                session.folder = None;
                self.tell(Event::NewScan);
                Ok(())
            }
        }
    }

    fn pick_colours(&self, rig: &mut Rig, session: &mut Session) -> anyhow::Result<()> {
        let now = projected(rig)?;
        let current = now.pattern.coded.colours().try_into().ok();
        let mut report = |p| self.tell(Event::Progress(p));
        let palette = Palette::default();
        let result = try_colours(rig, &palette, &now, current, &self.cancel, &mut report)?;
        apply_selection(rig, &result.selection)?;
        session.selection = Some(result.selection.clone());
        // captures in other colours do not belong to this scan any more
        session.folder = None;
        self.tell(Event::Colours(Box::new(result.selection)));
        Ok(())
    }

    fn record(&self, stage: Stage, rig: &mut Rig, session: &mut Session) -> anyhow::Result<()> {
        if session.folder.is_none() {
            session.folder = Some(self.new_folder(rig, session.selection.as_ref())?);
        }
        let Some(folder) = session.folder.as_mut() else {
            return Ok(());
        };
        let mut report = |p| self.tell(Event::Progress(p));
        record_stage(
            rig,
            folder,
            stage,
            &self.startup.config.record,
            &self.cancel,
            &mut report,
        )?;
        self.tell(Event::Recorded(stage, folder.dir().to_owned()));
        Ok(())
    }

    fn new_folder(
        &self,
        rig: &Rig,
        selection: Option<&ColourSelection>,
    ) -> anyhow::Result<ScanFolder> {
        let record = &self.startup.config.record;
        for warning in recording_warnings(rig, &projected(rig)?, record)? {
            tracing::warn!("{warning}");
        }
        let scan = NewScan {
            dir: &fresh_folder(&self.startup.out),
            config: &self.startup.config,
            selection,
            calibration: self.startup.calibration.as_ref(),
        };
        Ok(scan.begin(rig)?)
    }

    fn read(&self, session: &Session) -> anyhow::Result<()> {
        let Some(folder) = &session.folder else {
            anyhow::bail!("nothing is recorded yet: record without and with the object first");
        };
        let processed = process_scan(folder, &self.startup.config)?;
        let figures = crate::cli::figures_text(folder, &processed);
        let read = ReadScan {
            figures: figures.lines().map(str::to_owned).collect(),
            pictures: result_pictures(&processed.paths.pictures),
            report: processed.paths.report,
        };
        self.tell(Event::Read(Box::new(read)));
        Ok(())
    }

    /// Hands an event over; the window takes them at every repaint. A window that is gone needs none.
    fn tell(&self, event: Event) {
        if self.events.send(event).is_ok() {
            self.repaint.request_repaint();
        }
    }

    /// Puts every frame that is taken, in a job or between jobs, where the window finds it.
    fn live_tap(&self) -> Tap {
        let (live, repaint) = (self.live.clone(), self.repaint.clone());
        let (mut stamps, mut lost) = (VecDeque::new(), 0);
        Box::new(move |frame| {
            lost += frame.dropped;
            let shown = LiveFrame {
                picture: frame.picture.clone(),
                number: frame.number,
                rate_hz: rate(&mut stamps),
                lost,
            };
            *live.lock().unwrap_or_else(PoisonError::into_inner) = Some(shown);
            repaint.request_repaint();
        })
    }
}

/// Frames per second over the last second.
fn rate(stamps: &mut VecDeque<Instant>) -> f64 {
    let now = Instant::now();
    stamps.push_back(now);
    while stamps
        .front()
        .is_some_and(|&t| now - t > Duration::from_secs(1))
    {
        stamps.pop_front();
    }
    let span = stamps.front().map_or(0.0, |&t| (now - t).as_secs_f64());
    if span > 0.0 {
        (stamps.len() - 1) as f64 / span
    } else {
        0.0
    }
}

/// The pictures in a results folder with their names, in the order of their names.
fn result_pictures(dir: &Path) -> Vec<(String, RgbImage)> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(dir)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "png"));
    paths.sort();
    let named = |path: &PathBuf| {
        let name = path.file_stem()?.to_string_lossy().replace('-', " ");
        Some((name, read_picture(path).ok()?))
    };
    paths.iter().filter_map(named).collect()
}
