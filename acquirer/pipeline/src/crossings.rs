//! Where the lines of both families cross, to a few hundredths of a pixel.
//!
//! Takes the tracks, gives each crossing of a column and a row with its arms: the four stretches of line
//! around it, without the crossing's own zone, where the two profiles disturb each other. The crossing is
//! the intersection of two local fits (straight, or a parabola where the data ask for it) to the arms'
//! points. It counts as whole when all four arms were really seen. Where a line bends sharply at the crossing
//! (a fold of the surface) the fits round the corner off quietly.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use shared::{geometry::CameraPixel, pattern::Axis};

use super::lines::{Lines, Track};

/// How crossings are found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CrossingSettings {
    /// Ends of the arms, as a share of the way to the next crossing, 0.2 to 1.
    pub reach: f64,
    /// Left out beside the other line's edge, in camera pixels, 0 to 10.
    pub margin_px: f64,
    /// Share of an arm's pixels that must have been seen for the arm to count, 0 to 1.
    pub seen_share: f64,
    /// Largest step between the two arms of one line where they meet, in camera pixels, 0.1 to 5: more is
    /// an edge in depth, not one line. Noise is allowed for.
    pub largest_step_px: f64,
    /// Smallest angle between the two lines, in degrees, 5 to 80.
    pub least_angle_deg: f64,
}

impl Default for CrossingSettings {
    fn default() -> Self {
        Self {
            reach: 0.5,
            margin_px: 1.5,
            seen_share: 0.5,
            largest_step_px: 0.6,
            least_angle_deg: 25.0,
        }
    }
}

/// Two arms of one line at a crossing: before and after it along the line.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Arms {
    /// Index of the line's track in its family.
    pub track: usize,
    /// Pixels left out around the crossing, along the line.
    pub inner_px: f64,
    /// Ends of the arms along the line, in pixels from the crossing.
    pub outer_px: [f64; 2],
    /// Which arms were seen.
    pub seen: [bool; 2],
    /// Whether one arm goes on where the other ends.
    pub continuous: bool,
    /// Across per pixel along, at the crossing.
    pub slope: f64,
}

/// A column and a row that cross.
#[derive(Debug, Clone, PartialEq)]
pub struct Crossing {
    /// Where their middles meet.
    pub centre: CameraPixel,
    /// The flat line's arms (left, right).
    pub row: Arms,
    /// The steep line's arms (above, below).
    pub column: Arms,
}

impl Crossing {
    /// The arms of one line.
    #[must_use]
    pub fn arms(&self, axis: Axis) -> &Arms {
        match axis {
            Axis::Row => &self.row,
            Axis::Column => &self.column,
        }
    }

    /// Position along a line of this direction.
    #[must_use]
    pub fn along(&self, axis: Axis) -> f64 {
        match axis {
            Axis::Row => self.centre.x,
            Axis::Column => self.centre.y,
        }
    }

    /// Whether all four arms were seen and each line goes on through the crossing.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        let whole = |arms: &Arms| arms.seen == [true; 2] && arms.continuous;
        whole(&self.row) && whole(&self.column)
    }
}

/// All crossings, and their order along each line.
#[derive(Debug, Clone, Default)]
pub struct Crossings {
    /// The crossings, column track by column track, downwards.
    pub all: Vec<Crossing>,
    /// For each flat track its crossings from left to right.
    pub on_rows: Vec<Vec<usize>>,
    /// For each steep track its crossings from top to bottom.
    pub on_columns: Vec<Vec<usize>>,
}

impl Crossings {
    /// The crossings along each track of one direction.
    #[must_use]
    pub fn on(&self, axis: Axis) -> &[Vec<usize>] {
        match axis {
            Axis::Row => &self.on_rows,
            Axis::Column => &self.on_columns,
        }
    }
}

