//! What the threads tell, taken over into what the window shows.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use shared::{pattern::GridSettings, stage::Stage};

use super::{Model, ScanAtHand, Side, StageSlot, Tab};
use crate::{
    gui::{
        events::{Event, FileJob, Job, Place, RigInfo, Who},
        live_picture::Wishes,
        open_scan::{OpenScan, StageView},
    },
    pipeline::colour_choice::ColourSelection,
    session::Latency,
};

impl Model {
    /// Takes what the threads have told, and the newest picture; never waits.
    pub(in crate::gui) fn take_events(&mut self) {
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
            controls: self.controls.are_shown,
        });
        for warning in self.ports.log.take() {
            self.warn(warning);
        }
    }

    /// Changes what is shown as an event asks for.
    pub(in crate::gui) fn take_event(&mut self, event: Event) {
        match event {
            Event::Connected(info) => self.take_rig(*info),
            Event::Disconnected(reason) => self.take_disconnected(reason),
            Event::Projector(state) => {
                self.follow_projector(&state.grid);
                if let Ok(rig) = &mut self.rig {
                    rig.projector = *state;
                }
            }
            Event::Progress(who, progress) => self.begin(who).progress = Some(progress),
            Event::Latency(latency) => self.take_latency(latency),
            Event::Controls(list) => self.controls.list = list,
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
            Event::NextObject(dir) => self.take_next_object(dir),
            Event::NewScan => {
                self.scan = ScanAtHand::default();
                self.say("a new scan begins".into());
            }
            Event::Sources(sources) => self.sources = *sources,
            Event::StageRead(dir, view) => self.take_stage(&dir, view),
            Event::Read(scan, place) => self.take_scan(*scan, place),
            Event::Note(note) => self.say(note),
            Event::Warning(warning) => self.warn(warning),
            Event::Failed(reason) => self.fail(reason),
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

    fn take_disconnected(&mut self, reason: String) {
        if self.rig.as_ref().err() != Some(&reason) {
            self.say(reason.clone());
        }
        self.run_all &= self.rig.is_err();
        self.rig = Err(reason);
        self.tasks[Who::Rig as usize] = None;
        self.controls.list = Ok(Vec::new());
    }

    fn take_latency(&mut self, latency: Latency) {
        self.say(format!(
            "latency {:.0} ms, at most {:.0} ms",
            latency.timing.latency.ms,
            latency.timing.settled_ms()
        ));
        self.latency = Some(latency);
    }

    fn take_next_object(&mut self, dir: PathBuf) {
        self.say(format!("the next object goes to {}", dir.display()));
        self.scan.dir = Some(dir);
        self.scan.stages[1] = StageSlot::default();
        self.scan.objects += 1;
    }
}
