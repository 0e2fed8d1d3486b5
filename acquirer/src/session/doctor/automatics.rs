//! `automatics`: whether the same light gives the same picture.
//!
//! Takes frames after a change from black to white, and frames of a picture that is half white; gives how much white
//! drifts, and how much brighter it is in the half white picture. Before, the camera was told to hold its automatics
//! where it lets programs do that. A drift must exceed what frames differ by anyhow. Fast automatics have settled
//! before the first frame that counts, but give themselves away in the half white picture.

use super::{Bench, Finding, Measured, Pictures, bench::Step, light::quantile};
use crate::session::tagging::Look;

/// White may be this much brighter in a half white picture; light that comes by way of the walls makes it darker.
const HALF_WHITE: f64 = 1.05;
/// Frames after the change that may still be torn or mixed.
const TORN: usize = 3;
/// A drift must exceed its standard error this many times.
const CERTAIN: f64 = 3.0;

pub(super) fn examine(bench: &Bench, step: &Step, pictures: &Pictures) -> Finding {
    let drifts = drifts(&step.white);
    let drift = drifts.iter().copied().fold(0.0, f64::max);
    let half_white = half_white(pictures);
    let measured = vec![
        Measured::new("drift of white", 100.0 * drift, "%")
            .at_most(100.0 * bench.examination.limits.drift),
        Measured::new("white in a half white picture", 100.0 * half_white, "%")
            .at_most(100.0 * HALF_WHITE),
    ];
    let refused = step.held.iter().filter(|held| held.refused.is_some());
    let refused: Vec<&str> = refused.map(|held| held.name).collect();
    let held: Vec<&str> = step
        .held
        .iter()
        .filter(|held| held.refused.is_none())
        .map(|held| held.name)
        .collect();
    let good = if held.is_empty() {
        "the same light gives the same picture".into()
    } else {
        format!(
            "the same light gives the same picture; held for as long as the camera is open: {}",
            held.join(", ")
        )
    };
    let steady = measured.iter().all(Measured::is_kept);
    if steady && refused.is_empty() {
        return Finding::good("automatics", measured, good);
    }
    let says = if steady {
        format!(
            "the camera does not let programs hold its {}",
            refused.join(", ")
        )
    } else {
        let colours = drifts.iter().copied().fold(f64::INFINITY, f64::min);
        let what = if half_white <= HALF_WHITE && drift > 3.0 * colours {
            "its colours by itself (automatic white balance)"
        } else {
            "its brightness by itself (automatic exposure or gain)"
        };
        format!(
            "the camera changes {what}: white drifts by {:.0} %, and is {:.0} % as bright in a half white picture",
            100.0 * drift,
            100.0 * half_white
        )
    };
    let fix = "switch off automatic exposure, gain and white balance, and set them by hand: `acquirer cameras --controls` lists \
               what the camera lets programs set (--control KEY=VALUE sets it), some cameras have a switch or a program of their own; a projector's \
               dynamic contrast or automatic iris does the same to the picture and must be off too";
    Finding::bad("automatics", measured, says, fix.into())
}

/// How much each channel certainly drifts once white is there, as a share of it.
fn drifts(white: &[Look]) -> [f64; 3] {
    let brightest = white.iter().map(Look::brightness).fold(0.0, f32::max);
    let darkest = white
        .iter()
        .map(Look::brightness)
        .fold(f32::INFINITY, f32::min);
    let half = (brightest + darkest) / 2.0;
    let first = white.iter().position(|look| look.brightness() > half);
    let settled = &white[(first.unwrap_or(0) + TORN).min(white.len())..];
    [0, 1, 2].map(|c| {
        let values: Vec<f64> = settled
            .iter()
            .map(|look| {
                let bands = look.bands();
                let sum: f32 = bands.iter().map(|band| band.mean[c]).sum();
                f64::from(sum) / bands.len().max(1) as f64
            })
            .collect();
        drift(&values)
    })
}

/// By how much the last third of the values certainly differs from the first, as a share of it.
fn drift(values: &[f64]) -> f64 {
    let third = values.len() / 3;
    if third < 2 {
        return 0.0;
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (first, last) = (
        mean(&values[..third]),
        mean(&values[values.len() - third..]),
    );
    // neighbours differ by their unrest alone, whatever the drift
    let squares = values.windows(2).map(|pair| (pair[1] - pair[0]).powi(2));
    let unrest = (squares.sum::<f64>() / (2 * (values.len() - 1)) as f64).sqrt();
    let error = unrest * (2.0 / third as f64).sqrt();
    ((last - first).abs() - CERTAIN * error).max(0.0) / last.max(1e-3)
}

/// Brightness of the white bars as a share of white's.
fn half_white(pictures: &Pictures) -> f64 {
    let Pictures {
        black, bars, lit, ..
    } = pictures;
    let [(_, bars), _] = bars;
    let gains: Vec<f32> = lit
        .usable_pixels()
        .map(|k| (bars.brightness(k) - black.brightness(k)) / lit.white[k])
        .filter(|gain| *gain > 0.5)
        .collect();
    f64::from(quantile(&gains, 0.5))
}
