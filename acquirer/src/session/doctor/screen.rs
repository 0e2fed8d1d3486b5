//! `screen`: whether the camera sees what the projector program shows.
//!
//! Takes frames of the change from black to white, gives how much brighter they became. If they did not, what the
//! camera sees under black tells whether something else is lit. It fails quietly when the camera sees only the glow of
//! another screen that does show the picture.

use shared::protocol::ScreenKind;

use super::{Bench, Finding, Measured, bench::Step};
use crate::session::{SessionError, tagging::Look};

/// Smallest rise of the mean light that counts as seen, as a share of full white: what the latency needs too.
const LEAST_RISE: f64 = 0.0012;
/// The rise must exceed what frames of black differ by among each other this many times.
const LEAST_OVER_UNREST: f64 = 3.0;
/// Mean light above which the camera sees something lit while the projector shows black.
const LIT: f64 = 0.02;

pub(super) fn examine(bench: &mut Bench, step: &Step) -> Result<Finding, SessionError> {
    let (rise, black, unrest) = figures(step);
    let least = LEAST_RISE.max(LEAST_OVER_UNREST * unrest);
    let measured = vec![
        Measured::new("rise of the mean light", 100.0 * rise, "% of full white")
            .at_least(100.0 * least),
        Measured::new("mean light under black", 100.0 * black, "% of full white"),
    ];
    let screen = bench.rig.projector.state()?.screen;
    let place = match screen.kind {
        ScreenKind::FullScreen => format!("on output {}", screen.name),
        ScreenKind::Window => "in a window".into(),
        ScreenKind::Headless => "without any screen (--headless)".into(),
    };
    let good = format!(
        "the camera sees the projector's flashes: white is {:.1} % of full light brighter than black",
        100.0 * rise
    );
    Ok(Finding::judged("screen", measured, good, || {
        let sees = if black > LIT {
            format!(
                "it sees a lit scene ({:.0} % of full light) that stays as it is: another output or input is on the \
                 projector, or the room's light is all there is",
                100.0 * black
            )
        } else {
            "it sees next to no light: the lamp is off or muted, or the camera looks elsewhere or has its lid on".into()
        };
        let problem = screen.problem.map(|problem| format!(" ({problem})"));
        let problem = problem.unwrap_or_default();
        (
            format!("the camera does not see the projector's flashes; {sees}"),
            format!(
                "the projector program shows its pictures {place}{problem}: run `projector screens`, start it with \
                 --screen NAME for the output that lights up, end the projector's mute and freeze, and point the camera \
                 at the picture"
            ),
        )
    }))
}

/// Rise of the mean light, mean light under black, and how much that varies, as shares of full white.
fn figures(step: &Step) -> (f64, f64, f64) {
    let brightness = |looks: &[Look]| -> Vec<f64> {
        let values = looks.iter().map(|look| f64::from(look.brightness()));
        values.map(|value| value / 255.0).collect()
    };
    let (black, white) = (brightness(&step.black), brightness(&step.white));
    let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let least = black.iter().copied().fold(f64::INFINITY, f64::min);
    let level = black.iter().sum::<f64>() / black.len().max(1) as f64;
    // automatics may have made black as bright as white will be in the end: the brightest moment counts
    (most(&white) - level, level, most(&black) - least)
}
