//! How far each point of a line moved between the stages, along the epipolar direction.
//!
//! Takes the dense lines of both stages and the epipolar directions, gives a [`LineShift`] for each point of the
//! object's lines whose line was read in the background where it crosses the epipolar line through the point.
//! Along the line alone the correspondence is open (aperture problem); the epipolar direction closes it. Lines
//! within 30 degrees of that direction are left out, since the meeting is then too uncertain. Nothing is
//! interpolated between pieces of a line. The part of a vertex's shift across the direction is pure error:
//! [`Across`] is its size.

use std::collections::BTreeMap;

use shared::{geometry::CameraPixel, pattern::Axis};

use super::{
    Shift,
    epipolar::{DirectionSource, Epipolar, MOVED_PX, robust_sigma},
};
use crate::dense::DenseLine;

/// Smallest sine of the angle between a line and the epipolar direction for the line's points to count
/// (30 degrees): below it the depth error more than doubles.
pub(crate) const LEAST_SINE: f64 = 0.5;
/// A vertex is rejected when its error across is larger than this many standard deviations.
const REJECT_SIGMA: f64 = 3.0;
/// Least standard deviation across, camera px: what a good crossing has.
const LEAST_SIGMA_PX: f64 = 0.02;

/// One point of a line with the object, and how far it moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineShift {
    /// Which way the line runs.
    pub axis: Axis,
    /// Which line, from 0.
    pub line: u16,
    /// Where it stands with the object.
    pub at: CameraPixel,
    /// Displacement along the epipolar direction, camera px; positive towards nearer surfaces.
    pub shift_px: f64,
    /// Relative depth: shift times the rig's factor.
    pub depth: f64,
    /// The smaller confidence of both points, 0 to 1.
    pub confidence: f64,
}

/// The part of the vertices' shifts that depth can't explain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Across {
    /// Vertices that moved by more than a pixel.
    pub moved: usize,
    /// Root mean square across the epipolar direction over those that are not rejected, camera px.
    pub rms_px: f64,
    /// Vertices whose error is more than three standard deviations.
    pub rejected: usize,
}

/// A vertex's shift along and across the epipolar direction, in the order of the shifts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SplitShift {
    /// Along, camera px: depth; positive towards nearer surfaces.
    pub along_px: f64,
    /// Across, camera px: error.
    pub across_px: f64,
    /// Whether the error is more than three standard deviations.
    pub rejected: bool,
}

/// All that is known about shifts along the epipolar direction.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LineShifts {
    /// Where the direction comes from; `None` when too little moved to tell.
    pub source: Option<DirectionSource>,
    /// One for each vertex's shift, in their order; empty without a direction.
    pub vertices: Vec<SplitShift>,
    /// How large the error across is, if anything moved.
    pub across: Option<Across>,
    /// The points of the object's lines.
    pub points: Vec<LineShift>,
    /// Points of the object's lines along the epipolar direction, which have no shift.
    pub along_epipolar: usize,
    /// Points of the object's lines whose line was not read where it should be in the background.
    pub not_in_background: usize,
}

/// Splits the vertices' shifts and finds those of all line points.
#[must_use]
pub fn find_line_shifts(
    [background, object]: [&[DenseLine]; 2],
    shifts: &[Shift],
    epipolar: Option<Epipolar<'_>>,
    depth_per_px: f64,
) -> LineShifts {
    let Some(epipolar) = epipolar else {
        return LineShifts::default();
    };
    let (vertices, across) = split_vertices(shifts, &epipolar);
    let mut found = LineShifts {
        source: Some(epipolar.source()),
        vertices,
        across,
        ..LineShifts::default()
    };
    let mut before: BTreeMap<(bool, u16), Vec<&DenseLine>> = BTreeMap::new();
    for line in background {
        let key = (line.axis == Axis::Row, line.line);
        before.entry(key).or_default().push(line);
    }
    for line in object {
        let same = before.get(&(line.axis == Axis::Row, line.line));
        let same = same.map_or(&[][..], Vec::as_slice);
        shift_line(line, same, &epipolar, depth_per_px, &mut found);
    }
    found
}

