//! Everything the window shows: changed here alone, by the operator and by the events of the two threads.

use std::{
    collections::VecDeque,
    path::{Path, PathBuf},
    sync::{
        Arc,
        mpsc::{Receiver, SyncSender},
    },
    time::Instant,
};

use shared::{
    pattern::{GridSettings, Palette, Rgb},
    stage::Stage,
};

use super::{
    events::{Event, FileJob, Job, Place, RigInfo, Who},
    live_picture::{LivePicture, LivePlace, Wishes},
    open_scan::{OpenScan, StageView},
    pictures::Pictures,
    preferences::Preferences,
    sources::{Source, Sources},
};
use crate::{
    pipeline::colour_choice::ColourSelection,
    session::{Cancel, Latency, Progress},
};

/// Lines of messages that are kept.
const MESSAGES: usize = 200;

/// What fills the middle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tab {
    Live,
    Steps,
    Result,
    Compare,
}

/// What fills the side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Source,
    Colours,
    Scan,
}

/// Which view of the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ResultView {
    Surface,
    ShiftMap,
    Table,
}

/// The ways to the two threads.
#[derive(Debug)]
pub(super) struct Ports {
    pub(super) jobs: SyncSender<Job>,
    pub(super) files: SyncSender<FileJob>,
    pub(super) events: Receiver<Event>,
    pub(super) live: LivePlace,
    pub(super) cancel: Cancel,
}

/// A long action.
#[derive(Debug, Clone)]
pub(super) struct Task {
    /// Where it is, once it told.
    pub(super) progress: Option<Progress>,
    /// Since when it goes on.
    pub(super) since: Instant,
    /// Whether it was asked to stop.
    pub(super) stopping: bool,
}

/// The live picture.
#[derive(Debug, Default)]
pub(super) struct Live {
    /// The newest.
    pub(super) picture: Option<LivePicture>,
    /// The operator has switched the update off.
    pub(super) frozen: bool,
}

/// The choice of colours.
#[derive(Debug)]
pub(super) struct Colours {
    pub(super) palette: Palette,
    /// What was measured, once it was.
    pub(super) measured: Option<ColourSelection>,
    /// Whether all colours were measured.
    pub(super) complete: bool,
    /// What would be sent to the projector.
    pub(super) best: [Rgb; 4],
    pub(super) unary: Rgb,
    /// The operator has chosen otherwise.
    pub(super) overridden: bool,
}

/// One stage of the scan at hand.
#[derive(Debug, Default)]
pub(super) struct StageSlot {
    /// It was recorded.
    pub(super) recorded: bool,
    /// What was read of it.
    pub(super) view: Option<Arc<StageView>>,
    /// The operator has accepted it.
    pub(super) accepted: bool,
}

/// The scan at hand.
#[derive(Debug, Default)]
pub(super) struct ScanAtHand {
    pub(super) dir: Option<PathBuf>,
    pub(super) stages: [StageSlot; 2],
    /// Objects recorded in front of this background.
    pub(super) objects: usize,
}

/// The step view.
#[derive(Debug)]
pub(super) struct Steps {
    pub(super) stage: Stage,
    /// The step that is shown large; all side by side without one.
    pub(super) enlarged: Option<usize>,
    /// The crossing that was clicked, by its place among the labelled ones.
    pub(super) crossing: Option<usize>,
}

/// From where surfaces are looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    pub(super) yaw_rad: f32,
    pub(super) pitch_rad: f32,
    pub(super) zoom: f32,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            yaw_rad: 0.5,
            pitch_rad: 0.38,
            zoom: 1.0,
        }
    }
}

/// How long repaints take, in milliseconds: the panels with the events before them, and the whole with drawing.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RepaintTimes {
    pub(super) own_ms: f32,
    pub(super) longest_own_ms: f32,
    pub(super) longest_whole_ms: f32,
}

