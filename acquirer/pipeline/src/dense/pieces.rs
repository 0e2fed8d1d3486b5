//! Stretches of lines made into unbroken pieces: small gaps are filled by a fit on both arms, others are cut.
//!
//! Takes stretches in the order they were followed. A gap is filled when a labelled crossing of the line lies in
//! it and it is no longer than a crossing zone, or when it has a few pixels only, and when one parabola passes
//! through the points on both sides. Crumbs of a line within a crossing are the other line's as much as its own and
//! count as gap.

use super::{Sample, Stretch, ends::disturbed_px};
use crate::grid::DecodedGrid;

/// Longest gap without a crossing in it that is filled, camera px.
const SHORT_GAP_PX: f64 = 4.0;

/// Points on either side of a gap that the parabola is fitted to, at most, and at least.
const ARM: usize = 12;
const LEAST_ARM: usize = 4;

/// Largest distance (root mean square) of the arms from the parabola, camera px. Two surfaces miss each other
/// by more, or by too little to matter.
const FIT_PX: f64 = 0.3;

/// Largest change of direction from one pixel to the next, camera px across: more is a step of the surface.
const STEP_PX: f64 = 1.2;

/// Smoothing along a line carries its ridge on over its end, where the light already comes from elsewhere: points
/// taken off each end of a piece.
const OVER_END: usize = 2;

/// Shortest piece worth keeping, points.
const LEAST_POINTS: usize = 3;

/// Joins, fills and cuts.
pub(super) fn unbroken(stretches: Vec<Stretch>, grid: &DecodedGrid) -> Vec<Stretch> {
    let mut pieces: Vec<Stretch> = Vec::new();
    for stretch in stretches {
        let zones = zones(&stretch, grid);
        let crumb = |run: &Stretch| {
            run.samples.len() < LEAST_ARM
                && zones
                    .iter()
                    .any(|zone| run.samples.iter().all(|s| is_in(s.along, zone)))
        };
        for run in runs(stretch).into_iter().filter(|run| !crumb(run)) {
            let joined = pieces
                .last_mut()
                .is_some_and(|piece| join(piece, &run, &zones));
            if !joined {
                pieces.push(run);
            }
        }
    }
    for piece in &mut pieces {
        let samples = &mut piece.samples;
        samples.truncate(samples.len().saturating_sub(OVER_END));
        samples.drain(..OVER_END.min(samples.len()));
    }
    pieces.retain(|piece| piece.samples.len() >= LEAST_POINTS);
    pieces
}

/// Where other lines cross and disturb this one: from and to along the stretch, camera px.
fn zones(stretch: &Stretch, grid: &DecodedGrid) -> Vec<(f64, f64)> {
    let crossings = grid
        .placed()
        .filter(|c| c.index.line(stretch.axis) == stretch.line);
    crossings
        .map(|crossing| {
            let centre = stretch.way.turn(crossing.centre).0;
            let half = disturbed_px(crossing, stretch.axis, stretch.way);
            (centre - half, centre + half)
        })
        .collect()
}

/// A stretch cut at every gap and every step.
fn runs(stretch: Stretch) -> Vec<Stretch> {
    let Stretch {
        axis,
        line,
        way,
        samples,
    } = stretch;
    let mut runs: Vec<Vec<Sample>> = Vec::new();
    for sample in samples {
        match runs.last_mut() {
            Some(run) if goes_on(run, sample) => run.push(sample),
            _ => runs.push(vec![sample]),
        }
    }
    runs.into_iter()
        .map(|samples| Stretch {
            axis,
            line,
            way,
            samples,
        })
        .collect()
}

/// Whether a sample is the next pixel of a run, without a step aside.
fn goes_on(run: &[Sample], next: Sample) -> bool {
    let last = run[run.len() - 1];
    let before = run[run.len().saturating_sub(4)];
    let slope = (last.across - before.across) / (last.along - before.along).max(1.0);
    let step = next.across - last.across - slope;
    let gap = next.along - last.along;
    gap > 0.0 && gap <= 1.5 && step.abs() <= STEP_PX
}

fn is_in(along: f64, &(from, to): &(f64, f64)) -> bool {
    (from..=to).contains(&along)
}

/// Adds a run to the piece before it when the gap between them can be filled.
fn join(piece: &mut Stretch, run: &Stretch, zones: &[(f64, f64)]) -> bool {
    let same = piece.axis == run.axis && piece.line == run.line && piece.way == run.way;
    let (last, first) = (piece.samples[piece.samples.len() - 1], run.samples[0]);
    let gap = first.along - last.along;
    if !same || gap <= 0.0 {
        return false;
    }
    let crossing = zones
        .iter()
        .any(|zone| is_in(last.along, zone) && is_in(first.along, zone));
    if gap > SHORT_GAP_PX + 1.0 && !crossing {
        return false;
    }
    let tail = &piece.samples[piece.samples.len().saturating_sub(ARM)..];
    let head = &run.samples[..run.samples.len().min(ARM)];
    let Some(parabola) = Parabola::through(tail, head) else {
        return false;
    };
    let mut along = last.along + 1.0;
    while along < first.along - 0.5 {
        let share = (along - last.along) / gap;
        piece.samples.push(Sample {
            along,
            across: parabola.at(along),
            half_width_px: last.half_width_px + share * (first.half_width_px - last.half_width_px),
            confidence: last.confidence.min(first.confidence),
        });
        along += 1.0;
    }
    piece.samples.extend(&run.samples);
    true
}

/// across = a + b t + c t^2 with t = along - origin.
struct Parabola {
    origin: f64,
    coefficients: nalgebra::Vector3<f64>,
}

impl Parabola {
    /// Least squares through both arms; `None` when they are too short or not on one parabola.
    fn through(tail: &[Sample], head: &[Sample]) -> Option<Self> {
        if tail.len() < LEAST_ARM || head.len() < LEAST_ARM {
            return None;
        }
        let origin = 0.5 * (tail[tail.len() - 1].along + head[0].along);
        let (mut normal, mut right) = (nalgebra::Matrix3::zeros(), nalgebra::Vector3::zeros());
        for sample in tail.iter().chain(head) {
            let t = sample.along - origin;
            let row = nalgebra::Vector3::new(1.0, t, t * t);
            normal += row * row.transpose();
            right += row * sample.across;
        }
        let coefficients = normal.cholesky()?.solve(&right);
        let fit = Self {
            origin,
            coefficients,
        };
        let off = |s: &Sample| (s.across - fit.at(s.along)).powi(2);
        let sum: f64 = tail.iter().chain(head).map(off).sum();
        let rms = (sum / (tail.len() + head.len()) as f64).sqrt();
        (rms <= FIT_PX).then_some(fit)
    }

    fn at(&self, along: f64) -> f64 {
        let t = along - self.origin;
        let [a, b, c] = self.coefficients.into();
        a + t * (b + t * c)
    }
}