fn split_vertices(shifts: &[Shift], epipolar: &Epipolar<'_>) -> (Vec<SplitShift>, Option<Across>) {
    let parts: Vec<[f64; 2]> = shifts
        .iter()
        .map(|s| epipolar.split(s.before, s.after).unwrap_or([0.0, 0.0]))
        .collect();
    let moved: Vec<f64> = parts
        .iter()
        .zip(shifts)
        .filter(|(_, shift)| shift.shift_px > MOVED_PX)
        .map(|([_, across], _)| across.abs())
        .collect();
    let sigma = robust_sigma(&moved).map(|sigma| sigma.max(LEAST_SIGMA_PX));
    let limit = sigma.map_or(f64::MAX, |sigma| REJECT_SIGMA * sigma);
    let split = parts.iter().map(|&[along_px, across_px]| SplitShift {
        along_px,
        across_px,
        rejected: across_px.abs() > limit,
    });
    let split: Vec<SplitShift> = split.collect();
    let kept: Vec<f64> = moved.iter().copied().filter(|a| *a <= limit).collect();
    let across = sigma.map(|_| Across {
        moved: moved.len(),
        rms_px: (kept.iter().map(|a| a * a).sum::<f64>() / kept.len().max(1) as f64).sqrt(),
        rejected: split.iter().filter(|s| s.rejected).count(),
    });
    (split, across)
}

fn shift_line(
    line: &DenseLine,
    before: &[&DenseLine],
    epipolar: &Epipolar<'_>,
    depth_per_px: f64,
    found: &mut LineShifts,
) {
    for (k, point) in line.points.iter().enumerate() {
        let Some(direction) = epipolar.direction(point.position) else {
            continue;
        };
        if sine(line, k, direction) < LEAST_SINE {
            found.along_epipolar += 1;
            continue;
        }
        let meeting = before
            .iter()
            .filter_map(|other| meet(other, point.position, direction))
            .min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        let Some((back_px, confidence)) = meeting else {
            found.not_in_background += 1;
            continue;
        };
        found.points.push(LineShift {
            axis: line.axis,
            line: line.line,
            at: point.position,
            shift_px: -back_px,
            depth: -back_px * depth_per_px,
            confidence: confidence.min(point.confidence),
        });
    }
}

/// Sine of the angle between a line at its point `k` and a unit direction.
pub(crate) fn sine(line: &DenseLine, k: usize, [dx, dy]: [f64; 2]) -> f64 {
    let a = line.points[k.saturating_sub(2)].position;
    let b = line.points[(k + 2).min(line.points.len() - 1)].position;
    let (x, y) = (b.x - a.x, b.y - a.y);
    (x * dy - y * dx).abs() / x.hypot(y).max(1e-9)
}

