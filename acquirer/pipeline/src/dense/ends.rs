//! The ends of lines: a followed line beyond its last labelled crossing.
//!
//! Takes a stretch that decoding left without a number, gives the parts of it that go on, unbroken, from a
//! labelled crossing: up to a gap, a step, or a crossing that was found and whose own colours or place contradict.
//! What crossings of different lines reach gets no number. A line that goes over into another one without a gap or
//! a step keeps its number quietly as far as that one has no crossing.

use shared::pattern::{Axis, GridIndex};

use super::{Sample, Stretch, Way};
use crate::grid::{DecodedCrossing, DecodedGrid, DropReason, LineTrack};

/// A crossing lies on a line when it is at most this far beside it, camera px: tracks drift by a pixel in crossings.
const BESIDE_PX: f64 = 1.5;

/// What blur disturbs of a line beyond the edge of one that crosses, camera px.
const BEYOND_PX: f64 = 4.0;

/// Where a line is followed it is dark beside it, up to so many of its widths beyond its edges.
const BESIDE_WIDTHS: f64 = 0.8;

/// Longest gap on the way, camera px: what the follower bridges outside of crossings is doubtful for a number.
const GAP_PX: f64 = 4.0;

/// Largest sideways step from point to point, camera px per pixel along, beyond the 45 degrees that lines have.
const STEP_PX: f64 = 1.5;

/// How much less the number is believed than that of the crossing it comes from.
const LESS_SURE: f64 = 0.9;

/// A crossing on the stretch that gives it its number.
struct Seed<'a> {
    crossing: &'a DecodedCrossing,
    along: f64,
    zone: f64,
}

/// The parts of an unlabelled stretch that crossings at their ends, or on them, give a number to.
pub(super) fn label_ends(track: &LineTrack, grid: &DecodedGrid) -> Vec<Stretch> {
    let way = Way::of(track);
    let samples: Vec<Sample> = track.points.iter().map(|p| Sample::of(p, way)).collect();
    let stops = contradictions(&samples, way, grid);
    let mut numbers = vec![Number::Open; samples.len()];
    for seed in find_seeds(&samples, (track.axis, way), grid) {
        let start = samples.partition_point(|s| s.along < seed.along);
        let line = seed.crossing.index.line(track.axis);
        let sure = LESS_SURE * seed.crossing.confidence;
        for k in reached(&samples, (start..samples.len()).collect(), &seed, &stops).chain(reached(
            &samples,
            (0..start).rev().collect(),
            &seed,
            &stops,
        )) {
            numbers[k] = numbers[k].and(line, sure);
        }
    }
    parts(&samples, &numbers)
        .map(|(line, samples)| Stretch {
            axis: track.axis,
            line,
            way,
            samples,
        })
        .collect()
}

/// What the crossings that reach a sample say about its line.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Number {
    /// Nothing.
    Open,
    /// It is this line, with this confidence.
    Line(u16, f64),
    /// Different things.
    Contested,
}

impl Number {
    fn and(self, line: u16, sure: f64) -> Self {
        match self {
            Self::Open => Self::Line(line, sure),
            Self::Line(same, before) if same == line => Self::Line(line, sure.max(before)),
            Self::Line(..) | Self::Contested => Self::Contested,
        }
    }

    fn line(self) -> Option<u16> {
        match self {
            Self::Line(line, _) => Some(line),
            Self::Open | Self::Contested => None,
        }
    }
}

/// The labelled crossings that lie on the stretch or at its ends.
fn find_seeds<'a>(
    samples: &[Sample],
    (axis, way): (Axis, Way),
    grid: &'a DecodedGrid,
) -> Vec<Seed<'a>> {
    let seed = |crossing: &'a DecodedCrossing| {
        let (along, across) = way.turn(crossing.centre);
        let zone = disturbed_px(crossing, axis, way);
        let line = across_at(samples, along, zone)?;
        let slope = slope_at(samples, along);
        let beside = (across - line).abs() / slope.hypot(1.0);
        (beside <= BESIDE_PX).then_some(Seed {
            crossing,
            along,
            zone,
        })
    };
    grid.placed().filter_map(seed).collect()
}

