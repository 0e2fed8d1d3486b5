//! The parts of what the window shows.

use std::{
    path::PathBuf,
    sync::{
        Arc,
        mpsc::{Receiver, SyncSender},
    },
    time::Instant,
};

use look::log::Warnings;
use shared::{
    pattern::{Palette, Rgb},
    stage::Stage,
};

use crate::{
    camera::ControlInfo,
    gui::{
        events::{Event, FileJob, Job},
        live_picture::{LivePicture, LivePlace},
        open_scan::StageView,
    },
    pipeline::colour_choice::ColourSelection,
    session::{Cancel, Progress},
};

/// What fills the middle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::gui) enum Tab {
    Live,
    Steps,
    Result,
    Compare,
}

/// What fills the side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::gui) enum Side {
    Source,
    Colours,
    Scan,
}

/// Which view of the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::gui) enum ResultView {
    Surface,
    ShiftMap,
    Table,
}

/// The ways to the two threads.
#[derive(Debug)]
pub(in crate::gui) struct Ports {
    pub(in crate::gui) jobs: SyncSender<Job>,
    pub(in crate::gui) files: SyncSender<FileJob>,
    pub(in crate::gui) events: Receiver<Event>,
    pub(in crate::gui) live: LivePlace,
    /// Stops what the rig's thread is at.
    pub(in crate::gui) cancel: Cancel,
    /// Stops what the files' thread is at.
    pub(in crate::gui) cancel_files: Cancel,
    /// What the log warns of.
    pub(in crate::gui) log: Warnings,
}

/// A long action.
#[derive(Debug, Clone)]
pub(in crate::gui) struct Task {
    /// Where it is, once it told.
    pub(in crate::gui) progress: Option<Progress>,
    /// Since when it goes on.
    pub(in crate::gui) since: Instant,
    /// Whether it was asked to stop.
    pub(in crate::gui) stopping: bool,
}

/// The live picture.
#[derive(Debug, Default)]
pub(in crate::gui) struct Live {
    /// The newest.
    pub(in crate::gui) picture: Option<LivePicture>,
    /// The operator has switched the update off.
    pub(in crate::gui) frozen: bool,
}

/// The camera's controls.
#[derive(Debug)]
pub(in crate::gui) struct Controls {
    /// As the camera told them last, or why it could not.
    pub(in crate::gui) list: Result<Vec<ControlInfo>, String>,
    /// The one whose slider is being dragged, by its number, and the value so far.
    pub(in crate::gui) moving: Option<(u32, i64)>,
    /// They are in sight.
    pub(in crate::gui) are_shown: bool,
}

impl Default for Controls {
    fn default() -> Self {
        Self {
            list: Ok(Vec::new()),
            moving: None,
            are_shown: false,
        }
    }
}

/// A line of the list of what happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::gui) struct Message {
    /// What.
    pub(in crate::gui) text: String,
    /// How much it matters.
    pub(in crate::gui) weight: Weight,
}

/// How much a message matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::gui) enum Weight {
    Note,
    Warning,
    Error,
}

/// The choice of colours.
#[derive(Debug)]
pub(in crate::gui) struct Colours {
    pub(in crate::gui) palette: Palette,
    /// What was measured, once it was.
    pub(in crate::gui) measured: Option<ColourSelection>,
    /// Whether all colours were measured.
    pub(in crate::gui) complete: bool,
    /// What would be sent to the projector.
    pub(in crate::gui) best: [Rgb; 4],
    pub(in crate::gui) unary: Rgb,
    /// The operator has chosen otherwise.
    pub(in crate::gui) overridden: bool,
}

/// One stage of the scan at hand.
#[derive(Debug, Default)]
pub(in crate::gui) struct StageSlot {
    /// It was recorded.
    pub(in crate::gui) recorded: bool,
    /// What was read of it.
    pub(in crate::gui) view: Option<Arc<StageView>>,
    /// The operator has accepted it.
    pub(in crate::gui) accepted: bool,
}

/// The scan at hand.
#[derive(Debug, Default)]
pub(in crate::gui) struct ScanAtHand {
    pub(in crate::gui) dir: Option<PathBuf>,
    pub(in crate::gui) stages: [StageSlot; 2],
    /// Objects recorded in front of this background.
    pub(in crate::gui) objects: usize,
}

/// The step view.
#[derive(Debug)]
pub(in crate::gui) struct Steps {
    pub(in crate::gui) stage: Stage,
    /// The step that is shown large; all side by side without one.
    pub(in crate::gui) enlarged: Option<usize>,
    /// The crossing that was clicked, by its place among the labelled ones.
    pub(in crate::gui) crossing: Option<usize>,
}

/// From where surfaces are looked at.
#[derive(Debug, Clone, Copy)]
pub(in crate::gui) struct Look {
    pub(in crate::gui) yaw_rad: f32,
    pub(in crate::gui) pitch_rad: f32,
    pub(in crate::gui) zoom: f32,
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
