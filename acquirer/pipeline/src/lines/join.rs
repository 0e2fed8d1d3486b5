//! Pieces of one line joined across the crossings that broke it.
//!
//! Where a slanted line of the other family crosses, the ridge drifts aside for a few pixels and the track may
//! end there and begin anew. Two pieces are joined when the straight prolongations of both, taken from
//! points a little away from their ends, agree in the middle of the gap.

use super::{Track, tracks::Followed};
use crate::spare::Spare;

/// Points that a prolongation is fitted to.
const POINTS: usize = 16;
/// Fewest of them.
const FEWEST: usize = 4;
/// Largest difference of the two pieces' slopes, across per pixel along.
const SLOPE_DIFFERENCE: f64 = 0.35;

/// How far apart what belongs together may be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// Longest gap along a line, in camera pixels.
    pub(super) gap_px: f64,
    /// What is not trusted at an end, in camera pixels along.
    pub(super) disturbed_px: f64,
    /// Largest miss sideways, in camera pixels.
    pub(super) gate_px: f64,
}

/// What joining keeps between frames.
#[derive(Debug, Default)]
pub(super) struct JoinBuffers {
    heads: Vec<Option<Prolongation>>,
    tails: Vec<Option<Prolongation>>,
    /// Pieces that fit together, the first and the second one's number, with how badly they do.
    pairs: Vec<(f64, usize, usize)>,
    next: Vec<Option<usize>>,
    has_previous: Vec<bool>,
}

/// Joins pieces whose gap is within reach, or that overlap by as much, where their prolongations agree.
pub(super) fn join(
    pieces: &Followed,
    reach: &Reach,
    buffers: &mut JoinBuffers,
    (tracks, spare): (&mut Vec<Track>, &mut Spare<Track>),
) {
    let spacing_px = pieces.tracks().next().map_or(1.0, |track| track.spacing_px);
    let skip = (reach.disturbed_px.max(0.0) / spacing_px) as usize;
    buffers.heads.clear();
    let heads = pieces.tracks().map(|t| Prolongation::head(t, skip));
    buffers.heads.extend(heads);
    buffers.tails.clear();
    let tails = pieces.tracks().map(|t| Prolongation::tail(t, skip));
    buffers.tails.extend(tails);
    buffers.find_pairs(pieces, reach, spacing_px);
    buffers.next.clear();
    buffers.next.resize(pieces.len(), None);
    buffers.has_previous.clear();
    buffers.has_previous.resize(pieces.len(), false);
    for &(_, a, b) in &buffers.pairs {
        if buffers.next[a].is_none() && !buffers.has_previous[b] {
            buffers.next[a] = Some(b);
            buffers.has_previous[b] = true;
        }
    }
    let firsts = (0..pieces.len()).filter(|&k| !buffers.has_previous[k]);
    spare.resize(tracks, firsts.clone().count());
    for (track, first) in tracks.iter_mut().zip(firsts) {
        track.copy_from(pieces.track(first));
        let mut at = first;
        while let Some(after) = buffers.next[at] {
            append(track, pieces.track(after), skip);
            at = after;
        }
    }
}

impl JoinBuffers {
    fn find_pairs(&mut self, pieces: &Followed, reach: &Reach, spacing_px: f64) {
        let gap = reach.gap_px / spacing_px;
        self.pairs.clear();
        for (a, (before, tail)) in pieces.tracks().zip(&self.tails).enumerate() {
            for (b, (after, head)) in pieces.tracks().zip(&self.heads).enumerate() {
                let (Some(tail), Some(head)) = (tail, head) else {
                    continue;
                };
                let between = after.start as f64 - before.end() as f64;
                // each must go on where the other is not
                let ordered = before.start < after.start && before.end() < after.end();
                if a == b || !ordered || between.abs() > gap {
                    continue;
                }
                let middle = 0.5 * (after.start + before.end()) as f64;
                let miss = (tail.at(middle) - head.at(middle)).abs();
                let bend = (tail.slope - head.slope).abs() / spacing_px;
                if miss <= reach.gate_px && bend <= SLOPE_DIFFERENCE {
                    let cost = miss + 0.02 * spacing_px * between.abs();
                    self.pairs.push((cost, a, b));
                }
            }
        }
        self.pairs
            .sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
    }
}

/// Appends `b` to `a`; the untrusted points of both ends are replaced by a straight bridge.
fn append(a: &mut Track, b: &Track, skip: usize) {
    let keep_a = a.across.len().saturating_sub(skip).max(1);
    let drop_b = skip.min(b.across.len() - 1);
    // pieces may overlap: what is kept of b begins after what is kept of a
    let begin = (b.start + drop_b).max(a.start + keep_a).min(b.end() - 1);
    let keep_a = keep_a.min((begin - a.start).max(1));
    a.across.truncate(keep_a);
    a.strength.truncate(keep_a);
    let (from, to) = (a.across[keep_a - 1], b.across[begin - b.start]);
    let steps = begin + 1 - (a.start + keep_a);
    for k in 1..steps {
        a.across.push(from + (to - from) * k as f32 / steps as f32);
        a.strength.push(0.0);
    }
    a.across.extend_from_slice(&b.across[begin - b.start..]);
    a.strength.extend_from_slice(&b.strength[begin - b.start..]);
}

/// A straight line through points near an end of a track.
#[derive(Debug)]
struct Prolongation {
    along: f64,
    across: f64,
    slope: f64,
}

impl Prolongation {
    fn head(track: &Track, skip: usize) -> Option<Self> {
        let skip = skip.min(track.across.len() / 3);
        let measured = (skip..track.across.len()).filter(|&k| track.strength[k] > 0.0);
        Self::fit(track, measured)
    }

    fn tail(track: &Track, skip: usize) -> Option<Self> {
        let skip = skip.min(track.across.len() / 3);
        let measured = (0..track.across.len() - skip)
            .rev()
            .filter(|&k| track.strength[k] > 0.0);
        Self::fit(track, measured)
    }

    /// Through the first [`POINTS`] of the chosen samples.
    fn fit(track: &Track, chosen: impl Iterator<Item = usize>) -> Option<Self> {
        let mut points = [(0.0, 0.0); POINTS];
        let mut count = 0;
        for (point, k) in points.iter_mut().zip(chosen) {
            *point = ((track.start + k) as f64, f64::from(track.across[k]));
            count += 1;
        }
        if count < FEWEST {
            return None;
        }
        let points = &points[..count];
        let n = points.len() as f64;
        let (t, x) = points
            .iter()
            .fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
        let (top, bottom) = points.iter().fold((0.0, 0.0), |s, p| {
            (s.0 + (p.0 - t) * (p.1 - x), s.1 + (p.0 - t) * (p.0 - t))
        });
        Some(Self {
            along: t,
            across: x,
            slope: top / bottom,
        })
    }

    fn at(&self, along: f64) -> f64 {
        self.across + self.slope * (along - self.along)
    }
}
