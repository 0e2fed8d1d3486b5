//! The projector's clock against ours, from round trips.
//!
//! The projector reads its clock somewhere between our sending and receiving; taking the middle
//! errs by at most half the round trip (Cristian 1989).

use std::time::Duration;

/// One round trip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ping {
    /// From sending to receiving.
    pub round_trip: Duration,
    /// The clocks' relation as this round trip shows it.
    pub offset: ClockOffset,
}

impl Ping {
    /// From our times of sending and receiving and the projector's clock between them.
    pub(super) fn new(sent_at: Duration, received_at: Duration, clock_ns: u64) -> Self {
        let round_trip = received_at.saturating_sub(sent_at);
        let middle = sent_at + round_trip / 2;
        let offset_ns = signed(middle.as_nanos()).saturating_sub(signed(clock_ns));
        Self {
            round_trip,
            offset: ClockOffset {
                offset_ns,
                uncertainty: round_trip / 2,
            },
        }
    }
}

/// What to add to a time of the projector to get a time of [`crate::clock::monotonic_now`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClockOffset {
    /// Our clock minus the projector's, in nanoseconds.
    pub offset_ns: i64,
    /// The offset is wrong by at most this.
    pub uncertainty: Duration,
}

impl ClockOffset {
    /// A time of the projector (`presented_ns`) on our clock; zero for a time before our clock
    /// began.
    #[must_use]
    pub fn local_time(&self, projector_ns: u64) -> Duration {
        let local = signed(projector_ns).saturating_add(self.offset_ns);
        Duration::from_nanos(u64::try_from(local).unwrap_or(0))
    }

    /// A time of our clock on the projector's, in nanoseconds; zero for a time before the projector started.
    #[must_use]
    pub fn projector_ns(&self, local: Duration) -> u64 {
        let projector = signed(local.as_nanos()).saturating_sub(self.offset_ns);
        u64::try_from(projector).unwrap_or(0)
    }
}

fn signed(nanoseconds: impl TryInto<i64>) -> i64 {
    nanoseconds.try_into().unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_projector_that_started_before_our_clock_is_related_too() {
        let ms = Duration::from_millis;
        let ping = Ping::new(ms(1000), ms(1004), 90_000_000_000);
        assert_eq!(ping.round_trip, ms(4));
        assert_eq!(
            ping.offset,
            ClockOffset {
                offset_ns: -88_998_000_000,
                uncertainty: ms(2)
            }
        );
        assert_eq!(ping.offset.local_time(90_000_000_000), ms(1002));
        assert_eq!(ping.offset.projector_ns(ms(1002)), 90_000_000_000);
        assert_eq!(ping.offset.local_time(0), Duration::ZERO);
        assert_eq!(
            ping.offset.local_time(u64::MAX).as_nanos(),
            (i64::MAX - 88_998_000_000) as u128
        );
    }
}
