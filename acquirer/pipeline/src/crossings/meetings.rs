//! Which lines meet, roughly where, and in which order along each line.

use rayon::prelude::*;
use shared::{geometry::CameraPixel, pattern::Axis};

use super::{Arms, Crossing, Crossings};
use crate::{
    lines::{Lines, Track},
    spare::Spare,
};

/// How far lines are prolonged to meet another, in pixels beyond the other line's half width.
const PROLONG_PX: f64 = 3.0;

/// What finding meetings keeps between frames.
#[derive(Debug, Default)]
pub(super) struct MeetingBuffers {
    row_spans: Vec<(f32, f32)>,
    /// For each column its meetings.
    met: Vec<Vec<Crossing>>,
    double: Vec<bool>,
    /// Of [`Crossings::on_rows`] and [`Crossings::on_columns`].
    spare: [Spare<Vec<usize>>; 2],
}

/// Finds the rough intersections of all tracks.
pub(super) fn meetings(lines: &Lines, buffers: &mut MeetingBuffers, all: &mut Vec<Crossing>) {
    let beyond = [
        0.5 * lines.columns.width_px + PROLONG_PX,
        0.5 * lines.rows.width_px + PROLONG_PX,
    ];
    let margin = beyond[0].max(beyond[1]) as f32;
    let MeetingBuffers { row_spans, met, .. } = buffers;
    row_spans.clear();
    row_spans.extend(lines.rows.tracks.iter().map(Track::span));
    let columns = lines.columns.tracks.len();
    met.resize_with(met.len().max(columns), Vec::new);
    let columns = met.par_iter_mut().zip(&lines.columns.tracks).enumerate();
    columns.for_each(|(c, (met, column))| {
        let span = column.span();
        met.clear();
        met.reserve(row_spans.len());
        for (r, row) in lines.rows.tracks.iter().enumerate() {
            if apart((column, span), (row, row_spans[r]), margin) {
                continue;
            }
            if let Some(centre) = meet(column, row, beyond) {
                met.push(rough(centre, r, c));
            }
        }
    });
    all.clear();
    let met = met.iter().take(lines.columns.tracks.len());
    met.for_each(|met| all.extend_from_slice(met));
}

fn rough(centre: CameraPixel, row: usize, column: usize) -> Crossing {
    let arms = |track| Arms {
        track,
        ..Arms::default()
    };
    Crossing {
        centre,
        row: arms(row),
        column: arms(column),
    }
}

/// Whether the rectangles around two tracks keep more than `margin` pixels between them.
fn apart((column, x): (&Track, (f32, f32)), (row, y): (&Track, (f32, f32)), margin: f32) -> bool {
    let beyond = |span: (f32, f32), (from, to): (f64, f64)| {
        span.1 < from as f32 - margin || span.0 > to as f32 + margin
    };
    beyond(x, row.stretch_px()) || beyond(y, column.stretch_px())
}

/// Where two tracks meet, by going from one to the other in turn.
fn meet(column: &Track, row: &Track, [row_beyond, column_beyond]: [f64; 2]) -> Option<CameraPixel> {
    const ROUNDS: usize = 20;
    const SETTLED_PX: f64 = 0.02;
    let clamp =
        |v: f64, track: &Track| v.clamp(track.along(0), track.along(track.across.len() - 1));
    let middle_x = clamp(f64::from(column.across[column.across.len() / 2]), row);
    let mut y = clamp(row.at(middle_x, row_beyond)?, column);
    for _ in 0..ROUNDS {
        let x = column.at(y, column_beyond)?;
        let on_row = row.at(clamp(x, row), row_beyond)?;
        let next = clamp(on_row, column);
        if (next - y).abs() < SETTLED_PX {
            let x = column.at(next, column_beyond)?;
            let y = row.at(x, row_beyond)?;
            let x = column.at(y, column_beyond)?;
            return Some(CameraPixel::new(x, y));
        }
        y = 0.5 * (y + next); // halves the step so that steep pairs settle too
    }
    None
}

/// Sorts the crossings along each track and leaves out all but one of those that coincide.
pub(super) fn order(crossings: &mut Crossings, lines: &Lines, buffers: &mut MeetingBuffers) {
    const SAME_PX: f64 = 2.0;
    let MeetingBuffers { double, spare, .. } = buffers;
    for axis in Axis::BOTH {
        sort(crossings, lines, axis, spare);
        double.clear();
        double.resize(crossings.all.len(), false);
        let length = |k: usize| {
            let other = axis.other();
            let track = crossings.all[k].arms(other).track;
            lines.family(other).tracks[track].across.len()
        };
        for track in crossings.on(axis) {
            for pair in track.windows(2) {
                let (a, b) = (pair[0], pair[1]);
                let distance = crossings.all[b].along(axis) - crossings.all[a].along(axis);
                if distance < SAME_PX {
                    double[if length(a) < length(b) { a } else { b }] = true;
                }
            }
        }
        let mut at = 0;
        crossings.all.retain(|_| {
            at += 1;
            !double[at - 1]
        });
    }
    for axis in Axis::BOTH {
        sort(crossings, lines, axis, spare);
    }
}

/// Notes the crossings along each track of one direction.
fn sort(
    crossings: &mut Crossings,
    lines: &Lines,
    axis: Axis,
    [spare_rows, spare_columns]: &mut [Spare<Vec<usize>>; 2],
) {
    let all = &crossings.all;
    let (on, spare) = match axis {
        Axis::Row => (&mut crossings.on_rows, spare_rows),
        Axis::Column => (&mut crossings.on_columns, spare_columns),
    };
    spare.resize(on, lines.family(axis).tracks.len());
    let most = lines.family(axis.other()).tracks.len();
    for track in &mut *on {
        track.clear();
        track.reserve(most); // it may have been a shorter line in the frame before
    }
    for (k, crossing) in all.iter().enumerate() {
        on[crossing.arms(axis).track].push(k);
    }
    for track in on {
        track.sort_unstable_by(|&a, &b| {
            let along = |k: usize| all[k].along(axis);
            along(a).total_cmp(&along(b)).then(a.cmp(&b))
        });
    }
}