/// Everything the window shows.
pub(super) struct Model {
    pub(super) ports: Ports,
    pub(super) preferences: Preferences,
    pub(super) address: String,
    /// Folder of the first scan.
    pub(super) out: PathBuf,
    pub(super) rig: Result<RigInfo, String>,
    /// What the operator wants of the camera; sent when it is changed.
    pub(super) source: Source,
    pub(super) sources: Sources,
    pub(super) tasks: [Option<Task>; 2],
    pub(super) latency: Option<Latency>,
    pub(super) live: Live,
    pub(super) colours: Colours,
    pub(super) scan: ScanAtHand,
    pub(super) result: Option<OpenScan>,
    pub(super) beside: Option<OpenScan>,
    pub(super) steps: Steps,
    pub(super) look: Look,
    pub(super) result_view: ResultView,
    /// The name under which the result is saved.
    pub(super) save_name: String,
    /// A scan folder that is typed in.
    pub(super) load_name: String,
    pub(super) tab: Tab,
    pub(super) side: Side,
    pub(super) messages: VecDeque<String>,
    pub(super) error: Option<String>,
    pub(super) show_help: bool,
    pub(super) show_messages: bool,
    /// Goes through all steps once without asking.
    pub(super) run_all: bool,
    pub(super) pictures: Pictures,
    pub(super) repaint: RepaintTimes,
}

impl Model {
    /// A window without a rig yet.
    pub(super) fn new(
        ports: Ports,
        preferences: Preferences,
        source: Source,
        (address, out): (String, PathBuf),
        run_all: bool,
    ) -> Self {
        let GridSettings { coded, unary } = GridSettings::default();
        let best = coded.colours().try_into().unwrap_or([unary; 4]);
        Self {
            ports,
            preferences,
            address,
            out,
            rig: Err("connecting".into()),
            source,
            sources: Sources::default(),
            tasks: [None, None],
            latency: None,
            live: Live::default(),
            colours: Colours {
                palette: Palette::default(),
                measured: None,
                complete: false,
                best,
                unary,
                overridden: false,
            },
            scan: ScanAtHand::default(),
            result: None,
            beside: None,
            steps: Steps {
                stage: Stage::Object,
                enlarged: None,
                crossing: None,
            },
            look: Look::default(),
            result_view: ResultView::Surface,
            save_name: String::new(),
            load_name: String::new(),
            tab: Tab::Live,
            side: if run_all { Side::Scan } else { Side::Source },
            messages: VecDeque::new(),
            error: None,
            show_help: false,
            show_messages: false,
            run_all,
            pictures: Pictures::default(),
            repaint: RepaintTimes::default(),
        }
    }

    /// Takes what the threads have told, and the newest picture; never waits.
    pub(super) fn take_events(&mut self) {
        while let Ok(event) = self.ports.events.try_recv() {
            self.take_event(event);
        }
        if let Some(picture) = self.ports.live.take()
            && !self.live.frozen
        {
            self.live.picture = Some(picture);
        }
        self.ports.live.wish(Wishes {
            after: self.preferences.after,
            subtract: self.preferences.subtract,
            histogram: self.preferences.histogram,
            overlays: self.preferences.overlays,
        });
    }

