//! What a frame shows while a pattern stays up.
//!
//! The projector's notices tell when something else came up; a frame that may hold the change is mixed unless its bands
//! agree, between the known looks of both patterns, that it is over. Besides, a frame that should be lit must be
//! nearer to the pattern's look than to black in every band. Looks change when things move, so they decide between
//! patterns only, never between details.

use std::time::Duration;

use shared::pattern::{Pattern, Rgb};

use super::{Look, Rig, SessionError};
use crate::{camera::Frame, projector_link::Notice, scan::Shows, session::sequence::milliseconds};

/// Least contrast of a band for its share to count, in light of 255.
const LEAST_CONTRAST: f32 = 1.0;
/// A band whose share of the way from one pattern to the other is within this of an end shows that one.
const END_SHARE: f32 = 0.15;
/// A band that is nearer to black than this share is not lit by the pattern.
const LIT_SHARE: f32 = 0.4;

/// What is up, since when, and how patterns look.
#[derive(Debug)]
pub(super) struct Watch {
    looks: Vec<(Shows, Look)>,
    up: Option<Shows>,
    before: Option<Shows>,
    /// Stamps between which a frame may hold the change, in milliseconds; a recording has none.
    change_ms: Option<(f64, f64)>,
}

impl Watch {
    /// With looks of some patterns, one of which has been up for long.
    pub(super) fn new(looks: Vec<(Shows, Look)>, up: Shows) -> Self {
        Self {
            looks,
            up: Some(up),
            before: None,
            change_ms: None,
        }
    }

    /// Whether this is up, as far as the projector has told.
    pub(super) fn is_up(&self, shows: Shows) -> bool {
        self.up == Some(shows)
    }

    /// A pattern is up and all over the frames from now on.
    pub(super) fn settled(&mut self, up: Shows) {
        self.up = Some(up);
        self.change_ms = None;
    }

    /// Takes what the projector told; whether its settings have changed.
    pub(super) fn listen(&mut self, rig: &mut Rig) -> Result<bool, SessionError> {
        let mut settings_changed = false;
        while let Some(notice) = rig.projector.next_notice(Duration::ZERO)? {
            settings_changed |= matches!(notice, Notice::StateChanged(_));
            let (Notice::Shown { shown, .. }, Some(latency)) = (notice, rig.latency.clone()) else {
                continue;
            };
            let shown_ms = milliseconds(rig.clock_offset()?.local_time(shown.presented_ns));
            let timing = latency.timing;
            let first = shown_ms + timing.latency.ms
                - timing.latency.uncertainty_ms
                - timing.jitter.at_most() / 2.0
                - timing.readout.at_most();
            let last = shown_ms + timing.settled_ms();
            self.before = self.up;
            self.up = kind_of(&shown.pattern);
            self.change_ms = Some((first, last));
        }
        Ok(settings_changed)
    }

    /// What a frame shows.
    pub(super) fn pattern(&self, frame: &Frame) -> &'static str {
        let stamp_ms = milliseconds(frame.captured_at);
        let look = Look::of(&frame.picture);
        let pattern = match self.change_ms {
            Some((first, _)) if stamp_ms < first => self.before,
            Some((_, last)) if stamp_ms < last => match self.decided(&look) {
                Some(end) => end,
                None => return "mixed",
            },
            _ => self.up,
        };
        if pattern.is_some_and(|shows| self.is_dark(&look, shows)) {
            return "mixed";
        }
        name(pattern)
    }

    fn look_of(&self, shows: Option<Shows>) -> Option<&Look> {
        let known = self.looks.iter().find(|(known, _)| Some(*known) == shows);
        known.map(|(_, look)| look)
    }

    /// The end of a change that all bands are at.
    fn decided(&self, look: &Look) -> Option<Option<Shows>> {
        let (before, up) = (self.look_of(self.before)?, self.look_of(self.up)?);
        let shares = look.share(before, up, LEAST_CONTRAST);
        let seen: Vec<f32> = shares.into_iter().flatten().collect();
        let all = |end: &dyn Fn(f32) -> bool| !seen.is_empty() && seen.iter().all(|&s| end(s));
        if all(&|share| share > 1.0 - END_SHARE) {
            return Some(self.up);
        }
        all(&|share| share < END_SHARE).then_some(self.before)
    }

    /// Whether some band has lost its light.
    fn is_dark(&self, look: &Look, shows: Shows) -> bool {
        let ends = (self.look_of(Some(Shows::Black)), self.look_of(Some(shows)));
        let (Some(black), Some(lit)) = ends else {
            return false;
        };
        let shares = look.share(black, lit, LEAST_CONTRAST);
        shows != Shows::Black && shares.into_iter().flatten().any(|share| share < LIT_SHARE)
    }
}

/// What a pattern is called in a scan, if it has a name there.
fn kind_of(pattern: &Pattern) -> Option<Shows> {
    match pattern {
        Pattern::Grid(grid) if grid.is_unary() => Some(Shows::Unary),
        Pattern::Grid(_) => Some(Shows::Prmvs),
        Pattern::Solid { colour: Rgb::BLACK } => Some(Shows::Black),
        Pattern::Solid { colour: Rgb::WHITE } => Some(Shows::White),
        Pattern::Solid { .. }
        | Pattern::Ramp
        | Pattern::TestCard
        | Pattern::Identify { .. }
        | Pattern::PairingCode { .. } => None,
    }
}

fn name(shows: Option<Shows>) -> &'static str {
    match shows {
        Some(Shows::Prmvs) => "coded",
        Some(Shows::Unary) => "unary",
        Some(Shows::Black) => "black",
        Some(Shows::White) => "white",
        Some(Shows::Solid(_)) | None => "other",
    }
}
