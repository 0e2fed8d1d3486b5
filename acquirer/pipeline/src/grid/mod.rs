//! The decoded grid: crossings with their place in the pattern, and what was dropped and why.
//!
//! [`Decoding::find_grid`] takes the crossings and the evidence for their lines' colours, links neighbours into
//! patches with integer places (`links`), finds each patch's place in the codes (`code`, `labels`), checks the
//! labels against the epipolar geometry (`checks`), labels with its help what the patches left (`rest`), places the
//! vertices (`vertices`) and numbers the lines (`stretches`). What is not certain is dropped with a reason, never
//! guessed.

mod checks;
mod code;
mod doubts;
mod expected;
mod find;
mod labels;
mod links;
mod propagate;
mod rest;
mod stretches;
mod vertices;

use serde::{Deserialize, Serialize};
use shared::{
    geometry::CameraPixel,
    pattern::{Axis, Corner, GridIndex},
};

pub use find::{DecodeSettings, Decoding, Observed};

/// A crossing whose row and column are known.
#[derive(Debug, Clone, PartialEq)]
pub struct DecodedCrossing {
    /// Row and column in the projected grid.
    pub index: GridIndex,
    /// Where the middle lines of row and column meet.
    pub centre: CameraPixel,
    /// The four vertices in the order of [`shared::pattern::Corner::ALL`].
    pub vertices: [CameraPixel; 4],
    /// Probability that the label is right, 0 to 1.
    pub confidence: f64,
}

/// Why a crossing or a stretch of line has no label.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DropReason {
    /// Too little projected light came back.
    TooDark,
    /// The camera saturated.
    Clipped,
    /// The colour of a line could be more than one of the pattern's.
    AmbiguousColour,
    /// Too few connected neighbours to make up a window.
    BrokenLine,
    /// No place of the sequence fits, or more than one does.
    NotInCode,
    /// The label contradicts the epipolar geometry, a neighbouring, better supported one, or a coarser grid.
    OffEpipolarLine,
}

impl DropReason {
    /// All reasons, in the order of the report.
    pub const ALL: [Self; 6] = [
        Self::TooDark,
        Self::Clipped,
        Self::AmbiguousColour,
        Self::BrokenLine,
        Self::NotInCode,
        Self::OffEpipolarLine,
    ];

    /// The name in result files, for example `too_dark`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::TooDark => "too_dark",
            Self::Clipped => "clipped",
            Self::AmbiguousColour => "ambiguous_colour",
            Self::BrokenLine => "broken_line",
            Self::NotInCode => "not_in_code",
            Self::OffEpipolarLine => "off_epipolar_line",
        }
    }
}

/// A crossing that was found but not labelled.
#[derive(Debug, Clone, PartialEq)]
pub struct DroppedCrossing {
    /// Where it was found.
    pub centre: CameraPixel,
    /// Why it has no label.
    pub reason: DropReason,
}

/// A stretch of one line, decoded or not.
#[derive(Debug, Clone, PartialEq)]
pub struct LineTrack {
    /// Rows are horizontal lines of the pattern, columns vertical ones.
    pub axis: Axis,
    /// Which line of the pattern, when decoded.
    pub line: Option<u16>,
    /// Points on the middle of the line, in order along it.
    pub points: Vec<LinePoint>,
}

/// A point on the middle of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinePoint {
    /// Position.
    pub position: CameraPixel,
    /// Half of the line's width across its direction, in camera pixels.
    pub half_width_px: f64,
    /// Probability that the line's label holds here, 0 to 1.
    pub confidence: f64,
}

/// What was read from the coded grid of one stage.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DecodedGrid {
    /// Labelled crossings, each index at most once, sorted by index.
    pub crossings: Vec<DecodedCrossing>,
    /// Crossings that lack an arm, at a border, a shadow or an edge of a surface: their lines are known and carry
    /// their numbers, but where their vertices stand is not certain. They are among the dropped ones too.
    pub partial: Vec<DecodedCrossing>,
    /// Crossings found and dropped.
    pub dropped: Vec<DroppedCrossing>,
    /// The lines that were followed.
    pub tracks: Vec<LineTrack>,
}

impl DecodedGrid {
    /// The crossing with this index, if it was read.
    #[must_use]
    pub fn crossing(&self, index: GridIndex) -> Option<&DecodedCrossing> {
        let found = self
            .crossings
            .binary_search_by_key(&index, |crossing| crossing.index);
        found.ok().map(|at| &self.crossings[at])
    }

    /// All crossings whose lines are known, whole or not.
    pub fn placed(&self) -> impl Iterator<Item = &DecodedCrossing> {
        self.crossings.iter().chain(&self.partial)
    }

    /// Every vertex of every labelled crossing.
    pub fn vertices(&self) -> impl Iterator<Item = (GridIndex, Corner, CameraPixel)> + '_ {
        self.crossings.iter().flat_map(|crossing| {
            let corners = Corner::ALL.into_iter().zip(crossing.vertices);
            corners.map(|(corner, at)| (crossing.index, corner, at))
        })
    }

    /// How many crossings were dropped for each reason, in the order of [`DropReason::ALL`].
    #[must_use]
    pub fn dropped_by_reason(&self) -> [(DropReason, usize); 6] {
        DropReason::ALL.map(|reason| {
            (
                reason,
                self.dropped.iter().filter(|d| d.reason == reason).count(),
            )
        })
    }
}
