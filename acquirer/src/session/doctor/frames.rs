//! `frames`: whether as many frames come as the camera says, and none gets lost.
//!
//! Takes the numbers and stamps of all frames of the examination so far, gives their rate and the share that camera
//! or bus lost. Frames that this program was too slow for are told but not judged: only the newest frame counts here,
//! and the examination itself keeps the computer busy.

use super::{Bench, Finding, Measured};

pub(super) fn examine(bench: &Bench) -> Finding {
    let Some(((first, begin), (last, end))) = bench.span().filter(|(first, last)| last.0 > first.0)
    else {
        return Finding::not_checked("frames", "too few frames came");
    };
    let limits = bench.examination.limits;
    let count = (last - first) as f64;
    let rate_hz = count / end.saturating_sub(begin).as_secs_f64().max(1e-6);
    let nominal_hz = bench.rig.camera.format().rate.hz();
    let losses = bench.losses();
    let lost = (losses.by_driver + losses.damaged) as f64 / count;
    let measured = vec![
        Measured::new("frames per second", rate_hz, "Hz").at_least(limits.rate * nominal_hz),
        Measured::new("frames lost by camera or bus", 100.0 * lost, "%")
            .at_most(100.0 * limits.lost_frames),
        Measured::new(
            "frames that came while this program was busy",
            100.0 * bench.overtaken_share(),
            "%",
        ),
    ];
    let good = format!(
        "{rate_hz:.1} frames per second come, {:.1} % of them get lost",
        100.0 * lost
    );
    Finding::judged("frames", measured, good, || {
        if lost > limits.lost_frames {
            (
                format!("{:.0} % of the camera's frames get lost on their way", 100.0 * lost),
                "plug the camera directly into a USB 3 port, away from hubs, disks and other cameras, take a shorter \
                 cable, or ask for less: in config/acquirer.toml a smaller [camera] width and height, or pixel_format = \
                 \"MJPG\""
                    .into(),
            )
        } else {
            (
                format!(
                    "only {rate_hz:.1} frames per second come, {nominal_hz:.1} were set: most cameras slow down in poor \
                     light"
                ),
                "switch off the camera's automatic exposure or its \"dynamic frame rate\", give more light, or set an \
                 exposure shorter than a frame"
                    .into(),
            )
        }
    })
}
