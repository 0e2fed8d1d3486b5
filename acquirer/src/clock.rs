//! The one clock of the acquirer: `CLOCK_MONOTONIC`, which is also what V4L2 drivers stamp frames
//! with.
//!
//! Gives a [`Duration`] since an arbitrary start (usually the machine's), so that a camera's time
//! stamp and the arrival of a message can be compared and subtracted. It never jumps with the
//! calendar's clock.

use std::time::Duration;

use nix::time::{ClockId, clock_gettime};

/// Now, as the time since the start of the monotonic clock.
///
/// Two readings in this process, and any reading and a camera's stamp, may be subtracted; a reading
/// means nothing on another machine.
#[must_use]
pub fn monotonic_now() -> Duration {
    // The call cannot fail for this clock on Linux; zero would only make every frame look fresh.
    clock_gettime(ClockId::CLOCK_MONOTONIC).map_or(Duration::ZERO, Duration::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_never_runs_backwards() {
        let readings: Vec<_> = (0..100).map(|_| monotonic_now()).collect();
        assert!(readings.is_sorted());
        assert!(readings[0] > Duration::ZERO);
    }
}
