//! Which pattern does a frame show? Judged from the image, in bands; the clocks are only a prior.
//!
//! Takes what the projector was told to show and when it said so, what is known of the rig's timing, and the frames;
//! gives for each frame the pattern it shows, or that it shows none (mixed), or that it cannot be told. No clock, no
//! socket and no camera is asked here: same frames, same times, same tags.
//!
//! - [`Look`]: what is kept of a frame, in horizontal bands, and how two frames compare (`look`).
//! - [`FrameKind`]: which frames show one pattern all over, by comparing neighbours (`runs`).
//! - [`tag_frames`]: which pattern that is: the order of the sequence, then the times (`align`); frames beside a change
//!   only if their neighbours' light can be ruled out (`ends`), frames between two mixed ones if the clocks vouch for them
//!   and are right wherever the frames themselves tell.
//! - [`outstanding_order`]: in which order colours are best shown, [`begin_seen`]: which view may be first (`order`).
//! - [`Timing::begin_ms`]: when a sequence is best begun (`phase`).
//! - [`find_timing`]: latency, jitter, read-out and exposure from black and white flashes (`flash`).
//!
//! # Conventions
//! Times are milliseconds on one clock, as `f64`. A frame stamped `x` is exposed from `x - exposure` to `x` in its
//! first row and later by up to the read-out in its last one. A picture that the projector says is shown at `t` is
//! light from `t + latency` on, give or take half the jitter. Whatever else a driver's stamp means becomes part of
//! the latency.

mod look;

mod runs;

mod ends;

mod align;

mod settling;

mod timing;

mod phase;

mod flash;

mod order;

pub use align::{Alignment, Tag, tag_frames};
pub use flash::{Flash, find_timing};
pub use look::{BANDS, Band, Look, LookNoise, NoiseLaw};
pub use order::{begin_seen, outstanding_order};
pub use phase::Delay;
pub use runs::{FrameKind, Seen};
pub use settling::Settling;
pub use timing::{Estimate, Timing};