    /// Changes what is shown as an event asks for.
    pub(super) fn take_event(&mut self, event: Event) {
        match event {
            Event::Connected(info) => self.take_rig(*info),
            Event::Disconnected(reason) => {
                if self.rig.as_ref().err() != Some(&reason) {
                    self.say(reason.clone());
                }
                self.run_all &= self.rig.is_err();
                self.rig = Err(reason);
                self.tasks[Who::Rig as usize] = None;
            }
            Event::Projector(state) => {
                self.follow_projector(&state.grid);
                if let Ok(rig) = &mut self.rig {
                    rig.projector = *state;
                }
            }
            Event::Progress(who, progress) => self.begin(who).progress = Some(progress),
            Event::Latency(latency) => {
                self.say(format!(
                    "latency {:.0} ms, at most {:.0} ms",
                    latency.timing.latency.ms,
                    latency.timing.settled_ms()
                ));
                self.latency = Some(latency);
            }
            Event::ColoursSoFar(so_far) => self.take_colours(*so_far, false),
            Event::Colours(selection, applied) => {
                for reason in &selection.reasons {
                    self.say(reason.clone());
                }
                self.take_colours(*selection, true);
                if applied {
                    self.scan = ScanAtHand::default();
                }
            }
            Event::ReadingStopped => self.preferences.read_live = false,
            Event::Recorded(stage, dir) => self.take_recorded(stage, dir),
            Event::NextObject(dir) => {
                self.say(format!("the next object goes to {}", dir.display()));
                self.scan.dir = Some(dir);
                self.scan.stages[1] = StageSlot::default();
                self.scan.objects += 1;
            }
            Event::NewScan => {
                self.scan = ScanAtHand::default();
                self.say("a new scan begins".into());
            }
            Event::Sources(sources) => self.sources = *sources,
            Event::StageRead(dir, view) => self.take_stage(&dir, view),
            Event::Read(scan, place) => self.take_scan(*scan, place),
            Event::Note(note) => self.say(note),
            Event::Failed(reason) => {
                self.run_all = false;
                self.say(reason.clone());
                self.error = Some(reason);
            }
            Event::Idle(who) => self.tasks[who as usize] = None,
        }
    }

    fn take_rig(&mut self, info: RigInfo) {
        self.say(format!("connected: {}", info.camera));
        self.source = info.source.clone();
        self.follow_projector(&info.projector.grid);
        self.tasks[Who::Rig as usize] = None;
        self.latency = None;
        self.rig = Ok(info);
        if self.run_all {
            self.ask(Job::PickColours { apply: true });
            self.ask(Job::Record(Stage::Background));
            self.ask(Job::Record(Stage::Object));
        }
    }

    /// The colours that the projector has are the choice, until something else is chosen here.
    fn follow_projector(&mut self, grid: &GridSettings) {
        if self.colours.measured.is_none() && !self.colours.overridden {
            self.colours.best = grid.coded.colours().try_into().unwrap_or(self.colours.best);
            self.colours.unary = grid.unary;
        }
    }

    fn take_colours(&mut self, selection: ColourSelection, complete: bool) {
        if self.run_all {
            self.side = Side::Colours;
        }
        self.colours.best = selection.best;
        self.colours.unary = selection.unary;
        self.colours.overridden = false;
        self.colours.complete = complete;
        self.colours.measured = Some(selection);
    }

    fn take_recorded(&mut self, stage: Stage, dir: PathBuf) {
        self.say(format!("{stage} recorded into {}", dir.display()));
        self.side = Side::Scan;
        if self.scan.dir.as_ref() != Some(&dir) {
            self.scan = ScanAtHand::default();
        }
        self.scan.stages[usize::from(stage == Stage::Object)] = StageSlot {
            recorded: true,
            view: None,
            accepted: self.run_all,
        };
        self.scan.dir = Some(dir.clone());
        self.ask_files(FileJob::ReadStage(dir.clone(), stage));
        if self.run_all && stage == Stage::Object {
            self.ask_files(FileJob::Read(dir, Place::Result));
        }
    }

    fn take_stage(&mut self, dir: &Path, view: Arc<StageView>) {
        if self.scan.dir.as_deref() == Some(dir) {
            self.steps.stage = view.stage;
            self.steps.crossing = None;
            let slot = usize::from(view.stage == Stage::Object);
            self.scan.stages[slot].view = Some(view);
        }
    }

    fn take_scan(&mut self, scan: OpenScan, place: Place) {
        self.say(format!("{} was read", scan.name()));
        match place {
            Place::Result => {
                self.save_name = format!("{}-kept", scan.dir.display());
                self.steps.crossing = None;
                self.result = Some(scan);
                self.tab = Tab::Result;
                self.run_all = false;
            }
            Place::Beside => {
                self.beside = Some(scan);
                self.tab = Tab::Compare;
            }
        }
        self.ask_files(FileJob::FindSources);
    }

