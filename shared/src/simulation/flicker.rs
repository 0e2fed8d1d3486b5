//! Light that is not steady: lamps on the mains, and projectors that show their colours one after the other.
//!
//! Takes a span of time, gives the mean light over it as a share of the steady light. A lamp swings as a cosine; a
//! colour wheel gives red, green and blue a third of each turn, three times as bright. Times are the caller's.

use std::time::Duration;

use super::scene::FaultsTable;

/// A lamp whose light swings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lamp {
    depth: f64,
    hz: f64,
}

impl Lamp {
    pub(super) fn new(faults: &FaultsTable) -> Self {
        Self {
            depth: faults.lamp_flicker,
            hz: faults.lamp_flicker_hz,
        }
    }

    /// Mean light between two times; 1 is the lamp's mean over a long time.
    pub(super) fn mean(self, from: Duration, to: Duration) -> f32 {
        if self.depth == 0.0 {
            return 1.0;
        }
        let phase = |time: Duration| std::f64::consts::TAU * (time.as_secs_f64() * self.hz);
        let (begin, end) = (phase(from), phase(to));
        let swing = if end > begin {
            (end.sin() - begin.sin()) / (end - begin)
        } else {
            begin.cos()
        };
        (1.0 + self.depth * swing) as f32
    }
}

/// A wheel that lets red, green and blue pass in turn.
#[derive(Debug, Clone, Copy)]
pub(super) struct ColourWheel {
    hz: f64,
}

impl ColourWheel {
    pub(super) fn new(faults: &FaultsTable) -> Self {
        Self {
            hz: faults.colour_wheel_hz,
        }
    }

    /// What each colour gives between two times, as a share of what it would give from `from` to `to` in all of
    /// `whole`, had it been on all the time.
    pub(super) fn shares(self, from: Duration, to: Duration, whole: Duration) -> [f32; 3] {
        let part = |span: f64| span / whole.as_secs_f64().max(1e-9);
        let (begin, end) = (from.as_secs_f64(), to.as_secs_f64());
        if self.hz == 0.0 {
            return [part(end - begin) as f32; 3];
        }
        [0, 1, 2].map(|colour| {
            let lit = self.lit_until(end, colour) - self.lit_until(begin, colour);
            part(3.0 * lit) as f32
        })
    }

    /// How long a colour has been on by a time, in seconds.
    fn lit_until(self, time: f64, colour: u8) -> f64 {
        let turns = time * self.hz;
        let in_turn = (turns.fract() - f64::from(colour) / 3.0).clamp(0.0, 1.0 / 3.0);
        (turns.floor() / 3.0 + in_turn) / self.hz
    }
}