/// Finds the crossings of the lines.
#[must_use]
pub fn find_crossings(lines: &Lines, settings: &CrossingSettings) -> Crossings {
    let mut crossings = Crossings {
        all: meetings(lines),
        ..Crossings::default()
    };
    order(&mut crossings, lines);
    set_arms(&mut crossings, lines, settings);
    let least_sine = settings.least_angle_deg.to_radians().sin();
    let fitted: Vec<Option<Crossing>> = crossings
        .all
        .par_iter()
        .map(|crossing| fit(crossing, lines, settings, least_sine))
        .collect();
    crossings.all = fitted.into_iter().flatten().collect();
    order(&mut crossings, lines);
    crossings
}

/// How far lines are prolonged to meet another, in pixels beyond the other line's half width.
const PROLONG_PX: f64 = 3.0;

/// Rough intersections of all tracks.
fn meetings(lines: &Lines) -> Vec<Crossing> {
    let beyond = [
        0.5 * lines.columns.width_px + PROLONG_PX,
        0.5 * lines.rows.width_px + PROLONG_PX,
    ];
    let row_spans: Vec<(f32, f32)> = lines.rows.tracks.iter().map(Track::span).collect();
    let found: Vec<Vec<Crossing>> = lines
        .columns
        .tracks
        .par_iter()
        .enumerate()
        .map(|(c, column)| {
            let span = column.span();
            let mut found = Vec::new();
            for (r, row) in lines.rows.tracks.iter().enumerate() {
                if apart(
                    column,
                    span,
                    row,
                    row_spans[r],
                    beyond[0].max(beyond[1]) as f32,
                ) {
                    continue;
                }
                if let Some(centre) = meet(column, row, beyond) {
                    found.push(rough(centre, r, c));
                }
            }
            found
        })
        .collect();
    found.into_iter().flatten().collect()
}

fn rough(centre: CameraPixel, row: usize, column: usize) -> Crossing {
    let arms = |track| Arms {
        track,
        ..Arms::default()
    };
    Crossing {
        centre,
        row: arms(row),
        column: arms(column),
    }
}

/// Whether the rectangles around two tracks keep more than `margin` pixels between them.
fn apart(column: &Track, x: (f32, f32), row: &Track, y: (f32, f32), margin: f32) -> bool {
    let beyond = |span: (f32, f32), (from, to): (f64, f64)| {
        span.1 < from as f32 - margin || span.0 > to as f32 + margin
    };
    beyond(x, row.stretch_px()) || beyond(y, column.stretch_px())
}

/// Where two tracks meet, by going from one to the other in turn.
fn meet(column: &Track, row: &Track, [row_beyond, column_beyond]: [f64; 2]) -> Option<CameraPixel> {
    const ROUNDS: usize = 20;
    const SETTLED_PX: f64 = 0.02;
    let clamp =
        |v: f64, track: &Track| v.clamp(track.along(0), track.along(track.across.len() - 1));
    let middle_x = clamp(f64::from(column.across[column.across.len() / 2]), row);
    let mut y = clamp(row.at(middle_x, row_beyond)?, column);
    for _ in 0..ROUNDS {
        let x = column.at(y, column_beyond)?;
        let on_row = row.at(clamp(x, row), row_beyond)?;
        let next = clamp(on_row, column);
        if (next - y).abs() < SETTLED_PX {
            let x = column.at(next, column_beyond)?;
            let y = row.at(x, row_beyond)?;
            let x = column.at(y, column_beyond)?;
            return Some(CameraPixel::new(x, y));
        }
        y = 0.5 * (y + next); // halves the step so that steep pairs settle too
    }
    None
}

