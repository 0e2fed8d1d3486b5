//! Pieces of one line joined across the crossings that broke it.
//!
//! Where a slanted line of the other family crosses, the ridge drifts aside for a few pixels and the track may
//! end there and begin anew. Two pieces are joined when the straight prolongations of both, taken from
//! points a little away from their ends, agree in the middle of the gap.

use super::Track;

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

/// Joins pieces whose gap is within reach, or that overlap by as much, where their prolongations agree.
pub(super) fn join(tracks: &[Track], reach: &Reach) -> Vec<Track> {
    let spacing_px = tracks.first().map_or(1.0, |track| track.spacing_px);
    let skip = (reach.disturbed_px.max(0.0) / spacing_px) as usize;
    let gap = reach.gap_px / spacing_px;
    let heads: Vec<Option<Prolongation>> =
        tracks.iter().map(|t| Prolongation::head(t, skip)).collect();
    let tails: Vec<Option<Prolongation>> =
        tracks.iter().map(|t| Prolongation::tail(t, skip)).collect();
    let mut pairs = Vec::new();
    for (a, tail) in tails.iter().enumerate() {
        for (b, head) in heads.iter().enumerate() {
            let (Some(tail), Some(head)) = (tail, head) else {
                continue;
            };
            let between = tracks[b].start as f64 - tracks[a].end() as f64;
            // each must go on where the other is not
            let ordered = tracks[a].start < tracks[b].start && tracks[a].end() < tracks[b].end();
            if a == b || !ordered || between.abs() > gap {
                continue;
            }
            let middle = 0.5 * (tracks[b].start + tracks[a].end()) as f64;
            let miss = (tail.at(middle) - head.at(middle)).abs();
            let bend = (tail.slope - head.slope).abs() / spacing_px;
            if miss <= reach.gate_px && bend <= SLOPE_DIFFERENCE {
                pairs.push((miss + 0.02 * spacing_px * between.abs(), a, b));
            }
        }
    }
    pairs.sort_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
    let mut next = vec![None; tracks.len()];
    let mut has_previous = vec![false; tracks.len()];
    for (_, a, b) in pairs {
        if next[a].is_none() && !has_previous[b] {
            next[a] = Some(b);
            has_previous[b] = true;
        }
    }
    chains(tracks, &next, &has_previous, skip)
}

fn chains(
    tracks: &[Track],
    next: &[Option<usize>],
    has_previous: &[bool],
    skip: usize,
) -> Vec<Track> {
    let mut joined = Vec::new();
    for first in (0..tracks.len()).filter(|&k| !has_previous[k]) {
        let mut track = tracks[first].clone();
        let mut at = first;
        while let Some(after) = next[at] {
            append(&mut track, &tracks[after], skip);
            at = after;
        }
        joined.push(track);
    }
    joined
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
    a.across.extend(&b.across[begin - b.start..]);
    a.strength.extend(&b.strength[begin - b.start..]);
}

/// A straight line through points near an end of a track.
struct Prolongation {
    along: f64,
    across: f64,
    slope: f64,
}

impl Prolongation {
    fn head(track: &Track, skip: usize) -> Option<Self> {
        let skip = skip.min(track.across.len() / 3);
        let measured = (skip..track.across.len()).filter(|&k| track.strength[k] > 0.0);
        Self::fit(track, measured.take(POINTS))
    }

    fn tail(track: &Track, skip: usize) -> Option<Self> {
        let skip = skip.min(track.across.len() / 3);
        let measured = (0..track.across.len() - skip)
            .rev()
            .filter(|&k| track.strength[k] > 0.0);
        Self::fit(track, measured.take(POINTS))
    }

    fn fit(track: &Track, chosen: impl Iterator<Item = usize>) -> Option<Self> {
        let points: Vec<(f64, f64)> = chosen
            .map(|k| ((track.start + k) as f64, f64::from(track.across[k])))
            .collect();
        if points.len() < FEWEST {
            return None;
        }
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
