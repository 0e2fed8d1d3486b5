//! Reads frame after frame while a pattern stays up.
//!
//! Takes a rig and a mode, gives one [`LiveFrame`] per frame: what it shows, how many crossings were read, why others
//! were not, and how long that took. Black and white are recorded first; a pattern that somebody at the projector puts
//! up instead is told and not read.

mod labels;

mod watch;

use std::{
    collections::{BTreeMap, VecDeque},
    ops::ControlFlow,
    time::{Duration, Instant},
};

use image::RgbImage;
use serde::{Deserialize, Serialize};
use shared::{geometry::RigCalibration, protocol::View, stage::Stage};

use super::{Cancel, RecordSettings, Rig, SessionError, Shot, rig::FRAME_TIMEOUT, tagging::Look};
use crate::{
    camera::Frame,
    pipeline::{PipelineSettings, Projected, Reader, grid::DecodedGrid},
    scan::Shows,
};
pub use labels::CarriedLabel;
use labels::CarriedLabels;
use watch::Watch;

/// The stage that a simulated room or a recording answers with: the object is in the scene.
const STAGE: Stage = Stage::Object;

/// How frames are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LiveMode {
    /// Nothing moves: the newest coded frames are averaged, the unary grid gives the geometry.
    Static,
    /// Things move: the coded grid stays up and every frame is read by itself.
    Dynamic,
    /// Things move slowly: the unary grid stays up, crossings keep their labels from frame to frame, and the coded grid
    /// is shown now and then to label them anew.
    Tracking,
}

/// What to read live.
#[derive(Debug, Clone)]
pub struct LiveSettings {
    /// How frames are read.
    pub mode: LiveMode,
    /// Frames that are averaged in [`LiveMode::Static`], 1 to 100.
    pub average: usize,
    /// Frames between two looks at the coded grid in [`LiveMode::Tracking`], 1 or more.
    pub refresh: usize,
    /// Time between two checks of the latency; `None` for never.
    pub check_latency_every: Option<Duration>,
    /// Repeats of black and white.
    pub record: RecordSettings,
    /// How captures are read.
    pub pipeline: PipelineSettings,
}

/// What a frame gave.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LiveFrame {
    /// The camera's number of the frame.
    pub frame: u64,
    /// Its stamp on the computer's monotonic clock, in seconds.
    pub time_s: f64,
    /// What it shows: `coded`, `unary`, `black`, `white`, `other`, or `mixed`.
    pub pattern: &'static str,
    /// Crossings with a label.
    pub crossings: usize,
    /// How many crossings have none, by reason.
    pub reasons: BTreeMap<&'static str, usize>,
    /// Time that reading took, in milliseconds.
    pub ms: f64,
}

/// A frame that was taken, for those who want more than figures.
pub struct LiveView<'a> {
    /// What it gave.
    pub told: &'a LiveFrame,
    /// The frame itself; not there when the labels were refreshed in between.
    pub frame: Option<&'a Frame>,
    /// What it was read with, and the grid that was read last.
    pub reader: &'a Reader,
    /// The labels that were carried on to this frame in [`LiveMode::Tracking`].
    pub labels: &'a [CarriedLabel],
    /// Somebody at the projector has changed its settings: what is read now may be another grid.
    pub settings_changed: bool,
}

/// What is told of each frame; a break ends the reading.
pub type OnFrame<'a> = &'a mut dyn FnMut(&LiveView<'_>) -> ControlFlow<()>;

/// Records the references, then reads until `on_frame` breaks or the operator stops it, which is no error here.
///
/// # Errors
/// As [`Rig::shoot_all`], and frames that cannot be read.
pub fn read_live(
    rig: &mut Rig,
    (projected, calibration): (&Projected, Option<&RigCalibration>),
    settings: &LiveSettings,
    cancel: &Cancel,
    on_frame: OnFrame,
) -> Result<(), SessionError> {
    let read = Live::begin(rig, (projected, calibration), settings, cancel)
        .and_then(|mut live| live.run(on_frame));
    match read {
        Err(SessionError::Cancelled) => Ok(()),
        read => read,
    }
}

struct Live<'a> {
    rig: &'a mut Rig,
    cancel: &'a Cancel,
    settings: &'a LiveSettings,
    reader: Reader,
    watch: Watch,
    /// The unary grid of [`LiveMode::Static`].
    unary: Vec<RgbImage>,
    newest: VecDeque<RgbImage>,
    labels: CarriedLabels,
}

