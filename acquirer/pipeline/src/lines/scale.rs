//! How wide the lines are: the scale at which ridges stand out most.
//!
//! A box of width w under a Gaussian second derivative of standard deviation s, times s^2, is strongest at
//! s = w/2 (T. Lindeberg, "Edge detection and ridge detection with automatic scale selection", 1998). A few
//! picture rows suffice. Many different widths in one picture give a middle one.

use pulp::NullaryFnOnce;
use shared::pattern::Axis;

use super::{LineSettings, half_kernel, smoothed_row};
use crate::{
    convolve::{Pair, convolve, pad_ends, wide},
    plane::Plane,
};

/// From one scale to the next.
const STEP: f64 = 1.25;
/// Picture rows (or columns) looked at, spread over the picture.
const ROWS: usize = 16;
/// Weaker ridges are not counted: a full line's is about 0.46 at its own scale, and in the dark noise makes
/// many of some 0.1.
const LEAST_RIDGE: f32 = 0.2;
/// Stronger ones count no more than this: single pixels that are wrong must not outvote the lines.
const MOST_RIDGE: f32 = 0.6;

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
    let kernels: Vec<Vec<f32>> = widths
        .iter()
        .map(|width| ridge_kernel(0.5 * width))
        .collect();
    let pad = (3.0 * widths[widths.len() - 1]).ceil() as usize + 2;
    let ScaleBuffers { row, ridge, votes } = buffers;
    votes.clear();
    votes.resize(widths.len(), 0.0);
    let length = match family {
        Axis::Row => gain.width(),
        Axis::Column => gain.height(),
    };
    let rows = ROWS.min(length);
    for k in 0..rows {
        let at = (2 * k + 1) * length / (2 * rows);
        match family {
            Axis::Row => smoothed_column(gain, at, &along, pad, row),
            Axis::Column => smoothed_row(gain, at, &along, pad, row),
        }
        wide(RowVotes {
            row,
            pad,
            kernels: &kernels,
            ridge,
            votes,
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
    pad_ends(out, pad);
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

/// The votes of one padded row for each scale.
struct RowVotes<'a> {
    row: &'a [f32],
    pad: usize,
    kernels: &'a [Vec<f32>],
    ridge: &'a mut Vec<f32>,
    votes: &'a mut [f64],
}

impl NullaryFnOnce for RowVotes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.ridge.resize(self.row.len() - 2 * self.pad, 0.0);
        for (vote, kernel) in self.votes.iter_mut().zip(self.kernels) {
            convolve(self.ridge, kernel, Pair::Sum, |k| {
                (&self.row[self.pad - k..], &self.row[self.pad + k..])
            });
            *vote += strongest(self.ridge);
        }
    }
}

/// Sum of the cubes of the local maxima, so that many weak ones (noise) count less than lines.
#[inline(always)]
fn strongest(ridge: &[f32]) -> f64 {
    const LANES: usize = 8; // sums side by side, so that they can be added up in one go
    let mut sums = [0.0f32; LANES];
    let middles = ridge.len().saturating_sub(2);
    let parts = [0, 1, 2].map(|shift| &ridge[shift.min(ridge.len())..][..middles]);
    let blocks = parts.map(|part| part.chunks_exact(LANES));
    let [before, here, after] = blocks;
    for ((before, here), after) in before.zip(here).zip(after) {
        for (lane, sum) in sums.iter_mut().enumerate() {
            let h = here[lane];
            let peak = (h > LEAST_RIDGE) & (h >= before[lane]) & (h > after[lane]);
            let h = h.min(MOST_RIDGE);
            *sum += if peak { h * h * h } else { 0.0 };
        }
    }
    sums.iter().map(|&sum| f64::from(sum)).sum()
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
