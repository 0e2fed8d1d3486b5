//! `focus`: whether edges are sharp enough for the grid's lines.
//!
//! Takes wide bars in both directions, divided by white, gives the width over which they rise from 10 to 90 % in camera
//! pixels, from the slope half way up, and the width of the grid's lines, from the distance of the bars. A blur as wide
//! as the line takes a fifth of its light (an edge spread of 2.56 standard deviations); wider ones take more and let
//! neighbours run together. The sharpest edges of the scene itself, which the projector does not blur, tell which of the
//! two is out of focus, where there are any.

use shared::pattern::{Axis, RasterSize};

use super::{Bench, Finding, Light, Lit, Measured, Pictures, light::quantile, patterns};
use crate::session::SessionError;

/// Width from 10 to 90 % of a Gaussian edge, in standard deviations.
const EDGE_SIGMAS: f64 = 2.563;
/// What the slope over two pixels adds to the variance of an edge, in px squared: a box of two pixels.
const SLOPE_VARIANCE: f64 = 1.0 / 3.0;
/// Gains around the middle of an edge.
const MIDDLE: std::ops::Range<f32> = 0.4..0.6;
/// Edge pixels that are needed.
const LEAST_EDGES: usize = 100;
/// A step of the scene counts when it is this share of its brighter side.
const SCENE_STEP: f32 = 0.3;
/// How far beside an edge of the scene its two sides are looked at, px.
const BESIDE: usize = 6;
/// The scene's edges are sharper than the bars' when they are under this share of their width, and no edges at all but
/// soft patches when they are over the other.
const SHARPER: f64 = 0.7;
const SOFT: f64 = 1.3;

/// Edges of the bars of one direction.
struct Edges {
    /// Width from 10 to 90 %, px.
    width_px: f64,
    /// Camera px that one projector px covers.
    scale: f64,
}

pub(super) fn examine(bench: &mut Bench, pictures: &Pictures) -> Result<Finding, SessionError> {
    let Pictures {
        black, bars, lit, ..
    } = pictures;
    let state = bench.rig.projector.state()?;
    let (raster, grid) = (state.screen.raster, state.grid.coded);
    let mut worst: Option<(f64, f64)> = None;
    let mut measured = Vec::new();
    for (axis, bars) in bars {
        let Some(edges) = edges(bars, black, lit, (*axis, raster)) else {
            continue;
        };
        let line_px = f64::from(grid.width_px(*axis)) * edges.scale;
        let (edge, line) = match axis {
            Axis::Row => ("edges of rows", "lines of rows"),
            Axis::Column => ("edges of columns", "lines of columns"),
        };
        let limit = bench.examination.limits.edge_width * line_px;
        measured.push(Measured::new(edge, edges.width_px, "camera px").at_most(limit));
        measured.push(Measured::new(line, line_px, "camera px"));
        if worst.is_none_or(|(edge_px, line_px_)| edges.width_px / line_px > edge_px / line_px_) {
            worst = Some((edges.width_px, line_px));
        }
    }
    let Some((edge_px, line_px)) = worst else {
        let reason = "too few edges of the projected bars were found; let the picture fill more of the camera's";
        return Ok(Finding::not_checked("focus", reason));
    };
    let scene_px = scene_edges(black, lit);
    if let Some(scene_px) = scene_px {
        measured.push(Measured::new(
            "sharpest edges of the scene",
            scene_px,
            "camera px",
        ));
    }
    let good = format!("edges are {edge_px:.1} camera px wide, the grid's lines {line_px:.1}");
    Ok(Finding::judged("focus", measured, good, || {
        let who = match scene_px {
            Some(scene_px) if scene_px < SHARPER * edge_px => {
                "the projector is out of focus: the scene's own edges are sharper"
            }
            Some(scene_px) if scene_px < SOFT * edge_px => {
                "the camera is out of focus: the scene's own edges are blurred too"
            }
            _ => {
                "the projector or the camera is out of focus (the scene has no sharp edges of its own to tell which)"
            }
        };
        let says = format!(
            "projected edges are {edge_px:.1} camera px wide, wider than the grid's lines ({line_px:.1}); {who}"
        );
        let fix = format!(
            "let `projector` show the identify card (key I) and turn the focus ring until its finest squares are sharp on \
             the object, then the camera's ring on a page of print beside it (or set its focus control and switch \
             automatic focus off); or take wider lines: {:.0} times the width would do",
            (edge_px / line_px * 1.1).ceil()
        );
        (says, fix)
    }))
}

/// The gain of the bars in each usable pixel, 0 to 1; what is not usable is `NaN`.
fn gains(bars: &Light, black: &Light, lit: &Lit) -> Vec<f32> {
    let pixels = lit.usable.len();
    (0..pixels)
        .map(|k| {
            if lit.usable[k] {
                (bars.brightness(k) - black.brightness(k)) / lit.white[k]
            } else {
                f32::NAN
            }
        })
        .collect()
}