    /// Adds a line to the messages.
    pub(super) fn say(&mut self, message: String) {
        self.messages.push_back(message);
        if self.messages.len() > MESSAGES {
            self.messages.pop_front();
        }
    }

    fn begin(&mut self, who: Who) -> &mut Task {
        self.tasks[who as usize].get_or_insert_with(|| Task {
            progress: None,
            since: Instant::now(),
            stopping: false,
        })
    }

    /// Whether one of the threads is at something long.
    pub(super) fn is_busy(&self, who: Who) -> bool {
        self.tasks[who as usize].is_some()
    }

    /// Whether the rig can take another job.
    pub(super) fn is_ready(&self) -> bool {
        self.rig.is_ok() && !self.is_busy(Who::Rig)
    }

    /// Asks the rig's thread for something. A queue that is full is told.
    pub(super) fn ask(&mut self, job: Job) {
        match self.ports.jobs.try_send(job) {
            Ok(()) => {
                self.begin(Who::Rig);
            }
            Err(_) => self.error = Some("too much was asked for at once: wait a moment".into()),
        }
    }

    /// As [`Self::ask`], when nothing else is under way.
    pub(super) fn ask_if_ready(&mut self, job: Job) {
        if self.is_ready() {
            self.ask(job);
        }
    }

    /// Asks the files' thread for something.
    pub(super) fn ask_files(&mut self, job: FileJob) {
        match self.ports.files.try_send(job) {
            Ok(()) => {
                self.begin(Who::Files);
            }
            Err(_) => self.error = Some("too much was asked for at once: wait a moment".into()),
        }
    }

    /// Switches live reading on or off.
    pub(super) fn set_read_live(&mut self, on: bool) {
        self.preferences.read_live = on;
        if self.ports.jobs.try_send(Job::ReadLive(on)).is_err() {
            self.error = Some("too much was asked for at once: wait a moment".into());
        }
    }

    /// Opens the source as it is wanted now.
    pub(super) fn open_source(&mut self) {
        self.live.picture = None;
        self.ask(Job::Open(self.source.clone()));
    }

    /// Sends the chosen colours to the projector.
    pub(super) fn apply_colours(&mut self) {
        if self.may_apply() {
            self.ask(Job::ApplyColours(self.colours.best, self.colours.unary));
        }
    }

    /// Whether the chosen colours could be sent, and are not there already.
    pub(super) fn may_apply(&self) -> bool {
        let different = |best: &[Rgb; 4]| (0..4).all(|k| !best[..k].contains(&best[k]));
        self.is_ready() && different(&self.colours.best) && !self.are_colours_there()
    }

    /// Whether the projector's grid has the chosen colours.
    pub(super) fn are_colours_there(&self) -> bool {
        self.rig.as_ref().is_ok_and(|rig| {
            let grid = &rig.projector.grid;
            grid.coded.colours() == self.colours.best && grid.unary == self.colours.unary
        })
    }

    /// Whether a stage can be recorded: the object after the background.
    pub(super) fn may_record(&self, stage: Stage) -> bool {
        self.is_ready() && (stage == Stage::Background || self.scan.stages[0].recorded)
    }

    /// Records a stage, for the first time or again.
    pub(super) fn record(&mut self, stage: Stage) {
        if self.may_record(stage) {
            self.tab = Tab::Live;
            self.side = Side::Scan;
            self.ask(Job::Record(stage));
        }
    }

    /// Stops what is under way.
    pub(super) fn cancel(&mut self) {
        self.error = None;
        self.show_help = false;
        if let Some(task) = &mut self.tasks[Who::Rig as usize] {
            task.stopping = true;
            self.run_all = false;
            self.ports.cancel.cancel();
        }
    }

    /// The stage that the step view shows: of the scan at hand, else of the result.
    pub(super) fn shown_stage(&self) -> Option<&Arc<StageView>> {
        let slot = usize::from(self.steps.stage == Stage::Object);
        let at_hand = self.scan.stages[slot].view.as_ref();
        at_hand.or_else(|| self.result.as_ref()?.stage(self.steps.stage))
    }
}