/// Sorts the crossings along each track and leaves out all but one of those that coincide.
fn order(crossings: &mut Crossings, lines: &Lines) {
    const SAME_PX: f64 = 2.0;
    for axis in Axis::BOTH {
        let mut on = sorted(crossings, lines, axis);
        let mut double = vec![false; crossings.all.len()];
        let length = |k: usize| {
            let other = match axis {
                Axis::Row => Axis::Column,
                Axis::Column => Axis::Row,
            };
            let track = crossings.all[k].arms(other).track;
            lines.family(other).tracks[track].across.len()
        };
        for track in &mut on {
            for pair in 1..track.len() {
                let (a, b) = (track[pair - 1], track[pair]);
                let distance = crossings.all[b].along(axis) - crossings.all[a].along(axis);
                if distance < SAME_PX {
                    double[if length(a) < length(b) { a } else { b }] = true;
                }
            }
        }
        let mut at = 0;
        crossings.all.retain(|_| {
            at += 1;
            !double[at - 1]
        });
    }
    crossings.on_rows = sorted(crossings, lines, Axis::Row);
    crossings.on_columns = sorted(crossings, lines, Axis::Column);
}

fn sorted(crossings: &Crossings, lines: &Lines, axis: Axis) -> Vec<Vec<usize>> {
    let mut on = vec![Vec::new(); lines.family(axis).tracks.len()];
    for (k, crossing) in crossings.all.iter().enumerate() {
        on[crossing.arms(axis).track].push(k);
    }
    for track in &mut on {
        track.sort_by(|&a, &b| {
            let along = |k: usize| crossings.all[k].along(axis);
            along(a).total_cmp(&along(b)).then(a.cmp(&b))
        });
    }
    on
}

/// The middle of all gaps between neighbours on the lines of one direction; 0 when there are none.
#[must_use]
pub fn median_gap(crossings: &Crossings, axis: Axis) -> f64 {
    let mut gaps: Vec<f64> = Vec::new();
    for track in crossings.on(axis) {
        let along = |k: usize| crossings.all[k].along(axis);
        gaps.extend(track.windows(2).map(|pair| along(pair[1]) - along(pair[0])));
    }
    gaps.sort_by(f64::total_cmp);
    gaps.get(gaps.len() / 2).copied().unwrap_or(0.0)
}

/// Beside a line the derivative's kernel looks so many of its widths up and down, where a leaning line that
/// crosses comes into view before it is met.
const DISTURBED_WIDTHS: f64 = 1.3;

fn set_arms(crossings: &mut Crossings, lines: &Lines, settings: &CrossingSettings) {
    let reach = settings.reach.clamp(0.2, 1.0);
    for axis in Axis::BOTH {
        let typical = median_gap(crossings, axis);
        let other = match axis {
            Axis::Row => Axis::Column,
            Axis::Column => Axis::Row,
        };
        let other_width = lines.family(other).width_px;
        let undisturbed = 0.5 * other_width + settings.margin_px;
        let lean_reach = DISTURBED_WIDTHS * lines.family(axis).width_px;
        for track in crossings.on(axis).to_vec() {
            let along: Vec<f64> = track
                .iter()
                .map(|&k| crossings.all[k].along(axis))
                .collect();
            for (at, &k) in track.iter().enumerate() {
                let before = if at > 0 {
                    along[at] - along[at - 1]
                } else {
                    f64::MAX
                };
                let after = along.get(at + 1).map_or(f64::MAX, |next| next - along[at]);
                let crossing = &crossings.all[k];
                let lean = lines.family(other).tracks[crossing.arms(other).track]
                    .slope(crossing.along(other))
                    .abs();
                let inner_px = undisturbed + lean_reach * lean;
                let shortest = inner_px + 4.0;
                let longest = if typical > 0.0 {
                    1.5 * typical
                } else {
                    8.0 * other_width
                };
                let arm = |gap: f64| (reach * gap.min(longest)).max(shortest);
                // at the end of a line the gap on the other side tells the pitch
                let fallback = before.min(after).min(longest);
                let outer = |gap: f64| arm(if gap == f64::MAX { fallback } else { gap });
                let crossing = &mut crossings.all[k];
                let arms = match axis {
                    Axis::Row => &mut crossing.row,
                    Axis::Column => &mut crossing.column,
                };
                arms.inner_px = inner_px;
                arms.outer_px = [outer(before), outer(after)];
            }
        }
    }
}

