//! Everything the window shows: changed here alone, by the operator and by the events of the two threads.

mod asking;
mod state;
mod taking;

use std::{collections::VecDeque, path::PathBuf, sync::Arc};

use shared::{
    pattern::{GridSettings, Palette},
    stage::Stage,
};

use super::{
    events::RigInfo,
    open_scan::{OpenScan, StageView},
    pictures::Pictures,
    preferences::Preferences,
    repaints::Repaints,
    sources::{Source, Sources},
};
use crate::session::Latency;
pub(super) use state::{
    Colours, Controls, Live, Look, Message, Ports, ResultView, ScanAtHand, Side, StageSlot, Steps,
    Tab, Task, Weight,
};

/// Lines of messages that are kept.
const MESSAGES: usize = 200;
/// Warnings that are in sight at once.
const WARNINGS: usize = 3;

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
    pub(super) controls: Controls,
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
    pub(super) messages: VecDeque<Message>,
    pub(super) error: Option<String>,
    /// The newest warnings that were not dismissed.
    pub(super) warnings: Vec<String>,
    pub(super) show_help: bool,
    pub(super) show_messages: bool,
    /// Goes through all steps once without asking.
    pub(super) run_all: bool,
    pub(super) pictures: Pictures,
    pub(super) repaints: Repaints,
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
            controls: Controls::default(),
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
            warnings: Vec::new(),
            show_help: false,
            show_messages: false,
            run_all,
            pictures: Pictures::default(),
            repaints: Repaints::default(),
        }
    }

    /// Adds a line to the messages.
    pub(super) fn say(&mut self, text: String) {
        self.note(text, Weight::Note);
    }

    /// Tells the operator of something that goes on, but not as it should.
    pub(super) fn warn(&mut self, text: String) {
        if !self.warnings.contains(&text) {
            self.warnings.push(text.clone());
            let old = self.warnings.len().saturating_sub(WARNINGS);
            self.warnings.drain(..old);
        }
        self.note(text, Weight::Warning);
    }

    /// Tells the operator of something that did not go.
    pub(super) fn fail(&mut self, reason: String) {
        self.run_all = false;
        self.note(reason.clone(), Weight::Error);
        self.error = Some(reason);
    }

    fn note(&mut self, text: String, weight: Weight) {
        self.messages.push_back(Message { text, weight });
        if self.messages.len() > MESSAGES {
            self.messages.pop_front();
        }
    }

    /// The stage that the step view shows: of the scan at hand, else of the result.
    pub(super) fn shown_stage(&self) -> Option<&Arc<StageView>> {
        let slot = usize::from(self.steps.stage == Stage::Object);
        let at_hand = self.scan.stages[slot].view.as_ref();
        at_hand.or_else(|| self.result.as_ref()?.stage(self.steps.stage))
    }
}
