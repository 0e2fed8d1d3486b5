//! When a sequence is best begun, so that the frames that are wanted fall between the changes of the picture.
//!
//! Projector and camera run freely, but both evenly: when frames will be stamped is known from those before, and when a
//! picture will be shown from when it is due at the projector, up to one of its refreshes. So the first picture is due at
//! a moment that puts frames where they are wanted between two changes, and as each picture is held for a whole number
//! of frames, those of every later one fall so too. Then a picture need not be held until some frame is whole whatever
//! the phase: two frames are enough while exposure, read-out, jitter and a refresh together are shorter.
//! It fails harmlessly when the camera or the projector's computer stumbles: frames are judged by what they look like
//! and by when pictures were shown, not by when they should have been.

use serde::Serialize;

use super::Timing;

/// Share of the pictures that is planned for; a busy computer shows some much later.
const PLANNED_SHARE: f64 = 0.9;

/// From when a picture is due at the projector until it says that it is shown: up to a refresh more for one than for
/// another, in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Delay {
    /// The shortest one.
    pub least_ms: f64,
    /// The longest one of those that are planned for.
    pub most_ms: f64,
}

impl Delay {
    /// From some delays in milliseconds; `None` of none.
    #[must_use]
    pub fn of(mut delays_ms: Vec<f64>) -> Option<Self> {
        delays_ms.sort_by(f64::total_cmp);
        let last = delays_ms.len().checked_sub(1)?;
        let most = (PLANNED_SHARE * last as f64).ceil() as usize;
        Some(Self {
            least_ms: delays_ms[0],
            most_ms: delays_ms[most],
        })
    }
}

impl Timing {
    /// For how many frames a picture must be held so that the clocks vouch for one of them, in a sequence begun at
    /// [`Timing::begin_ms`]; `None` when the flashes do not tell.
    pub(super) fn hold_frames_in_phase(&self) -> Option<usize> {
        let (settling, delay) = self.vouching().zip(self.delay)?;
        let change = settling.new_from_ms - settling.old_until_ms;
        let longest = change + delay.most_ms - delay.least_ms;
        Some((longest / self.frame_ms).ceil() as usize)
    }

    /// When the first picture of a sequence is best due, in milliseconds: not before `earliest_ms`, where frames are
    /// stamped at `stamp_ms` and every frame time before and after. A frame is put into the middle of the time in which
    /// the clocks vouch for it; or a change between two frames, if it is shorter and more than one `whole` frame of each
    /// picture is wanted or the camera loses frames: so most frames are whole, and several are told by each other.
    #[must_use]
    pub fn begin_ms(&self, earliest_ms: f64, stamp_ms: f64, whole: usize) -> f64 {
        let Some((settling, delay)) = self.settling.zip(self.delay) else {
            return earliest_ms;
        };
        let held = self.hold_frames(1) as f64 * self.frame_ms;
        let vouched = f64::midpoint(settling.new_from_ms, held + settling.old_until_ms);
        let since_shown = if (whole > 1 || !settling.watched) && self.change.ms < self.frame_ms {
            vouched + 0.5 * self.frame_ms
        } else {
            vouched
        };
        let best = stamp_ms - since_shown - f64::midpoint(delay.least_ms, delay.most_ms);
        best + ((earliest_ms - best) / self.frame_ms).ceil() * self.frame_ms
    }
}
