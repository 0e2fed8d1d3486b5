//! `mains_flicker`: whether the room's lamps flicker in the camera's picture.
//!
//! Takes frames of black, so that only the room's light is seen, gives its swing as a share of the projector's white,
//! and whether it comes at 100 or 120 times a second. Lamps on alternating current flicker at twice its frequency; an
//! exposure of whole swings hides it.

use super::{Bench, Finding, Measured, Pictures, modulation::Modulation};

/// Flicker of lamps on 50 Hz and 60 Hz mains.
const MAINS_HZ: [f64; 2] = [100.0, 120.0];
/// Share of the swing's power that one frequency must explain to be believed.
const BELIEVED: f64 = 0.5;

/// What was found of the lamps.
pub(super) struct Lamps {
    pub(super) finding: Finding,
    /// Direction of colour in which they flicker, if they do.
    pub(super) direction: Option<[f64; 3]>,
}

pub(super) fn examine(bench: &Bench, pictures: &Pictures) -> Lamps {
    let Pictures { black, white, .. } = pictures;
    let modulation = Modulation::of(black, black, white);
    let direction = modulation.direction();
    let swing = modulation.swing([1.0 / 3.0; 3]);
    let explained = MAINS_HZ.map(|hz| (modulation.explained_by(hz), hz));
    let best = explained.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    let hz = best
        .filter(|(share, _)| *share > BELIEVED)
        .map(|(_, hz)| hz);
    let limit = bench.examination.limits.swing;
    let measured = vec![
        Measured::new(
            "swing of the room's light",
            100.0 * swing,
            "% of the projector's white",
        )
        .at_most(100.0 * limit),
    ];
    let good = format!(
        "the room's light swings by {:.1} % of the projector's white",
        100.0 * swing
    );
    let finding = Finding::judged("mains_flicker", measured, good, || {
        let rhythm = hz.map_or_else(String::new, |hz| format!(", {hz:.0} times a second"));
        let says = format!(
            "the room's light swings by {:.1} % of the projector's white{rhythm}: a lamp flickers",
            100.0 * swing
        );
        (says, advice(bench, hz))
    });
    let direction = (!finding.is_good()).then_some(direction);
    Lamps { finding, direction }
}

fn advice(bench: &Bench, hz: Option<f64>) -> String {
    let exposure_ms = bench.exposure_ms();
    let now = exposure_ms.map_or_else(String::new, |ms| format!(" from {ms:.1} ms"));
    let swing_ms = 1000.0 / hz.unwrap_or(MAINS_HZ[0]);
    let swings = (exposure_ms.unwrap_or(swing_ms) / swing_ms)
        .round()
        .max(1.0);
    let times = match hz {
        Some(_) => format!(
            "{:.1} ms or {:.1} ms",
            swings * swing_ms,
            (swings + 1.0) * swing_ms
        ),
        None => "10 ms or 20 ms (50 Hz mains), or 8.3 ms or 16.7 ms (60 Hz mains)".into(),
    };
    format!(
        "switch the lamps off or draw the blinds, or set the camera's exposure{now} to whole swings of the light: \
         {times} ({})",
        bench.how_to_expose(swings * swing_ms)
    )
}
