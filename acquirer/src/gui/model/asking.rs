//! What the operator asks for, sent to the threads; nothing here waits for them.

use std::time::Instant;

use shared::{pattern::Rgb, stage::Stage};

use super::{Model, Side, Tab, Task};
use crate::{
    gui::events::{FileJob, Job, Who},
    session::LiveMode,
};

const TOO_MUCH: &str = "too much was asked for at once: wait a moment";

impl Model {
    /// Notes that a thread is at something.
    pub(super) fn begin(&mut self, who: Who) -> &mut Task {
        self.tasks[who as usize].get_or_insert_with(|| Task {
            progress: None,
            since: Instant::now(),
            stopping: false,
        })
    }

    /// Whether one of the threads is at something long.
    pub(in crate::gui) fn is_busy(&self, who: Who) -> bool {
        self.tasks[who as usize].is_some()
    }

    /// Whether the rig can take another job.
    pub(in crate::gui) fn is_ready(&self) -> bool {
        self.rig.is_ok() && !self.is_busy(Who::Rig)
    }

    /// Asks the rig's thread for something. A queue that is full is told.
    pub(in crate::gui) fn ask(&mut self, job: Job) {
        match self.ports.jobs.try_send(job) {
            Ok(()) => {
                self.begin(Who::Rig);
            }
            Err(_) => self.error = Some(TOO_MUCH.into()),
        }
    }

    /// As [`Self::ask`], when nothing else is under way.
    pub(in crate::gui) fn ask_if_ready(&mut self, job: Job) {
        if self.is_ready() {
            self.ask(job);
        }
    }

    /// Asks the files' thread for something.
    pub(in crate::gui) fn ask_files(&mut self, job: FileJob) {
        match self.ports.files.try_send(job) {
            Ok(()) => {
                self.begin(Who::Files);
            }
            Err(_) => self.error = Some(TOO_MUCH.into()),
        }
    }

    /// Switches live reading on or off.
    pub(in crate::gui) fn set_read_live(&mut self, on: bool) {
        self.preferences.read_live = on;
        let reading = Job::ReadLive(self.wanted_reading());
        if self.ports.jobs.try_send(reading).is_err() {
            self.error = Some(TOO_MUCH.into());
        }
    }

    /// How frames are to be read while nothing else is done, if they are.
    pub(in crate::gui) fn wanted_reading(&self) -> Option<LiveMode> {
        Some(self.preferences.live_mode).filter(|_| self.preferences.read_live)
    }

    /// Reads live in another way from now on.
    pub(in crate::gui) fn set_live_mode(&mut self, mode: LiveMode) {
        self.preferences.live_mode = mode;
        if self.preferences.read_live {
            self.set_read_live(true);
        }
    }

    /// Opens the source as it is wanted now.
    pub(in crate::gui) fn open_source(&mut self) {
        self.live.picture = None;
        self.ask(Job::Open(self.source.clone()));
    }

    /// Sends the chosen colours to the projector.
    pub(in crate::gui) fn apply_colours(&mut self) {
        if self.may_apply() {
            self.ask(Job::ApplyColours(self.colours.best, self.colours.unary));
        }
    }

    /// Whether the chosen colours could be sent, and are not there already.
    pub(in crate::gui) fn may_apply(&self) -> bool {
        let different = |best: &[Rgb; 4]| (0..4).all(|k| !best[..k].contains(&best[k]));
        self.is_ready() && different(&self.colours.best) && !self.are_colours_there()
    }

    /// Whether the projector's grid has the chosen colours.
    pub(in crate::gui) fn are_colours_there(&self) -> bool {
        self.rig.as_ref().is_ok_and(|rig| {
            let grid = &rig.projector.grid;
            grid.coded.colours() == self.colours.best && grid.unary == self.colours.unary
        })
    }

    /// Whether a stage can be recorded: the object after the background.
    pub(in crate::gui) fn may_record(&self, stage: Stage) -> bool {
        self.is_ready() && (stage == Stage::Background || self.scan.stages[0].recorded)
    }

    /// Records a stage, for the first time or again.
    pub(in crate::gui) fn record(&mut self, stage: Stage) {
        if self.may_record(stage) {
            self.tab = Tab::Live;
            self.side = Side::Scan;
            self.ask(Job::Record(stage));
        }
    }

    /// Stops what is under way.
    pub(in crate::gui) fn cancel(&mut self) {
        self.error = None;
        self.show_help = false;
        self.stop(Who::Rig);
        self.stop(Who::Files);
    }

    /// Asks one of the threads to stop what it is at.
    pub(in crate::gui) fn stop(&mut self, who: Who) {
        if let Some(task) = &mut self.tasks[who as usize] {
            task.stopping = true;
            self.run_all = false;
            match who {
                Who::Rig => self.ports.cancel.cancel(),
                Who::Files => self.ports.cancel_files.cancel(),
            }
        }
    }
}
