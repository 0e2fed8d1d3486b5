//! `latency`: from the projector's word that a picture is shown to its light in a frame, and how much that varies.
//!
//! Measured as always, by irregular flashes ([`measure_latency`]). A long latency costs time, a wide jitter costs
//! frames: each picture must be held longer by it. Only what is certain is held against them: a computer that is busy
//! with other things delays notices and frames itself.

use super::{Bench, Finding, Measured};
use crate::session::{Latency, SessionError, measure_latency};

/// Share of the frames that may come while this program is busy for its times to be believed.
const MOST_OVERTAKEN: f64 = 0.5;

pub(super) fn examine(bench: &mut Bench) -> Result<Finding, SessionError> {
    bench.tell("latency, by flashes");
    let settings = bench.examination.latency;
    match measure_latency(bench.rig, settings, bench.cancel, &mut |_| {}) {
        _ if bench.overtaken_share() > MOST_OVERTAKEN => {
            let reason = "this computer is too busy: it sees less than half of the frames in time";
            Ok(Finding::not_checked("latency", reason))
        }
        Ok(latency) => Ok(judge(bench, &latency)),
        Err(error @ (SessionError::NotSeen { .. } | SessionError::SequenceBroken { .. })) => {
            let says = format!("the latency can't be measured: {error}");
            let fix = "keep the scene still and its light steady, keep hands off the projector's keys, and try again";
            Ok(Finding::bad("latency", vec![], says, fix.into()))
        }
        Err(error) => Err(error),
    }
}

fn judge(bench: &Bench, latency: &Latency) -> Finding {
    let limits = bench.examination.limits;
    let timing = &latency.timing;
    let certain_jitter = timing.jitter.at_least();
    let certain_latency = timing.latency.at_least();
    let measured = vec![
        Measured::new("latency, at least", certain_latency, "ms").at_most(limits.latency_ms),
        Measured::new("latency", timing.latency.ms, "ms"),
        Measured::new("its uncertainty", timing.latency.uncertainty_ms, "ms"),
        Measured::new("jitter, at least", certain_jitter, "ms").at_most(limits.jitter_ms),
        Measured::new("jitter", timing.jitter.ms, "ms"),
        Measured::new("read-out of a frame", timing.readout.ms, "ms"),
        Measured::new("exposure of a row", timing.exposure.ms, "ms"),
    ];
    let good = format!(
        "a picture is seen {:.0} ms after the projector shows it, give or take {:.0} ms; rows are exposed for {:.0} ms \
         and read out within {:.0} ms",
        timing.latency.ms,
        timing.jitter.ms / 2.0,
        timing.exposure.ms,
        timing.readout.ms
    );
    Finding::judged("latency", measured, good, || {
        let says = if certain_jitter > limits.jitter_ms {
            format!(
                "the time until a picture is seen varies by {:.0} ms",
                timing.jitter.ms
            )
        } else {
            format!(
                "a picture is seen only {:.0} ms after the projector shows it",
                timing.latency.ms
            )
        };
        let fix = "switch the projector to its game or PC mode, switch off frame interpolation, noise reduction and \
                   keystone, avoid wireless HDMI and converters, and end what keeps the projector's computer busy; \
                   recordings work, but each picture takes longer";
        (says, fix.into())
    })
}
