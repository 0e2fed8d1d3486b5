//! Where the lines of both families cross, to a few hundredths of a pixel.
//!
//! Takes the tracks, gives each crossing of a column and a row with its arms: the four stretches of line
//! around it, without the crossing's own zone, where the two profiles disturb each other. The crossing is
//! the intersection of two local fits (straight, or a parabola where the data ask for it) to the arms'
//! points. It counts as whole when all four arms were really seen. Where a line bends sharply at the crossing
//! (a fold of the surface) the fits round the corner off quietly.

mod arms;
mod fit;
mod meetings;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use shared::{geometry::CameraPixel, pattern::Axis};

use super::lines::Lines;
use arms::{median_gap, set_arms};
use fit::fit;
use meetings::{MeetingBuffers, meetings, order};

/// How crossings are found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CrossingSettings {
    /// Ends of the arms, as a share of the way to the next crossing, 0.2 to 1.
    pub reach: f64,
    /// Left out beside the other line's edge, in camera pixels, 0 to 10.
    pub margin_px: f64,
    /// Share of an arm's pixels that must have been seen for the arm to count, 0 to 1.
    pub seen_share: f64,
    /// Largest step between the two arms of one line where they meet, in camera pixels, 0.1 to 5: more is
    /// an edge in depth, not one line. Noise is allowed for.
    pub largest_step_px: f64,
    /// Smallest angle between the two lines, in degrees, 5 to 80.
    pub least_angle_deg: f64,
}

impl Default for CrossingSettings {
    fn default() -> Self {
        Self {
            reach: 0.5,
            margin_px: 1.5,
            seen_share: 0.5,
            largest_step_px: 0.6,
            least_angle_deg: 25.0,
        }
    }
}

/// Two arms of one line at a crossing: before and after it along the line.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Arms {
    /// Index of the line's track in its family.
    pub track: usize,
    /// Pixels left out around the crossing, along the line.
    pub inner_px: f64,
    /// Ends of the arms along the line, in pixels from the crossing.
    pub outer_px: [f64; 2],
    /// Which arms were seen.
    pub seen: [bool; 2],
    /// Whether one arm goes on where the other ends.
    pub continuous: bool,
    /// Across per pixel along, at the crossing.
    pub slope: f64,
}

/// A column and a row that cross.
#[derive(Debug, Clone, PartialEq)]
pub struct Crossing {
    /// Where their middles meet.
    pub centre: CameraPixel,
    /// The flat line's arms (left, right).
    pub row: Arms,
    /// The steep line's arms (above, below).
    pub column: Arms,
}

impl Crossing {
    /// The arms of one line.
    #[must_use]
    pub fn arms(&self, axis: Axis) -> &Arms {
        match axis {
            Axis::Row => &self.row,
            Axis::Column => &self.column,
        }
    }

    /// Position along a line of this direction.
    #[must_use]
    pub fn along(&self, axis: Axis) -> f64 {
        match axis {
            Axis::Row => self.centre.x,
            Axis::Column => self.centre.y,
        }
    }

    /// Whether all four arms were seen and each line goes on through the crossing.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        let whole = |arms: &Arms| arms.seen == [true; 2] && arms.continuous;
        whole(&self.row) && whole(&self.column)
    }
}

/// All crossings, and their order along each line.
#[derive(Debug, Clone, Default)]
pub struct Crossings {
    /// The crossings, column track by column track, downwards.
    pub all: Vec<Crossing>,
    /// For each flat track its crossings from left to right.
    pub on_rows: Vec<Vec<usize>>,
    /// For each steep track its crossings from top to bottom.
    pub on_columns: Vec<Vec<usize>>,
    /// The middle of all gaps between neighbours along flat and along steep lines, in camera pixels; 0 when there are
    /// none.
    pub gaps_px: [f64; 2],
}

impl Crossings {
    /// The crossings along each track of one direction.
    #[must_use]
    pub fn on(&self, axis: Axis) -> &[Vec<usize>] {
        match axis {
            Axis::Row => &self.on_rows,
            Axis::Column => &self.on_columns,
        }
    }

    /// The middle of all gaps between neighbours along the lines of one direction, in camera pixels; 0 when there are
    /// none.
    #[must_use]
    pub fn gap_px(&self, along: Axis) -> f64 {
        match along {
            Axis::Row => self.gaps_px[0],
            Axis::Column => self.gaps_px[1],
        }
    }

    fn measure_gaps(&mut self, gaps: &mut Vec<f64>) {
        self.gaps_px = Axis::BOTH.map(|along| median_gap(self, along, gaps));
    }
}

/// What finding crossings keeps between frames.
#[derive(Debug, Default)]
pub struct CrossingBuffers {
    meetings: MeetingBuffers,
    gaps: Vec<f64>,
    fitted: Vec<Option<Crossing>>,
}

/// Finds the crossings of the lines.
pub fn find_crossings(
    lines: &Lines,
    settings: &CrossingSettings,
    (buffers, crossings): (&mut CrossingBuffers, &mut Crossings),
) {
    let CrossingBuffers {
        meetings: found,
        gaps,
        fitted,
    } = buffers;
    meetings(lines, found, &mut crossings.all);
    order(crossings, lines, found);
    crossings.measure_gaps(gaps);
    set_arms(crossings, lines, settings);
    let least_sine = settings.least_angle_deg.to_radians().sin();
    let refined = crossings.all.par_iter();
    refined
        .map(|crossing| fit(crossing, lines, settings, least_sine))
        .collect_into_vec(fitted);
    crossings.all.clear();
    crossings.all.extend(fitted.drain(..).flatten());
    order(crossings, lines, found);
    crossings.measure_gaps(gaps);
}
