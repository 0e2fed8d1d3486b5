//! Whether the frames beside a change are free of the other pattern's light.
//!
//! Takes the runs with their labels, gives the frames of a run that show its pattern all over. Frames of a run look the
//! same up to noise, but noise may hide some light of the pattern before in the first frame, and of the one after in
//! the last: where two patterns differ little in a band, a tenth of that is less than what frames differ by anyhow. So
//! the share of the other pattern's light is fitted over all values of a band, and a frame at an end is given only when
//! a twentieth can be ruled out in every band ([`super::Look::most_foreign`]). Frames further inside have, on either side, a
//! frame of the same pattern that a change would have spoilt first.

use super::{Look, LookNoise, Seen, runs::Run};

/// Share of foreign light in a band that must be ruled out, as it is measured: a camera's curve that is not sRGB's can
/// make a tenth look like little more than half of that.
const FOREIGN_SHARE: f32 = 0.05;

/// Runs and the patterns that they show.
pub(super) struct LabelledRuns<'a> {
    pub(super) frames: &'a [Seen],
    pub(super) runs: &'a [Run],
    pub(super) labels: &'a [Option<usize>],
    pub(super) noise: LookNoise,
}

impl LabelledRuns<'_> {
    /// The frames of a run that show its pattern all over. `held` tells that the patterns around were up so long that
    /// of two frames in a row at least one is whole, in each band if there are two frames, all over if there is one.
    pub(super) fn pure_frames(&self, place: usize, label: usize, held: bool) -> Vec<usize> {
        let frames = &self.runs[place].frames[..];
        let inner = frames.len() - frames.len().min(2);
        // more noise than was measured may hide more foreign light than can be ruled out
        let ends = !self.noise.coarse;
        let pure = |&k: &usize| match frames.len() {
            1 => held,
            2 => self.is_pure_end(place, label, k, held),
            _ => (1..=inner).contains(&k) || self.is_pure_end(place, label, k, true),
        };
        let places = (0..frames.len()).filter(|k| ends || (1..=inner).contains(k));
        places.filter(pure).map(|k| frames[k]).collect()
    }

    /// Whether the first or the last frame of a run has none of the light beside it; unless `alone`, the frame that it
    /// is compared with may have some from the other side.
    fn is_pure_end(&self, place: usize, label: usize, k: usize, alone: bool) -> bool {
        let frames = &self.runs[place].frames;
        let (before, after) = (self.beside(place, label, -1), self.beside(place, label, 1));
        let (mine, others, inner) = if k == 0 {
            (before, after, frames[1])
        } else {
            (after, before, frames[frames.len() - 2])
        };
        let mine = match mine {
            Beside::Nothing => return true,
            Beside::NotSeen => return false,
            Beside::Look(look) => look,
        };
        let foreign = match others {
            Beside::Look(other) if !alone => vec![mine, other],
            Beside::NotSeen if !alone => return false,
            _ => vec![mine],
        };
        let (own, inner) = (&self.frames[frames[k]].look, &self.frames[inner].look);
        own.most_foreign(inner, &foreign, self.noise) < FOREIGN_SHARE
    }

    /// What was up before (-1) or after (1) a run's pattern.
    fn beside(&self, place: usize, label: usize, step: isize) -> Beside<'_> {
        let mut run = place;
        while let Some(next) = run
            .checked_add_signed(step)
            .filter(|&k| k < self.runs.len())
        {
            run = next;
            let Some(shown) = self.labels[run].filter(|&shown| shown != label) else {
                continue;
            };
            let frames = &self.runs[run].frames;
            let look = &self.frames[frames[frames.len() / 2]].look;
            return if label.checked_add_signed(step) == Some(shown) {
                Beside::Look(look)
            } else {
                Beside::NotSeen
            };
        }
        Beside::Nothing
    }
}

/// What is known of the pattern beside a run.
enum Beside<'a> {
    /// None was there.
    Nothing,
    /// It was there, but no frame shows it.
    NotSeen,
    /// It looks so.
    Look(&'a Look),
}
