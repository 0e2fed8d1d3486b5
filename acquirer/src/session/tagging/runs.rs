//! Which frames show one pattern all over, judged by comparing neighbours.
//!
//! Takes frames in their order, gives each a [`FrameKind`] and the whole ones in runs of frames that look the same.
//! Two neighbours that look the same in every band are whole: a change within either would differ between them. A
//! frame that differs from both neighbours is mixed when it could be a mixture of them, and whole when no band of it
//! looks like one. Where a neighbour was lost nobody can tell. This holds if each pattern stays for
//! [`super::Timing::least_hold_ms`]: then the neighbours of a frame that mixes two patterns show no third one.

use super::{Look, LookNoise};

/// Frames before one that are looked at for the same picture: as many as drivers keep buffers.
const BUFFERS: usize = 8;
/// A gap between stamps longer than this many frames hides a frame.
pub(super) const GAP_FRAMES: f64 = 1.5;

/// A frame and when it was taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// The driver's stamp, in milliseconds.
    pub stamp_ms: f64,
    /// Frames are known to be missing before this one.
    pub after_loss: bool,
    /// What is kept of it.
    pub look: Look,
}

/// What a frame is, whatever pattern it shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameKind {
    /// One pattern all over.
    Whole,
    /// Parts of two patterns.
    Mixed,
    /// It cannot be told.
    Unsure,
    /// The very bytes of an earlier frame, given once more.
    Duplicate {
        /// Which frame.
        of: usize,
    },
}

/// Frames in a row that show the same.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Run {
    /// Their places among the frames, in order.
    pub(super) frames: Vec<usize>,
    /// A frame was lost or not told since the run before.
    pub(super) doubt_before: bool,
}

/// The kind of every frame, and the runs of whole ones.
pub(super) fn find_runs(
    frames: &[Seen],
    noise: LookNoise,
    frame_ms: f64,
) -> (Vec<FrameKind>, Vec<Run>) {
    let mut kinds: Vec<FrameKind> = (0..frames.len()).map(|k| duplicate(frames, k)).collect();
    let fresh: Vec<usize> = (0..frames.len())
        .filter(|&k| kinds[k] == FrameKind::Unsure)
        .collect();
    let groups = groups_of(frames, &fresh, noise);
    // a duplicate stands in the place of a frame that nobody saw
    let lost_between = |a: usize, b: usize| {
        b - a > 1
            || frames[b].after_loss
            || frames[b].stamp_ms - frames[a].stamp_ms > GAP_FRAMES * frame_ms
    };
    let (mut runs, mut doubt) = (Vec::new(), false);
    for (place, group) in groups.iter().enumerate() {
        let neighbours = (
            place.checked_sub(1).and_then(|k| groups[k].last().copied()),
            groups.get(place + 1).map(|next| next[0]),
        );
        let (first, last) = (group[0], group[group.len() - 1]);
        let (before, after) = neighbours;
        doubt |= before.is_some_and(|before| lost_between(before, first));
        let kind = match (group.len(), before, after) {
            (2.., _, _) => FrameKind::Whole,
            (_, Some(before), Some(after))
                if !lost_between(before, first) && !lost_between(last, after) =>
            {
                let (before, after) = (&frames[before].look, &frames[after].look);
                let look = &frames[first].look;
                if look.between(before, after, noise) {
                    FrameKind::Mixed
                } else if look.partly_mixed(before, after, noise) {
                    FrameKind::Unsure
                } else {
                    FrameKind::Whole
                }
            }
            _ => FrameKind::Unsure,
        };
        group.iter().for_each(|&frame| kinds[frame] = kind);
        match kind {
            FrameKind::Whole => runs.push(Run {
                frames: group.to_vec(),
                doubt_before: std::mem::take(&mut doubt),
            }),
            FrameKind::Unsure => doubt = true,
            FrameKind::Mixed | FrameKind::Duplicate { .. } => {}
        }
    }
    (kinds, runs)
}

/// Frames in a row that look the same; two that look the same but for little stand together too.
fn groups_of<'a>(frames: &[Seen], fresh: &'a [usize], noise: LookNoise) -> Vec<&'a [usize]> {
    let look = |place: usize| &frames[fresh[place]].look;
    let same = |place: usize| look(place).same(look(place + 1), noise);
    let joined: Vec<bool> = (1..fresh.len()).map(|place| same(place - 1)).collect();
    let joins = |place: usize| joined.get(place).copied().unwrap_or(false);
    let pair = |place: usize| {
        let alone = place > 0 && !joins(place - 1) && !joins(place) && !joins(place + 1);
        alone
            && place + 2 < fresh.len()
            && look(place).nearly_same(look(place + 1), (look(place - 1), look(place + 2)), noise)
    };
    let (mut groups, mut begin) = (Vec::new(), 0);
    for place in 0..fresh.len() {
        let paired = place > begin || place + 1 == fresh.len() || !pair(place);
        if !joins(place) && paired {
            groups.push(&fresh[begin..=place]);
            begin = place + 1;
        }
    }
    groups
}

/// Whether a frame is an earlier one given once more; unsure otherwise.
fn duplicate(frames: &[Seen], place: usize) -> FrameKind {
    if frames[place].look.is_blank() {
        return FrameKind::Unsure;
    }
    let earlier = place.saturating_sub(BUFFERS)..place;
    earlier
        .rev()
        .find(|&before| frames[before].look == frames[place].look)
        .map_or(FrameKind::Unsure, |of| FrameKind::Duplicate { of })
}
