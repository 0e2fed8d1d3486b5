//! The projector's state as its clients see it.

use serde::{Deserialize, Serialize};

use super::View;
use crate::pattern::{GridSettings, Pattern, RasterSize, Rgb};

/// Most characters of a name or a reason.
pub const MAX_TEXT_CHARS: usize = 1000;
/// Most colours a [`Selection`] may list.
pub const MAX_CANDIDATES: usize = 64;

/// Everything a client may know about the projector.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProjectorState {
    /// What it draws on.
    pub screen: ScreenInfo,
    /// The coded grid and its unary colour.
    pub grid: GridSettings,
    /// What was asked for last.
    pub view: View,
    /// Whether black is shown instead of `view`.
    pub blank: bool,
    /// The picture that is on the screen.
    pub shown: Shown,
    /// Name of the controller, absent when there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller: Option<String>,
    /// The last reported colour selection, absent when there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub selection: Option<Selection>,
}

/// A picture that has been presented.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shown {
    /// Number of the picture: 1 for the first, one more for each other picture.
    pub serial: u64,
    /// The picture itself.
    pub pattern: Pattern,
    /// Its size in projector pixels.
    pub raster: RasterSize,
    /// From when on it is certainly shown: the projector's monotonic clock, nanoseconds since it started.
    pub presented_ns: u64,
}

/// What the projector draws on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScreenInfo {
    /// Which kind of screen.
    pub kind: ScreenKind,
    /// The monitor's name, for example `HDMI-1`.
    pub name: String,
    /// Its size in pixels.
    pub raster: RasterSize,
    /// What is wrong with it, for people; absent when all is well.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
}

/// The kinds of screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ScreenKind {
    /// All of a monitor.
    FullScreen,
    /// A window on a desktop.
    Window,
    /// Nothing visible: for simulated rooms and tests.
    Headless,
}

/// The outcome of a colour selection, as the acquirer reports it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Selection {
    /// The colours for the coded grid, in symbol order.
    pub colours: Vec<Rgb>,
    /// The colour for the unary grid.
    pub unary: Rgb,
    /// How well the chosen colours can be told apart; higher is better, the scale is the acquirer's.
    pub score: f64,
    /// Every colour that was tried, at most [`MAX_CANDIDATES`].
    #[serde(default)]
    pub candidates: Vec<ColourScore>,
    /// Why these, for people; at most [`MAX_TEXT_CHARS`] characters.
    pub reason: String,
}

/// A colour that was tried.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ColourScore {
    /// The colour.
    pub colour: Rgb,
    /// How well it survives on the scene; higher is better.
    pub score: f64,
}
