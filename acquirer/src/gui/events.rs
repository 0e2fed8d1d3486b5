//! What the window, the rig's thread and the files' thread say to each other.

use std::{path::PathBuf, sync::Arc};

use shared::{pattern::Rgb, protocol::ProjectorState, stage::Stage};

use super::{
    open_scan::{OpenScan, StageView},
    sources::{Source, Sources},
};
use crate::{
    camera::ControlInfo,
    pipeline::colour_choice::ColourSelection,
    session::{Latency, LiveMode, Progress},
};

/// What the operator asks of the rig.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Job {
    /// Use another camera, or the same with other settings.
    Open(Source),
    /// Read every frame in this way while nothing else is done, or stop that.
    ReadLive(Option<LiveMode>),
    /// Try all colours on the scene; with `apply` the best go to the projector.
    PickColours {
        /// Whether they are applied at once.
        apply: bool,
    },
    /// Send these grid colours and the unary colour to the projector.
    ApplyColours([Rgb; 4], Rgb),
    /// Record one stage into the scan at hand, in place of what it holds of it.
    Record(Stage),
    /// Go on with another object in front of the same background.
    NextObject,
    /// Start another scan folder.
    NewScan,
    /// Say on the wall which projector this is.
    Identify,
    /// Set a control of the camera, by its number.
    SetControl(u32, i64),
    /// Make all automatics of the camera stand still.
    LockAutomatics,
    /// Set the exposure so that the white-lit scene does not clip.
    SetExposure,
}

/// What the operator asks of files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum FileJob {
    /// Look for cameras, simulated rooms and scans.
    FindSources,
    /// Read one stage of a scan, to judge it.
    ReadStage(PathBuf, Stage),
    /// Read a whole scan, write its results, and show it.
    Read(PathBuf, Place),
    /// Copy a scan to another folder.
    Save {
        /// The scan.
        from: PathBuf,
        /// The new folder.
        to: PathBuf,
    },
    /// Show a file or folder with the desktop's own program.
    OpenOutside(PathBuf),
}

/// Where a scan that was read is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// As the result.
    Result,
    /// Beside the result, for comparison.
    Beside,
}

/// Which thread an event is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Who {
    /// The one that has the rig.
    Rig,
    /// The one that reads files.
    Files,
}

/// What the threads have to tell.
#[derive(Debug)]
pub(super) enum Event {
    /// The rig is there.
    Connected(Box<RigInfo>),
    /// The rig is not there; it is tried again.
    Disconnected(String),
    /// The projector's state has changed, here or there.
    Projector(Box<ProjectorState>),
    /// Something long is under way.
    Progress(Who, Progress),
    /// The latency was measured.
    Latency(Latency),
    /// The choice among the colours that were measured so far.
    ColoursSoFar(Box<ColourSelection>),
    /// The colours were chosen, and whether they were applied.
    Colours(Box<ColourSelection>, bool),
    /// The camera's controls, or why it does not tell them.
    Controls(Result<Vec<ControlInfo>, String>),
    /// Reading every frame has ended, by an error or because it was cancelled.
    ReadingStopped,
    /// A stage was recorded into this folder.
    Recorded(Stage, PathBuf),
    /// Another object is recorded into this folder, which holds the background already.
    NextObject(PathBuf),
    /// A new, empty scan begins.
    NewScan,
    /// What there is to choose from.
    Sources(Box<Sources>),
    /// A stage was read.
    StageRead(PathBuf, Arc<StageView>),
    /// A scan was read.
    Read(Box<OpenScan>, Place),
    /// Something for the list of messages.
    Note(String),
    /// Something goes on, but not as it should.
    Warning(String),
    /// Something failed, and why.
    Failed(String),
    /// A thread has nothing more to do.
    Idle(Who),
}

/// The rig as the window shows it.
#[derive(Debug, Clone)]
pub(super) struct RigInfo {
    /// The camera, in words.
    pub(super) camera: String,
    /// What it was opened as.
    pub(super) source: Source,
    /// Size, format and rate of its frames, in words.
    pub(super) format: String,
    /// Its width and height in pixels.
    pub(super) size: [u32; 2],
    /// The projector's state.
    pub(super) projector: ProjectorState,
}
