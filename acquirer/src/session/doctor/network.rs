//! `network`: how long a word to the projector and back takes.
//!
//! Takes some round trips, gives their middle one. Pictures of a recording are sent ahead in one message, so a slow
//! network costs little time; but the projector's clock is related to ours by half a round trip, and that is how
//! wrong the times of its pictures can be (Cristian 1989).

use super::{Bench, Finding, Measured};
use crate::session::{SessionError, sequence::milliseconds};

/// Round trips that are measured.
const PINGS: usize = 21;

pub(super) fn examine(bench: &mut Bench) -> Result<Finding, SessionError> {
    bench.tell("network");
    let mut trips_ms = Vec::with_capacity(PINGS);
    for _ in 0..PINGS {
        if bench.cancel.is_cancelled() {
            return Err(SessionError::Cancelled);
        }
        trips_ms.push(milliseconds(bench.rig.projector.ping()?.round_trip));
    }
    trips_ms.sort_by(f64::total_cmp);
    let clock = bench.rig.clock_offset()?;
    let usual = trips_ms[PINGS / 2];
    let known_to_ms = milliseconds(clock.uncertainty);
    let measured = vec![
        Measured::new("usual round trip", usual, "ms")
            .at_most(bench.examination.limits.round_trip_ms),
        Measured::new("longest round trip", trips_ms[PINGS - 1], "ms"),
        Measured::new("the clocks' relation is known to", known_to_ms, "ms"),
        Measured::new(
            "our clock minus the projector's",
            clock.offset_ns as f64 / 1e6,
            "ms",
        ),
    ];
    let good = format!(
        "a word to the projector and back takes {usual:.1} ms, its clock is known to {known_to_ms:.1} ms"
    );
    Ok(Finding::judged("network", measured, good, || {
        (
            format!(
                "a word to the projector and back takes {usual:.0} ms, so its clock is known to {known_to_ms:.0} ms only"
            ),
            "connect the two computers by a cable or one switch instead of wireless, end large transfers, or run both \
             programs on one computer"
                .into(),
        )
    }))
}