impl<'a> Live<'a> {
    fn begin(
        rig: &'a mut Rig,
        (projected, calibration): (&Projected, Option<&RigCalibration>),
        settings: &'a LiveSettings,
        cancel: &'a Cancel,
    ) -> Result<Self, SessionError> {
        let RecordSettings {
            references, grids, ..
        } = settings.record;
        let last = match settings.mode {
            LiveMode::Static | LiveMode::Dynamic => [Shows::Unary, Shows::Prmvs],
            LiveMode::Tracking => [Shows::Prmvs, Shows::Unary],
        };
        let shots: Vec<Shot> = [Shows::Black, Shows::White]
            .map(|shows| shot(shows, references.max(2)))
            .into_iter()
            .chain(last.map(|shows| shot(shows, grids.max(1))))
            .collect();
        let frames = rig.shoot_all(&shots, STAGE, cancel, &mut |_| ())?;
        // what had to be shown again is up last
        put_up(rig, last[1], cancel)?;
        let looks = shots.iter().zip(&frames).filter_map(|(shot, frames)| {
            let look = Look::of(&frames.first()?.picture);
            Some((shot.shows, look))
        });
        let watch = Watch::new(looks.collect(), last[1]);
        let mut pictures = frames.into_iter().map(|frames| {
            let pictures = frames.into_iter().map(|frame| frame.picture);
            pictures.collect::<Vec<_>>()
        });
        let mut next = || pictures.next().unwrap_or_default();
        let (black, white, first) = (next(), next(), next());
        let pipeline = PipelineSettings {
            pictures: false,
            ..settings.pipeline
        };
        let reader = Reader::new((&black, &white), projected, calibration, &pipeline)?;
        let mut live = Self {
            rig,
            cancel,
            settings,
            reader,
            watch,
            unary: Vec::new(),
            newest: VecDeque::new(),
            labels: CarriedLabels::default(),
        };
        match settings.mode {
            LiveMode::Static => live.unary = first,
            LiveMode::Dynamic => {}
            LiveMode::Tracking => {
                live.labels = CarriedLabels::of(live.reader.read_grids(&first, &[])?);
            }
        }
        Ok(live)
    }

    fn run(&mut self, on_frame: OnFrame) -> Result<(), SessionError> {
        let mut since_coded = 0;
        let mut checked = Instant::now();
        loop {
            if self.cancel.is_cancelled() {
                return Err(SessionError::Cancelled);
            }
            let check_due = self.settings.check_latency_every;
            let check_due = check_due.is_some_and(|every| checked.elapsed() > every);
            if self.settings.mode != LiveMode::Tracking && check_due {
                checked = Instant::now();
                self.check_latency()?;
            }
            let mut settings_changed = false;
            let mut taken = None;
            let due = since_coded >= self.settings.refresh.max(1);
            let told = if self.settings.mode == LiveMode::Tracking && due {
                since_coded = 0;
                self.refresh()?
            } else {
                since_coded += 1;
                let frame = self.rig.next_frame(FRAME_TIMEOUT)?;
                settings_changed = self.watch.listen(self.rig)?;
                let pattern = self.watch.pattern(&frame);
                let told = self.read(&frame, pattern)?;
                taken = Some(frame);
                told
            };
            let view = LiveView {
                told: &told,
                frame: taken.as_ref(),
                reader: &self.reader,
                labels: self.labels.all(),
                settings_changed,
            };
            if on_frame(&view).is_break() {
                return Ok(());
            }
        }
    }

