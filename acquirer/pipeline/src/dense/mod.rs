//! Every point of every decoded line, as unbroken pieces.
//!
//! Takes a decoded grid, gives [`DenseLine`]s: points on the middle of one line, one per camera pixel along it, in
//! edge coordinates of the camera picture. Between two decoded crossings the track's own points are taken; beyond
//! the last one the track goes on to carry the number as long as it is unbroken and nothing contradicts (`ends`). Where the other family crosses, and in gaps of a few pixels, a parabola through both arms
//! fills in when both follow it; else the line is cut there (`pieces`). Pieces are never joined by anybody after
//! this: a cut is where the surface may step. A surface that steps along the line, without a sideways step of the
//! line itself, is not cut, quietly: its depth is that of a line along the epipolar direction, which has none.

mod ends;
mod pieces;
mod scale;

pub use scale::measured_scale;
use shared::{geometry::CameraPixel, pattern::Axis};

use super::grid::{DecodedGrid, LinePoint, LineTrack};

/// An unbroken piece of one line of the pattern.
#[derive(Debug, Clone, PartialEq)]
pub struct DenseLine {
    /// Rows are horizontal lines of the pattern, columns vertical ones.
    pub axis: Axis,
    /// Which line of the pattern, from 0.
    pub line: u16,
    /// Points on its middle, one per camera pixel along it, in order; sideways noise is averaged over seven.
    pub points: Vec<LinePoint>,
}

/// Points on either side that a point's position across is averaged over, at most.
const SMOOTH_REACH: usize = 3;

/// All unbroken pieces of the decoded lines, in the order of the tracks.
#[must_use]
pub fn find_dense_lines(grid: &DecodedGrid) -> Vec<DenseLine> {
    let labelled: Vec<Stretch> = grid
        .tracks
        .iter()
        .flat_map(|track| match track.line {
            Some(line) => vec![Stretch::of(track, line)],
            None => ends::label_ends(track, grid),
        })
        .collect();
    pieces::unbroken(labelled, grid)
        .into_iter()
        .map(Stretch::smoothed)
        .collect()
}

/// A piece of a line in coordinates along and across the picture's direction that it was followed in.
#[derive(Debug, Clone)]
struct Stretch {
    axis: Axis,
    line: u16,
    way: Way,
    samples: Vec<Sample>,
}

/// One point of a stretch.
#[derive(Debug, Clone, Copy)]
struct Sample {
    along: f64,
    across: f64,
    half_width_px: f64,
    confidence: f64,
}

/// The direction of the picture that a line was followed in, one pixel after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    Flat,
    Steep,
}

impl Way {
    /// Tracks have one point per pixel row or column, in its middle.
    fn of(track: &LineTrack) -> Self {
        let in_middle = |of: fn(&CameraPixel) -> f64| {
            let points = track.points.iter();
            points.filter(|p| of(&p.position).fract() == 0.5).count()
        };
        if in_middle(|p| p.x) >= in_middle(|p| p.y) {
            Self::Flat
        } else {
            Self::Steep
        }
    }

    /// Along and across.
    fn turn(self, at: CameraPixel) -> (f64, f64) {
        match self {
            Self::Flat => (at.x, at.y),
            Self::Steep => (at.y, at.x),
        }
    }

    fn turn_back(self, (along, across): (f64, f64)) -> CameraPixel {
        match self {
            Self::Flat => CameraPixel::new(along, across),
            Self::Steep => CameraPixel::new(across, along),
        }
    }
}

impl Stretch {
    fn of(track: &LineTrack, line: u16) -> Self {
        let way = Way::of(track);
        Self {
            axis: track.axis,
            line,
            way,
            samples: track.points.iter().map(|p| Sample::of(p, way)).collect(),
        }
    }

    /// The finished line: each point's position across averaged with its neighbours on both sides, the same
    /// number of them, so that the mean stays at the point.
    fn smoothed(self) -> DenseLine {
        let samples = &self.samples;
        let point = |k: usize| {
            let reach = SMOOTH_REACH.min(k).min(samples.len() - 1 - k);
            let near = &samples[k - reach..=k + reach];
            let across = near.iter().map(|s| s.across).sum::<f64>() / near.len() as f64;
            LinePoint {
                position: self.way.turn_back((samples[k].along, across)),
                half_width_px: samples[k].half_width_px,
                confidence: samples[k].confidence,
            }
        };
        DenseLine {
            axis: self.axis,
            line: self.line,
            points: (0..samples.len()).map(point).collect(),
        }
    }
}

impl Sample {
    fn of(point: &LinePoint, way: Way) -> Self {
        let (along, across) = way.turn(point.position);
        Self {
            along,
            across,
            half_width_px: point.half_width_px,
            confidence: point.confidence,
        }
    }
}

#[cfg(test)]
mod tests;