fn edges(
    bars: &Light,
    black: &Light,
    lit: &Lit,
    (axis, raster): (Axis, RasterSize),
) -> Option<Edges> {
    let gains = gains(bars, black, lit);
    let width = bars.width;
    let (mut slopes, mut distances) = (Vec::new(), Vec::new());
    for y in 1..bars.height.saturating_sub(1) {
        for x in 1..width.saturating_sub(1) {
            let at = y * width + x;
            if MIDDLE.contains(&gains[at]) {
                let slope = slope(&gains, at, width);
                slopes.extend((slope.0.is_finite() && slope.1.is_finite()).then_some(slope));
            }
        }
    }
    if slopes.len() < LEAST_EDGES {
        return None;
    }
    let lengths: Vec<f32> = slopes.iter().map(|(dx, dy)| dx.hypot(*dy)).collect();
    // edges that lean have their distance foreshortened; the mean direction will do
    let lean = |pick: fn(&(f32, f32)) -> f32| {
        let parts = slopes.iter().zip(&lengths);
        let shares: Vec<f32> = parts
            .map(|(slope, length)| pick(slope).abs() / length)
            .collect();
        f64::from(quantile(&shares, 0.5))
    };
    let (across_x, across_y) = (lean(|s| s.0), lean(|s| s.1));
    distances.extend(if across_x >= across_y {
        rises(&gains, (width, bars.height), false)
    } else {
        rises(&gains, (width, bars.height), true)
    });
    if distances.len() < LEAST_EDGES {
        return None;
    }
    let distance_px = f64::from(quantile(&distances, 0.5)) * across_x.max(across_y);
    let slope = f64::from(quantile(&lengths, 0.5)).max(1e-6);
    let variance = 1.0 / (std::f64::consts::TAU * slope * slope) - SLOPE_VARIANCE;
    Some(Edges {
        width_px: EDGE_SIGMAS * variance.max(0.0).sqrt(),
        scale: distance_px / patterns::bar_distance_px(axis, raster),
    })
}

/// Rise of the values to the right and downwards, per px.
fn slope(values: &[f32], at: usize, width: usize) -> (f32, f32) {
    (
        (values[at + 1] - values[at - 1]) / 2.0,
        (values[at + width] - values[at - width]) / 2.0,
    )
}

/// Distances from one rise through one half to the next, along rows or down columns, px.
fn rises(gains: &[f32], (width, height): (usize, usize), down: bool) -> Vec<f32> {
    let (lanes, length) = if down {
        (width, height)
    } else {
        (height, width)
    };
    let value = |lane: usize, k: usize| {
        if down {
            gains[k * width + lane]
        } else {
            gains[lane * width + k]
        }
    };
    let mut distances = Vec::new();
    for lane in 0..lanes {
        let mut last: Option<f32> = None;
        for k in 1..length {
            let (before, now) = (value(lane, k - 1), value(lane, k));
            if before.is_nan() || now.is_nan() {
                last = None;
            } else if before < 0.5 && now >= 0.5 {
                let place = k as f32 - 1.0 + (0.5 - before) / (now - before);
                distances.extend(last.map(|last| place - last));
                last = Some(place);
            }
        }
    }
    distances
}

/// Width of the sharpest edges of the scene under its own light and the projector's white; `None` where there are none.
fn scene_edges(black: &Light, lit: &Lit) -> Option<f64> {
    let (width, height) = (black.width, black.height);
    // white alone: what the projector blurs is only the border of its light, which is left out as not usable
    let values: Vec<f32> = lit
        .usable
        .iter()
        .zip(&lit.white)
        .map(|(usable, white)| if *usable { *white } else { f32::NAN })
        .collect();
    let mut widths = Vec::new();
    for y in BESIDE..height.saturating_sub(BESIDE) {
        for x in BESIDE..width.saturating_sub(BESIDE) {
            let at = y * width + x;
            widths.extend(step_width(&values, at, 1));
            widths.extend(step_width(&values, at, width));
        }
    }
    (widths.len() >= LEAST_EDGES).then(|| f64::from(quantile(&widths, 0.1)))
}

/// Width from 10 to 90 % of a step of the scene at a pixel, in one direction, where there is one.
fn step_width(values: &[f32], at: usize, stride: usize) -> Option<f32> {
    let (low, high) = (values[at - BESIDE * stride], values[at + BESIDE * stride]);
    let step = (high - low).abs();
    if step.is_nan() || step < SCENE_STEP * low.max(high) {
        return None;
    }
    let share = (values[at] - low.min(high)) / step;
    let slope = (values[at + stride] - values[at - stride]).abs() / 2.0 / step;
    if !MIDDLE.contains(&share) || slope <= 0.0 {
        return None;
    }
    let variance = 1.0 / (std::f32::consts::TAU * slope * slope) - SLOPE_VARIANCE as f32;
    Some(EDGE_SIGMAS as f32 * variance.max(0.0).sqrt())
}
