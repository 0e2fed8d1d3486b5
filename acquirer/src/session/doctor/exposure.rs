//! `exposure`: whether white light uses the camera's range: neither clipped nor dark.
//!
//! Takes black and white, gives the share of the lit pixels that are clipped and by how many levels of 255 white stands
//! out of black at the middle one of them. What is clipped is not read; colours are told apart by steps of a tenth of
//! white, which 40 levels make 4, as much as noise and compression do.

use super::{Bench, Finding, Lit, Measured};

/// Mean byte that a twentieth of the lit pixels should reach under white: as bright as can be without clipping.
const AIM: f64 = 225.0;
/// Exponent between light and bytes, roughly.
const GAMMA: f64 = 2.2;

pub(super) fn examine(bench: &Bench, lit: &Lit) -> Finding {
    let limits = bench.examination.limits;
    let measured = vec![
        Measured::new(
            "clipped pixels under white",
            100.0 * lit.clipped,
            "% of the lit ones",
        )
        .at_most(100.0 * limits.clipped),
        Measured::new(
            "white above black, middle pixel",
            lit.levels,
            "of 255 levels",
        )
        .at_least(limits.levels),
        Measured::new(
            "brightest twentieth under white",
            lit.bright,
            "of 255 levels",
        ),
        Measured::new(
            "lit by the projector",
            100.0 * lit.share,
            "% of the picture",
        ),
    ];
    let good = format!(
        "white stands {:.0} levels above black, {:.1} % of the lit pixels are clipped",
        lit.levels,
        100.0 * lit.clipped
    );
    Finding::judged("exposure", measured, good, || {
        if lit.clipped > limits.clipped {
            let says = format!("{:.0} % of the lit pixels are clipped", 100.0 * lit.clipped);
            return (says, format!("{} and run this again", shorter(bench)));
        }
        let factor = (AIM / lit.bright.max(1.0)).powf(GAMMA);
        let says = format!(
            "the scene is dark: white stands {:.0} levels above black where {:.0} are needed",
            lit.levels, limits.levels
        );
        (says, longer(bench, factor))
    })
}

fn shorter(bench: &Bench) -> String {
    let now = bench.exposure_ms().map(|ms| {
        let half = ms / 2.0;
        format!(
            " ({ms:.1} ms) to {half:.1} ms ({})",
            bench.how_to_expose(half)
        )
    });
    format!(
        "halve the camera's exposure time{} or its gain, or close its aperture by one stop, or let --expose find it;",
        now.unwrap_or_default()
    )
}

fn longer(bench: &Bench, factor: f64) -> String {
    let now = bench.exposure_ms().map(|ms| {
        let then = ms * factor;
        format!(
            " ({then:.1} ms instead of {ms:.1}; {})",
            bench.how_to_expose(then)
        )
    });
    format!(
        "expose {factor:.1} times longer{}, or let --expose find it, open the aperture, raise the projector's \
         brightness, go nearer, or raise the gain",
        now.unwrap_or_default()
    )
}
