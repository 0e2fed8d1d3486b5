//! The ends of lines: a followed line beyond its last labelled crossing.
//!
//! Takes a stretch that decoding left without a number, gives the parts of it that go on, unbroken, from a
//! labelled crossing, for at most one pitch. A stretch between crossings of different lines gets none, nor
//! does what lies near a crossing that was found and whose own colours or place contradict.

use shared::pattern::{Axis, GridIndex};

use super::{Sample, Stretch, Way, line_of};
use crate::grid::{DecodedCrossing, DecodedGrid, DropReason, LineTrack};

/// A crossing lies on a line when it is at most this far beside it, camera px: tracks drift by a pixel in crossings.
const BESIDE_PX: f64 = 1.5;

/// ... and when the line begins at most so far beyond the other line's edge, camera px.
const BEYOND_PX: f64 = 4.0;

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
    reach: f64,
    zone: f64,
}

/// The parts of an unlabelled stretch that crossings at their ends, or on them, give a number to.
pub(super) fn label_ends(track: &LineTrack, grid: &DecodedGrid) -> Vec<Stretch> {
    let way = Way::of(track);
    let samples: Vec<Sample> = track.points.iter().map(|p| Sample::of(p, way)).collect();
    let seeds = find_seeds(&samples, way, track.axis, grid);
    let Some(line) = seeds
        .first()
        .map(|seed| line_of(seed.crossing.index, track.axis))
    else {
        return Vec::new();
    };
    if seeds
        .iter()
        .any(|seed| line_of(seed.crossing.index, track.axis) != line)
    {
        return Vec::new();
    }
    let stops = contradictions(&samples, way, grid);
    let mut confidence = vec![0.0f64; samples.len()];
    for seed in &seeds {
        let start = samples.partition_point(|s| s.along < seed.along);
        let sure = LESS_SURE * seed.crossing.confidence;
        for k in reached(&samples, (start..samples.len()).collect(), seed, &stops).chain(reached(
            &samples,
            (0..start).rev().collect(),
            seed,
            &stops,
        )) {
            confidence[k] = confidence[k].max(sure);
        }
    }
    parts(&samples, &confidence)
        .map(|samples| Stretch {
            axis: track.axis,
            line,
            way,
            samples,
        })
        .collect()
}

/// The labelled crossings that lie on the stretch or at its ends.
fn find_seeds<'a>(
    samples: &[Sample],
    way: Way,
    axis: Axis,
    grid: &'a DecodedGrid,
) -> Vec<Seed<'a>> {
    let seed = |crossing: &'a DecodedCrossing| {
        let (along, across) = way.turn(crossing.centre);
        let zone = half_width_along(crossing, way) + BEYOND_PX;
        let line = across_at(samples, along, zone)?;
        let slope = slope_at(samples, along);
        let beside = (across - line).abs() / slope.hypot(1.0);
        (beside <= BESIDE_PX).then(|| Seed {
            crossing,
            along,
            reach: pitch_at(crossing, axis, grid) / slope.hypot(1.0),
            zone,
        })
    };
    grid.crossings.iter().filter_map(seed).collect()
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
        gap <= open
            && step <= STEP_PX * gap.max(1.0)
            && (here.along - seed.along).abs() <= seed.reach
            && !stopped
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

/// Runs of samples with a confidence, which they take on.
fn parts<'a>(
    samples: &'a [Sample],
    confidence: &'a [f64],
) -> impl Iterator<Item = Vec<Sample>> + 'a {
    let sure: Vec<Sample> = samples
        .iter()
        .zip(confidence)
        .map(|(&sample, &confidence)| Sample {
            confidence,
            ..sample
        })
        .collect();
    let runs: Vec<Vec<Sample>> = sure
        .chunk_by(|a, b| (a.confidence > 0.0) == (b.confidence > 0.0))
        .filter(|run| run[0].confidence > 0.0)
        .map(<[Sample]>::to_vec)
        .collect();
    runs.into_iter()
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

/// Half of a crossing's extent along a direction of the picture.
pub(super) fn half_width_along(crossing: &DecodedCrossing, way: Way) -> f64 {
    let along = crossing.vertices.map(|vertex| way.turn(vertex).0);
    let low = along.iter().copied().fold(f64::MAX, f64::min);
    let high = along.iter().copied().fold(f64::MIN, f64::max);
    0.5 * (high - low)
}

/// Distance from a crossing to the next one on its line, camera px: the larger of those beside it, else the
/// median of all.
fn pitch_at(crossing: &DecodedCrossing, axis: Axis, grid: &DecodedGrid) -> f64 {
    let to = |other: &DecodedCrossing| {
        (other.centre.x - crossing.centre.x).hypot(other.centre.y - crossing.centre.y)
    };
    [1, -1]
        .into_iter()
        .filter_map(|step| grid.crossing(beside(crossing.index, axis, step)?))
        .map(to)
        .reduce(f64::max)
        .unwrap_or(0.0)
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
