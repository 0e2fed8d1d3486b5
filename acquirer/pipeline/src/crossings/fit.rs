//! A crossing refined: the intersection of two curves fitted to its arms.

use nalgebra::{Matrix3, Vector3};
use shared::geometry::CameraPixel;

use super::{Arms, Crossing, CrossingSettings};
use crate::lines::{Lines, Track};

/// Most points that a curve is fitted to, of each arm: more are thinned out.
const MOST_ON_ARM: usize = 64;

/// A place on a line, along and across it, relative to a crossing.
type Point = (f64, f64);

/// Points along and across a line, relative to a crossing; kept on the stack, since there are many crossings.
#[derive(Debug, Clone, Copy)]
struct Points {
    all: [Point; 2 * MOST_ON_ARM],
    count: usize,
}

impl Points {
    const NONE: Self = Self {
        all: [(0.0, 0.0); 2 * MOST_ON_ARM],
        count: 0,
    };

    fn push(&mut self, point: Point) {
        if let Some(place) = self.all.get_mut(self.count) {
            *place = point;
            self.count += 1;
        }
    }

    fn as_slice(&self) -> &[Point] {
        &self.all[..self.count]
    }

    fn retain(&mut self, keep: impl Fn(&Point) -> bool) {
        let mut kept = 0;
        for k in 0..self.count {
            if keep(&self.all[k]) {
                self.all[kept] = self.all[k];
                kept += 1;
            }
        }
        self.count = kept;
    }
}

/// Refines a crossing on its arms; `None` when an arm of each line is missing or the lines run together.
pub(super) fn fit(
    crossing: &Crossing,
    lines: &Lines,
    settings: &CrossingSettings,
    least_sine: f64,
) -> Option<Crossing> {
    let mut refined = crossing.clone();
    let column_track = &lines.columns.tracks[crossing.column.track];
    let row_track = &lines.rows.tracks[crossing.row.track];
    let start = crossing.centre;
    let column = Curve::fit(column_track, start.y, &mut refined.column, settings)?;
    let row = Curve::fit(row_track, start.x, &mut refined.row, settings)?;
    let (mut x, mut y) = (start.x, start.y);
    for _ in 0..10 {
        x = column.at(y - start.y);
        y = row.at(x - start.x);
    }
    refined.column.slope = column.slope(y - start.y);
    refined.row.slope = row.slope(x - start.x);
    let (p, q) = (refined.column.slope, refined.row.slope);
    let sine = (1.0 - p * q).abs() / ((1.0 + p * p) * (1.0 + q * q)).sqrt();
    let moved = (x - start.x).hypot(y - start.y);
    let most = refined.column.inner_px.max(refined.row.inner_px);
    if !(sine >= least_sine && moved <= most) {
        return None;
    }
    refined.centre = CameraPixel::new(x, y);
    Some(refined)
}

/// Whether straight lines through the points before and after 0 meet there. A smooth bend moves both to the
/// same side, so it is no step.
fn continuous((before, after): (&[Point], &[Point]), largest_step_px: f64) -> bool {
    const SIGMAS: f64 = 4.0;
    let at_0 = |arm: &[Point]| {
        let line = Curve::straight(arm)?;
        let n = arm.len() as f64;
        let middle = arm.iter().map(|p| p.0).sum::<f64>() / n;
        let spread: f64 = arm.iter().map(|p| (p.0 - middle).powi(2)).sum();
        let noise = line.misfit(arm) / (n - 2.0).max(1.0);
        Some((line.at(0.0), noise * (1.0 / n + middle * middle / spread)))
    };
    match (at_0(before), at_0(after)) {
        (Some((a, va)), Some((b, vb))) => {
            (a - b).abs() <= largest_step_px + SIGMAS * (va + vb).sqrt()
        }
        _ => false,
    }
}

/// Across as a polynomial of along, around the crossing.
#[derive(Debug, Clone, Copy)]
struct Curve([f64; 3]);

impl Curve {
    fn at(self, t: f64) -> f64 {
        self.0[0] + t * (self.0[1] + t * self.0[2])
    }

    fn slope(self, t: f64) -> f64 {
        self.0[1] + 2.0 * t * self.0[2]
    }