/// Refines a crossing on its arms; `None` when an arm of each line is missing or the lines run together.
fn fit(
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
fn continuous(points: &[(f64, f64)], largest_step_px: f64) -> bool {
    const SIGMAS: f64 = 4.0;
    let (before, after): (Vec<_>, Vec<_>) = points.iter().partition(|point| point.0 < 0.0);
    let at_0 = |arm: &[(f64, f64)]| {
        let line = Curve::straight(arm)?;
        let n = arm.len() as f64;
        let middle = arm.iter().map(|p| p.0).sum::<f64>() / n;
        let spread: f64 = arm.iter().map(|p| (p.0 - middle).powi(2)).sum();
        let noise = line.misfit(arm) / (n - 2.0).max(1.0);
        Some((line.at(0.0), noise * (1.0 / n + middle * middle / spread)))
    };
    match (at_0(&before), at_0(&after)) {
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
        let mut points = Vec::new();
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let before = points.len();
            let outer = arms.outer_px[side];
            let (near, far) = (along + sign * arms.inner_px, along + sign * outer);
            let (from, to) = (near.min(far), near.max(far));
            let expected = ((to - from) / track.spacing_px).max(1.0);
            points.extend(
                track
                    .measured(from, to)
                    .map(|k| (track.along(k) - along, f64::from(track.across[k]))),
            );
            let seen = points.len() - before;
            arms.seen[side] = seen >= FEWEST && seen as f64 >= settings.seen_share * expected;
        }
        let both = arms.seen == [true; 2];
        arms.continuous = both && continuous(&points, settings.largest_step_px);
        if points.len() < 2 * FEWEST || !(arms.seen[0] || arms.seen[1]) {
            return None;
        }
        Self::robust(&mut points, both)
    }

    /// Least squares, once more without points beyond three times the median deviation; a parabola only
    /// where it explains much more than a straight line.
    fn robust(points: &mut Vec<(f64, f64)>, may_bend: bool) -> Option<Self> {
        /// Ratio of explained to remaining variance that a bend must reach.
        const BEND_EVIDENCE: f64 = 9.0;
        const FEWEST_TO_BEND: usize = 8;
        let mut curve = Self::straight(points)?;
        for _ in 0..2 {
            curve = Self::straight(points)?;
            if may_bend
                && points.len() >= FEWEST_TO_BEND
                && let Some(bent) = Self::bent(points)
            {
                let (before, after) = (curve.misfit(points), bent.misfit(points));
                let spare = (points.len() - 3) as f64;
                if before - after > BEND_EVIDENCE * (after / spare + 1e-6) {
                    curve = bent;
                }
            }
            let mut off: Vec<f64> = points.iter().map(|p| (p.1 - curve.at(p.0)).abs()).collect();
            let middle = off.len() / 2;
            let (_, median, _) = off.select_nth_unstable_by(middle, f64::total_cmp);
            let limit = (3.0 * 1.483 * *median).max(0.05);
            let kept = points
                .iter()
                .filter(|p| (p.1 - curve.at(p.0)).abs() <= limit)
                .count();
            if kept == points.len() || kept < 5 {
                break;
            }
            points.retain(|p| (p.1 - curve.at(p.0)).abs() <= limit);
        }
        Some(curve)
    }

    fn misfit(self, points: &[(f64, f64)]) -> f64 {
        points.iter().map(|p| (p.1 - self.at(p.0)).powi(2)).sum()
    }

    fn straight(points: &[(f64, f64)]) -> Option<Self> {
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

    fn bent(points: &[(f64, f64)]) -> Option<Self> {
        let mut normal = nalgebra::Matrix3::<f64>::zeros();
        let mut right = nalgebra::Vector3::<f64>::zeros();
        for &(t, x) in points {
            let row = nalgebra::Vector3::new(1.0, t, t * t);
            normal += row * row.transpose();
            right += row * x;
        }
        let solved = normal.cholesky()?.solve(&right);
        Some(Self([solved[0], solved[1], solved[2]]))
    }
}
