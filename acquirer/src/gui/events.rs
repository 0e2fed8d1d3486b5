//! What the window and its worker say to each other.

use std::path::PathBuf;

use image::RgbImage;
use shared::{protocol::ProjectorState, stage::Stage};

use crate::{
    pipeline::colour_choice::ColourSelection,
    session::{Latency, Progress},
};

/// What the operator asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Job {
    /// Try all colours and apply the best.
    PickColours,
    /// Record one stage.
    Record(Stage),
    /// Read the recorded scan.
    Read,
    /// Start another scan folder.
    NewScan,
}

/// What the worker has to tell.
#[derive(Debug)]
pub(super) enum Event {
    /// The rig is there.
    Connected(Box<RigInfo>),
    /// The rig is not there; it is tried again.
    Disconnected(String),
    /// A job is under way.
    Progress(Progress),
    /// The latency was measured.
    Latency(Latency),
    /// The colours were chosen.
    Colours(Box<ColourSelection>),
    /// A stage was recorded into this folder.
    Recorded(Stage, PathBuf),
    /// The scan was read.
    Read(Box<ReadScan>),
    /// A new, empty scan begins.
    NewScan,
    /// A job failed, and why.
    Failed(String),
    /// A job has ended, well or not.
    Idle,
}

/// The rig as the window shows it.
#[derive(Debug, Clone)]
pub(super) struct RigInfo {
    /// The camera.
    pub(super) camera: String,
    /// The projector's state when it was connected.
    pub(super) projector: ProjectorState,
}

/// A scan that was read.
#[derive(Debug)]
pub(super) struct ReadScan {
    /// The figures, one line each.
    pub(super) figures: Vec<String>,
    /// The report.
    pub(super) report: PathBuf,
    /// Result pictures with their captions.
    pub(super) pictures: Vec<(String, RgbImage)>,
}

/// A frame for the live picture.
#[derive(Debug, Clone)]
pub(super) struct LiveFrame {
    /// The camera's picture.
    pub(super) picture: RgbImage,
    /// The camera's number of the frame.
    pub(super) number: u64,
    /// Frames per second over the last second.
    pub(super) rate_hz: f64,
    /// Frames that the camera made and nobody saw.
    pub(super) lost: u64,
}