    /// Fits the points of both arms, and notes which arms were seen.
    fn fit(
        track: &Track,
        along: f64,
        arms: &mut Arms,
        settings: &CrossingSettings,
    ) -> Option<Self> {
        const FEWEST: usize = 3;
        let mut points = Points::NONE;
        let mut first_after = 0;
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            first_after = points.count;
            let (near, far) = (
                along + sign * arms.inner_px,
                along + sign * arms.outer_px[side],
            );
            let (from, to) = (near.min(far), near.max(far));
            let expected = ((to - from) / track.spacing_px).max(1.0);
            let every = (expected / MOST_ON_ARM as f64).ceil() as usize;
            let mut seen = 0;
            for k in track.measured(from, to) {
                if seen % every == 0 {
                    points.push((track.along(k) - along, f64::from(track.across[k])));
                }
                seen += 1;
            }
            arms.seen[side] = seen >= FEWEST && seen as f64 >= settings.seen_share * expected;
        }
        let both = arms.seen == [true; 2];
        let sides = points.as_slice().split_at(first_after);
        arms.continuous = both && continuous(sides, settings.largest_step_px);
        if points.count < 2 * FEWEST || !(arms.seen[0] || arms.seen[1]) {
            return None;
        }
        Self::robust(&mut points, both)
    }

    /// Least squares, once more without points beyond three times the median deviation; a parabola only
    /// where it explains much more than a straight line.
    fn robust(points: &mut Points, may_bend: bool) -> Option<Self> {
        let curve = Self::of_points(points.as_slice(), may_bend)?;
        let mut off = [0.0; 2 * MOST_ON_ARM];
        let off = &mut off[..points.count];
        for (off, point) in off.iter_mut().zip(points.as_slice()) {
            *off = (point.1 - curve.at(point.0)).abs();
        }
        let middle = off.len() / 2;
        let (_, median, _) = off.select_nth_unstable_by(middle, f64::total_cmp);
        let limit = (3.0 * 1.483 * *median).max(0.05);
        let near = |p: &Point| (p.1 - curve.at(p.0)).abs() <= limit;
        let kept = points.as_slice().iter().filter(|point| near(point)).count();
        if kept == points.count || kept < 5 {
            return Some(curve);
        }
        points.retain(near);
        Self::of_points(points.as_slice(), may_bend)
    }

    /// Straight, or bent where that explains much more.
    fn of_points(points: &[Point], may_bend: bool) -> Option<Self> {
        /// Ratio of explained to remaining variance that a bend must reach.
        const BEND_EVIDENCE: f64 = 9.0;
        const FEWEST_TO_BEND: usize = 8;
        let straight = Self::straight(points)?;
        if !may_bend || points.len() < FEWEST_TO_BEND {
            return Some(straight);
        }
        let Some(bent) = Self::bent(points) else {
            return Some(straight);
        };
        let (before, after) = (straight.misfit(points), bent.misfit(points));
        let spare = (points.len() - 3) as f64;
        let tells = before - after > BEND_EVIDENCE * (after / spare + 1e-6);
        Some(if tells { bent } else { straight })
    }

    fn misfit(self, points: &[Point]) -> f64 {
        points.iter().map(|p| (p.1 - self.at(p.0)).powi(2)).sum()
    }

    fn straight(points: &[Point]) -> Option<Self> {
        let n = points.len() as f64;
        let (t, x) = points
            .iter()
            .fold((0.0, 0.0), |s, p| (s.0 + p.0, s.1 + p.1));
        let (t, x) = (t / n, x / n);
        let (top, bottom) = points.iter().fold((0.0, 0.0), |s, p| {
            (s.0 + (p.0 - t) * (p.1 - x), s.1 + (p.0 - t) * (p.0 - t))
        });
        (bottom > 0.0).then(|| {
            let slope = top / bottom;
            Self([x - slope * t, slope, 0.0])
        })
    }

    fn bent(points: &[Point]) -> Option<Self> {
        // sums of the powers of t from 0 to 4, and of x times those to 2
        let (mut powers, mut right) = ([0.0; 5], [0.0; 3]);
        for &(t, x) in points {
            let square = t * t;
            let terms = [1.0, t, square, t * square, square * square];
            for (sum, term) in powers.iter_mut().zip(terms) {
                *sum += term;
            }
            for (sum, term) in right.iter_mut().zip(terms) {
                *sum += term * x;
            }
        }
        let normal = Matrix3::from_fn(|row, column| powers[row + column]);
        let solved = normal.cholesky()?.solve(&Vector3::from(right));
        Some(Self([solved[0], solved[1], solved[2]]))
    }
}
