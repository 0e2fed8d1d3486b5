//! When a picture is certainly on the screen.
//!
//! No driver tells through wgpu when a frame reached the screen. But with presentation paced by the
//! refresh (Fifo) a frame can only be handed over once an earlier one has left the queue: after as many
//! presentations as the queue has images, and one, the first is being scanned out. Software drivers do not
//! pace, so the same number of refresh periods must pass by the clock too. It fails quietly with a
//! compositor that delays frames by more than that; the projector's own delay comes on top in any case.

use std::time::{Duration, Instant};

/// What to do after a presentation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Next {
    /// Present the same picture again, now.
    Again,
    /// Present the same picture again at this time.
    AgainAt(Instant),
    /// The picture is certainly shown.
    Certain,
}

/// Counts the presentations of one picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Presentation {
    refreshes: u32,
    period: Duration,
    presented: u32,
    first: Option<Instant>,
}

impl Presentation {
    /// A picture that was not presented yet, certain after this many refreshes of this period.
    pub(super) fn new(refreshes: u32, period: Duration) -> Self {
        Self {
            refreshes,
            period,
            presented: 0,
            first: None,
        }
    }

    /// Counts a presentation at this time.
    pub(super) fn presented(&mut self, now: Instant) -> Next {
        let first = *self.first.get_or_insert(now);
        self.presented += 1;
        if self.presented <= self.refreshes {
            return Next::Again;
        }
        let certain_at = first + self.period * self.refreshes;
        if now < certain_at {
            Next::AgainAt(certain_at)
        } else {
            Next::Certain
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::{Next, Presentation};

    const PERIOD: Duration = Duration::from_millis(10);

    #[test]
    fn paced_by_the_refresh_it_takes_one_presentation_more_than_refreshes() {
        let start = Instant::now();
        let mut presentation = Presentation::new(3, PERIOD);
        let next: Vec<_> = (0..4)
            .map(|k| presentation.presented(start + PERIOD * k))
            .collect();
        assert_eq!(next, [Next::Again, Next::Again, Next::Again, Next::Certain]);
    }

    #[test]
    fn a_driver_that_does_not_pace_waits_by_the_clock_without_presenting_meanwhile() {
        let start = Instant::now();
        let mut presentation = Presentation::new(3, PERIOD);
        for _ in 0..3 {
            assert_eq!(presentation.presented(start), Next::Again);
        }
        assert_eq!(
            presentation.presented(start),
            Next::AgainAt(start + PERIOD * 3)
        );
        assert_eq!(presentation.presented(start + PERIOD * 3), Next::Certain);
    }
}