/// The samples in walking order as far as nothing breaks the way from the crossing.
fn reached(
    samples: &[Sample],
    order: Vec<usize>,
    seed: &Seed<'_>,
    stops: &[f64],
) -> impl Iterator<Item = usize> {
    let side = |along: f64| along < seed.along;
    let mut last: Option<Sample> = None;
    let walked = order.into_iter().take_while(move |&k| {
        let here = samples[k];
        let gap = (here.along - last.map_or(seed.along, |l| l.along)).abs();
        let open = if last.is_none() { seed.zone } else { GAP_PX };
        let step = last.map_or(0.0, |l| (here.across - l.across).abs());
        let stopped = stops.iter().any(|&stop| {
            side(stop) == side(here.along)
                && (stop - seed.along).abs() <= (here.along - seed.along).abs()
        });
        last = Some(here);
        gap <= open && step <= STEP_PX * gap.max(1.0) && !stopped
    });
    walked.collect::<Vec<_>>().into_iter()
}

/// Places along the stretch of crossings on it that were dropped because something contradicts.
fn contradictions(samples: &[Sample], way: Way, grid: &DecodedGrid) -> Vec<f64> {
    let contradicts = |reason| {
        matches!(
            reason,
            DropReason::AmbiguousColour | DropReason::NotInCode | DropReason::OffEpipolarLine
        )
    };
    let dropped = grid.dropped.iter().filter(|d| contradicts(d.reason));
    dropped
        .filter_map(|d| {
            let (along, across) = way.turn(d.centre);
            let line = across_at(samples, along, BEYOND_PX)?;
            ((across - line).abs() <= 2.0 * BESIDE_PX).then_some(along)
        })
        .collect()
}

/// Runs of samples of one line, with the confidence that it has at each.
fn parts<'a>(
    samples: &'a [Sample],
    numbers: &'a [Number],
) -> impl Iterator<Item = (u16, Vec<Sample>)> + 'a {
    let both: Vec<(Sample, Number)> = samples
        .iter()
        .copied()
        .zip(numbers.iter().copied())
        .collect();
    let runs = both.chunk_by(|a, b| a.1.line() == b.1.line());
    let runs = runs.filter_map(|run| {
        let known = run.iter().filter_map(|&(sample, number)| match number {
            Number::Line(_, confidence) => Some(Sample {
                confidence,
                ..sample
            }),
            Number::Open | Number::Contested => None,
        });
        Some((run[0].1.line()?, known.collect()))
    });
    runs.collect::<Vec<_>>().into_iter()
}

/// Position across at a place along, linear between samples and constant slope up to `beyond` past the ends.
fn across_at(samples: &[Sample], along: f64, beyond: f64) -> Option<f64> {
    let (first, last) = (samples.first()?, samples.last()?);
    if along < first.along - beyond || along > last.along + beyond {
        return None;
    }
    if along <= first.along || along >= last.along {
        let end = if along <= first.along { first } else { last };
        return Some(end.across + slope_at(samples, along) * (along - end.along));
    }
    let next = samples.partition_point(|s| s.along < along);
    let (a, b) = (samples[next - 1], samples[next]);
    let share = (along - a.along) / (b.along - a.along).max(1e-9);
    Some(a.across + share * (b.across - a.across))
}

/// Across per pixel along, from up to ten samples on either side.
fn slope_at(samples: &[Sample], along: f64) -> f64 {
    const REACH: usize = 10;
    let middle = samples.partition_point(|s| s.along < along);
    let low = samples[middle.saturating_sub(REACH).min(samples.len() - 1)];
    let high = samples[(middle + REACH).min(samples.len() - 1)];
    (high.across - low.across) / (high.along - low.along).max(1.0)
}

/// How far from its middle a crossing disturbs a line of the given direction: half its extent, what blur disturbs,
/// and what a leaning line that crosses takes from the sides of this one before they meet.
pub(super) fn disturbed_px(crossing: &DecodedCrossing, axis: Axis, way: Way) -> f64 {
    let along = crossing.vertices.map(|vertex| way.turn(vertex).0);
    let low = along.iter().copied().fold(f64::MAX, f64::min);
    let high = along.iter().copied().fold(f64::MIN, f64::max);
    let [upper_left, upper_right, _, lower_left] = along;
    let lean = match axis {
        Axis::Row => lower_left - upper_left,
        Axis::Column => upper_right - upper_left,
    };
    0.5 * (high - low) + BEYOND_PX + BESIDE_WIDTHS * lean.abs()
}

/// The next crossing on a line.
pub(super) fn beside(index: GridIndex, axis: Axis, step: i16) -> Option<GridIndex> {
    Some(match axis {
        Axis::Row => GridIndex {
            column: index.column.checked_add_signed(step)?,
            ..index
        },
        Axis::Column => GridIndex {
            row: index.row.checked_add_signed(step)?,
            ..index
        },
    })
}
