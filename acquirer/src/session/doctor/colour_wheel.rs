//! `colour_wheel`: whether the projector's light is steady during an exposure.
//!
//! Takes frames of white, gives how much brightness or colour swing, as a share of white. A projector with a colour
//! wheel or with lamps in turn shows its colours one after the other, several times in a sixtieth of a second; an
//! exposure that is not a multiple of that catches more of one colour than of another, in bands or from frame to frame.
//! What the room's lamps do, if they flicker, is left out.

use super::{Bench, Finding, Measured, Pictures, mains_flicker::Lamps, modulation::Modulation};

/// One picture of the projector, in milliseconds: whatever its wheel does, it does a whole number of times in it.
const PICTURE_MS: f64 = 1000.0 / 60.0;

pub(super) fn examine(bench: &Bench, pictures: &Pictures, lamps: &Lamps) -> Finding {
    let Pictures { black, white, .. } = pictures;
    let modulation = Modulation::of(white, black, white);
    let swing = channels_without(lamps.direction)
        .into_iter()
        .map(|weights| modulation.swing(weights))
        .fold(0.0, f64::max);
    let limit = bench.examination.limits.swing;
    let measured = vec![Measured::new("swing of white", 100.0 * swing, "%").at_most(100.0 * limit)];
    let good = format!("white swings by {:.1} %", 100.0 * swing);
    Finding::judged("colour_wheel", measured, good, || {
        let exposure_ms = bench.exposure_ms();
        let now = exposure_ms.map_or_else(String::new, |ms| format!(" from {ms:.1} ms"));
        let says = format!(
            "the projector's white swings by {:.0} % in brightness or colour: it shows its colours one after the other, \
             and the exposure does not hold whole turns",
            100.0 * swing
        );
        let fix = format!(
            "set the camera's exposure{now} to {PICTURE_MS:.1} ms (1/60 s) or {:.1} ms (1/30 s) ({}), and the projector \
             to 60 pictures a second; make up for the brightness with gain or aperture",
            2.0 * PICTURE_MS,
            bench.how_to_expose(PICTURE_MS)
        );
        (says, fix)
    })
}

/// Each channel's weights, without a direction of colour.
fn channels_without(direction: Option<[f64; 3]>) -> [[f64; 3]; 3] {
    let along = direction.unwrap_or([0.0; 3]);
    [0, 1, 2].map(|channel| {
        std::array::from_fn(|c| f64::from(u8::from(c == channel)) - along[channel] * along[c])
    })
}