/// Where the straight line through a point meets a dense line nearest to it: distance along, confidence.
fn meet(line: &DenseLine, from: CameraPixel, [dx, dy]: [f64; 2]) -> Option<(f64, f64)> {
    let off = |p: CameraPixel| (p.x - from.x) * dy - (p.y - from.y) * dx;
    let pairs = line.points.windows(2);
    let meetings = pairs.filter_map(|pair| {
        let (a, b) = (pair[0].position, pair[1].position);
        let (off_a, off_b) = (off(a), off(b));
        if (off_a > 0.0) == (off_b > 0.0) {
            return None;
        }
        let share = off_a / (off_a - off_b);
        let (x, y) = (a.x + share * (b.x - a.x), a.y + share * (b.y - a.y));
        let along = (x - from.x) * dx + (y - from.y) * dy;
        Some((along, pair[0].confidence.min(pair[1].confidence)))
    });
    meetings.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{grid::LinePoint, shift::epipolar::from_shifts};
    use shared::pattern::{Corner, GridIndex};

    /// A place and the same place nearer: everything moves away from an epipole at (-700, 900).
    fn moved(x: f64, y: f64, share: f64) -> [CameraPixel; 2] {
        let after = CameraPixel::new(x + share * (x + 700.0), y + share * (y - 900.0));
        [CameraPixel::new(x, y), after]
    }

    fn vertex(k: u16, share: f64, aside_px: f64) -> Shift {
        let (x, y) = (
            f64::from(k % 8) * 70.0 + 50.0,
            f64::from(k / 8) * 60.0 + 40.0,
        );
        let [before, mut after] = moved(x, y, share);
        after.y += aside_px;
        Shift {
            index: GridIndex {
                row: k / 8,
                column: k % 8,
            },
            corner: Corner::UpperLeft,
            before,
            after,
            shift_px: (after.x - before.x).hypot(after.y - before.y),
            depth: 0.0,
        }
    }

    fn column(x: f64, y: std::ops::Range<u32>, share: f64) -> DenseLine {
        let point = |y: u32| LinePoint {
            position: moved(x, f64::from(y) + 0.5, share)[1],
            half_width_px: 2.0,
            confidence: 0.9,
        };
        DenseLine {
            axis: Axis::Column,
            line: 4,
            points: y.map(point).collect(),
        }
    }

    fn shifts() -> Vec<Shift> {
        let noise = |k: u16| if k.is_multiple_of(2) { 0.03 } else { -0.03 };
        (0..48).map(|k| vertex(k, 0.03, noise(k))).collect()
    }

    #[test]
    fn vertices_tell_the_direction_and_the_one_that_went_aside_is_rejected() {
        let mut shifts = shifts();
        shifts[20] = vertex(20, 0.03, 2.0);
        let epipolar = from_shifts(&shifts);
        let found = find_line_shifts([&[], &[]], &shifts, epipolar, 1.0);
        assert_eq!(found.source, Some(DirectionSource::Shifts));
        let rejected: Vec<usize> = (0..48).filter(|&k| found.vertices[k].rejected).collect();
        assert_eq!(rejected, [20]);
        let across = found.across.unwrap();
        assert!(across.rms_px < 0.05, "{across:?}");
    }

    #[test]
    fn a_line_point_moves_along_the_epipolar_line_by_its_depth() {
        let epipolar = from_shifts(&shifts());
        let lines = [
            [column(300.0, 100..300, 0.0)],
            [column(300.0, 150..250, 0.03)],
        ];
        let found = find_line_shifts([&lines[0], &lines[1]], &shifts(), epipolar, 2.0);
        assert_eq!(found.points.len(), 100);
        for (point, y) in found.points.iter().zip(150..) {
            let [a, b] = moved(300.0, f64::from(y) + 0.5, 0.03);
            let expected = (b.x - a.x).hypot(b.y - a.y);
            assert!(
                (point.shift_px - expected).abs() < 0.2,
                "{} {expected}",
                point.shift_px
            );
            assert!((point.depth - 2.0 * point.shift_px).abs() < 1e-9);
        }
    }

    #[test]
    fn nothing_is_interpolated_between_two_pieces_of_the_background() {
        let epipolar = from_shifts(&shifts());
        let before = [column(300.0, 100..180, 0.0), column(300.0, 220..300, 0.0)];
        let after = [column(300.0, 150..250, 0.03)];
        let found = find_line_shifts([&before, &after], &shifts(), epipolar, 1.0);
        assert!(
            (35..=45).contains(&found.not_in_background),
            "{}",
            found.not_in_background
        );
        assert_eq!(found.points.len() + found.not_in_background, 100);
    }

    #[test]
    fn where_nothing_moved_there_is_no_direction() {
        let still: Vec<Shift> = (0..48).map(|k| vertex(k, 0.0, 0.0)).collect();
        assert!(from_shifts(&still).is_none());
        assert_eq!(
            find_line_shifts([&[], &[]], &still, None, 1.0),
            LineShifts::default()
        );
    }
}