    /// Reads a frame if it shows what is up in this mode.
    fn read(&mut self, frame: &Frame, pattern: &'static str) -> Result<LiveFrame, SessionError> {
        let begun = Instant::now();
        let mut told = LiveFrame {
            frame: frame.number,
            time_s: frame.captured_at.as_secs_f64(),
            pattern,
            crossings: 0,
            reasons: BTreeMap::new(),
            ms: 0.0,
        };
        let picture = &frame.picture;
        match (self.settings.mode, pattern) {
            (LiveMode::Static, "coded") => {
                self.newest.push_back(picture.clone());
                while self.newest.len() > self.settings.average.max(1) {
                    self.newest.pop_front();
                }
                let coded = self.newest.make_contiguous();
                count(self.reader.read_grids(coded, &self.unary)?, &mut told);
            }
            (LiveMode::Dynamic, "coded") => count(self.reader.read(picture)?, &mut told),
            (LiveMode::Tracking, "coded") => {
                let grid = self.reader.read(picture)?;
                self.labels = CarriedLabels::of(grid);
                count(grid, &mut told);
            }
            (LiveMode::Tracking, "unary") => {
                let lost = self.labels.follow(self.reader.read(picture)?);
                told.crossings = self.labels.len();
                if lost > 0 {
                    told.reasons.insert("lost", lost);
                }
            }
            _ => {}
        }
        told.ms = 1000.0 * begun.elapsed().as_secs_f64();
        Ok(told)
    }

    /// Checks the latency by a moment of black. Tracking needs none of its own: it changes the pattern anyhow.
    fn check_latency(&mut self) -> Result<(), SessionError> {
        if self.watch.is_up(Shows::Prmvs) {
            let coded = shot(Shows::Prmvs, 1);
            self.rig.check_latency_with(&coded, self.cancel)?;
            put_up(self.rig, Shows::Prmvs, self.cancel)?;
            self.watch.settled(Shows::Prmvs);
        }
        Ok(())
    }

    /// Shows the coded grid for a moment and labels the crossings anew; where things move too much for its frame to be
    /// told the labels are carried on.
    fn refresh(&mut self) -> Result<LiveFrame, SessionError> {
        let shots = [shot(Shows::Prmvs, 1), shot(Shows::Unary, 1)];
        let shown = self.rig.shoot_all(&shots, STAGE, self.cancel, &mut |_| ());
        let mut frames = match shown {
            Err(untold @ SessionError::NotTold { .. }) => {
                tracing::warn!("the labels are not refreshed: {untold}");
                Vec::new()
            }
            shown => shown?,
        };
        put_up(self.rig, Shows::Unary, self.cancel)?;
        self.watch.settled(Shows::Unary);
        if let Some(coded) = frames.first_mut().and_then(Vec::pop) {
            return self.read(&coded, "coded");
        }
        let frame = self.rig.next_frame(FRAME_TIMEOUT)?;
        let pattern = self.watch.pattern(&frame);
        self.read(&frame, pattern)
    }
}

/// Has a pattern shown, waits until it is settled, and forgets what was shown before.
fn put_up(rig: &mut Rig, shows: Shows, cancel: &Cancel) -> Result<(), SessionError> {
    rig.shoot(shot(shows, 1).view, 1, STAGE, shows, cancel)?;
    while rig.projector.next_notice(Duration::ZERO)?.is_some() {}
    Ok(())
}

fn shot(shows: Shows, count: usize) -> Shot {
    let view = match shows {
        Shows::Black => View::Black,
        Shows::White => View::White,
        Shows::Prmvs => View::Coded,
        Shows::Unary => View::Unary,
        Shows::Solid(colour) => View::Solid { colour },
    };
    Shot { view, shows, count }
}

/// Takes over how many crossings were read and why others were not.
fn count(grid: &DecodedGrid, told: &mut LiveFrame) {
    told.crossings = grid.crossings.len();
    let dropped = grid.dropped_by_reason().into_iter();
    told.reasons = dropped
        .filter(|(_, count)| *count > 0)
        .map(|(reason, count)| (reason.name(), count))
        .collect();
}
