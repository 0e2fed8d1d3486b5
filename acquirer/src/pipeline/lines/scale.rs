//! How wide the lines are: the scale at which ridges stand out most.
//!
//! A box of width w under a Gaussian second derivative of standard deviation s, times s^2, is strongest at
//! s = w/2 (T. Lindeberg, "Edge detection and ridge detection with automatic scale selection", 1998). A few
//! picture rows suffice. Many different widths in one picture give a middle one.

use pulp::Arch;
use shared::pattern::Axis;

use super::{LineSettings, half_kernel, smoothed_row};
use crate::pipeline::plane::Plane;

/// From one scale to the next.
const STEP: f64 = 1.25;
/// Picture rows (or columns) looked at, spread over the picture.
const ROWS: usize = 24;

/// What the scale search keeps between frames.
#[derive(Debug, Default)]
pub(super) struct ScaleBuffers {
    row: Vec<f32>,
    ridge: Vec<f32>,
    votes: Vec<f64>,
}

/// The typical width of one family's lines across x (steep lines) or y (flat ones), in pixels, within the
/// settings' range.
pub(super) fn line_width(
    gain: &Plane,
    family: Axis,
    settings: &LineSettings,
    buffers: &mut ScaleBuffers,
) -> f64 {
    let narrowest = settings.narrowest_px.clamp(1.6, 64.0);
    let widest = settings.widest_px.clamp(narrowest, 64.0);
    if gain.width() < 3 || gain.height() < 3 {
        return narrowest;
    }
    let along = half_kernel(settings.smooth_along_px.clamp(0.5, 5.0), false);
    let scales = ((widest / narrowest).ln() / STEP.ln()).ceil() as i32 + 1;
    let widths: Vec<f64> = (0..scales).map(|k| narrowest * STEP.powi(k)).collect();
    let kernels: Vec<Vec<f32>> = widths.iter().map(|width| ridge_kernel(0.5 * width)).collect();
    let pad = (3.0 * widths[widths.len() - 1]).ceil() as usize + 2;
    let ScaleBuffers { row, ridge, votes } = buffers;
    votes.clear();
    votes.resize(widths.len(), 0.0);
    let length = match family {
        Axis::Row => gain.width(),
        Axis::Column => gain.height(),
    };
    let rows = ROWS.min(length);
    let arch = Arch::new();
    for k in 0..rows {
        let at = (2 * k + 1) * length / (2 * rows);
        match family {
            Axis::Row => smoothed_column(gain, at, &along, pad, row),
            Axis::Column => smoothed_row(gain, at, &along, pad, row),
        }
        arch.dispatch(|| {
            for (vote, kernel) in votes.iter_mut().zip(&kernels) {
                ridge_row(row, pad, kernel, ridge);
                *vote += strongest(ridge);
            }
        });
    }
    refine(&widths, votes)
}

/// As [`smoothed_row`], for a column of the picture.
fn smoothed_column(plane: &Plane, x: usize, along: &[f32], pad: usize, out: &mut Vec<f32>) {
    let last = plane.width() - 1;
    out.clear();
    out.resize(plane.height() + 2 * pad, 0.0);
    for (y, sum) in out[pad..pad + plane.height()].iter_mut().enumerate() {
        let row = plane.row(y);
        for (k, &weight) in along.iter().enumerate() {
            let weight = if k == 0 { 0.5 * weight } else { weight };
            *sum += weight * (row[x.saturating_sub(k)] + row[(x + k).min(last)]);
        }
    }
    let (first, end) = (out[pad], out[pad + plane.height() - 1]);
    out[..pad].fill(first);
    out[pad + plane.height()..].fill(end);
}

/// -s^2 times a Gaussian's second derivative, without mean.
fn ridge_kernel(sigma: f64) -> Vec<f32> {
    let gauss = half_kernel(sigma, false);
    let second = |k: usize| 1.0 - (k as f64 / sigma).powi(2);
    // what sampling leaves of the kernel's sum would let a flat picture look like a line
    let sum: f64 = f64::from(gauss[0])
        + 2.0
            * (1..gauss.len())
                .map(|k| second(k) * f64::from(gauss[k]))
                .sum::<f64>();
    let weights = gauss.iter().enumerate();
    weights
        .map(|(k, &g)| ((second(k) - sum) * f64::from(g)) as f32)
        .collect()
}

/// A padded row convolved with half a symmetric kernel.
#[inline(always)]
fn ridge_row(row: &[f32], pad: usize, kernel: &[f32], out: &mut Vec<f32>) {
    let width = row.len() - 2 * pad;
    out.clear();
    out.resize(width, 0.0);
    for (k, &weight) in kernel.iter().enumerate() {
        let weight = if k == 0 { 0.5 * weight } else { weight };
        let (left, right) = (
            &row[pad - k..pad - k + width],
            &row[pad + k..pad + k + width],
        );
        for ((v, &a), &b) in out.iter_mut().zip(left).zip(right) {
            *v += weight * (a + b);
        }
    }
}

/// Cubes of the local maxima, so that many weak ones (noise) count less than lines.
fn strongest(ridge: &[f32]) -> f64 {
    ridge
        .windows(3)
        .filter(|v| v[1] > 0.0 && v[1] >= v[0] && v[1] > v[2])
        .map(|v| f64::from(v[1]).powi(3))
        .sum()
}

/// The maximum of the votes, between the scales by a parabola.
fn refine(widths: &[f64], votes: &[f64]) -> f64 {
    let best = (0..votes.len()).fold(0, |best, k| if votes[k] > votes[best] { k } else { best });
    if best == 0 || best + 1 == votes.len() {
        return widths[best];
    }
    let (a, b, c) = (votes[best - 1], votes[best], votes[best + 1]);
    let bend = a - 2.0 * b + c;
    let offset = if bend < 0.0 {
        (0.5 * (a - c) / bend).clamp(-0.5, 0.5)
    } else {
        0.0
    };
    widths[best] * STEP.powf(offset)
}
