//! How far the object stands out of the background, in mm: both seen on the same ray of the projector.
//!
//! Takes the surfaces of both stages, gives a [`Difference`] for each vertex read in both, and for each line point
//! of the object whose line was read in the background where the same projector position lights it, between two
//! neighbouring points of one unbroken piece. Nothing is interpolated across a cut.

use std::collections::HashMap;

use shared::pattern::{Axis, Corner};

use super::{Placed, SurfacePoint};

/// A point of the object and the background that its light fell on before.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// The object's point.
    pub point: SurfacePoint,
    /// The background's point on the same projector ray, mm, camera frame.
    pub background_mm: [f64; 3],
    /// Distance between them, mm; positive where the object is nearer to the camera.
    pub height_mm: f64,
}

/// Compares the surfaces of both stages.
#[must_use]
pub fn find_differences(background: &[Placed], object: &[Placed]) -> Vec<Difference> {
    let vertices: HashMap<_, [f64; 3]> = background
        .iter()
        .filter_map(|p| Some((vertex(&p.point)?, p.point.position_mm)))
        .collect();
    let segments = segments(background);
    object
        .iter()
        .filter_map(|placed| {
            let before = match vertex(&placed.point) {
                Some(key) => *vertices.get(&key)?,
                None => on_line(placed, &segments)?,
            };
            Some(Difference::of(placed.point.clone(), before))
        })
        .collect()
}

impl Difference {
    fn of(point: SurfacePoint, background_mm: [f64; 3]) -> Self {
        let [x, y, z] = [0, 1, 2].map(|k| background_mm[k] - point.position_mm[k]);
        let distance = x.hypot(y).hypot(z);
        Self {
            point,
            background_mm,
            height_mm: distance.copysign(z),
        }
    }
}

fn vertex(point: &SurfacePoint) -> Option<(u16, u16, Corner)> {
    Some((point.row?, point.column?, point.corner?))
}

/// A line and a whole projector pixel along it.
type Place = (Axis, u16, i64);

fn line(point: &SurfacePoint) -> Option<(Axis, u16)> {
    match (point.row, point.column) {
        (Some(row), None) => Some((Axis::Row, row)),
        (None, Some(column)) => Some((Axis::Column, column)),
        _ => None,
    }
}

/// Neighbouring points of one piece, by the projector pixels between them.
fn segments(points: &[Placed]) -> HashMap<Place, Vec<[&Placed; 2]>> {
    let mut segments: HashMap<Place, Vec<_>> = HashMap::new();
    for pair in points.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        let Some((axis, k)) = line(&a.point).filter(|own| line(&b.point) == Some(*own)) else {
            continue;
        };
        if a.piece != b.piece || b.step != a.step + 1 {
            continue;
        }
        let (low, high) = (a.along_px.min(b.along_px), a.along_px.max(b.along_px));
        for pixel in low.floor() as i64..=high.floor() as i64 {
            segments.entry((axis, k, pixel)).or_default().push([a, b]);
        }
    }
    segments
}

fn on_line(object: &Placed, segments: &HashMap<Place, Vec<[&Placed; 2]>>) -> Option<[f64; 3]> {
    let (axis, k) = line(&object.point)?;
    let at = object.along_px;
    let near = segments.get(&(axis, k, at.floor() as i64))?;
    near.iter().find_map(|[a, b]| {
        let share = (at - a.along_px) / (b.along_px - a.along_px);
        let (p, q) = (a.point.position_mm, b.point.position_mm);
        (0.0..=1.0)
            .contains(&share)
            .then(|| [0, 1, 2].map(|k| p[k] + share * (q[k] - p[k])))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(along_px: f64, z: f64, piece: usize, step: usize) -> Placed {
        Placed {
            point: SurfacePoint {
                row: None,
                column: Some(3),
                corner: None,
                position_mm: [0.0, along_px, z],
                colour: [0; 3],
                confidence: 1.0,
            },
            along_px,
            piece,
            step,
        }
    }

    #[test]
    fn the_height_is_towards_the_camera_at_the_same_place_of_the_line() {
        let background: Vec<Placed> = (0..50).map(|k| placed(k as f64, 1000.0, 0, k)).collect();
        let object = [placed(20.5, 850.0, 0, 0)];
        let found = find_differences(&background, &object);
        assert_eq!(found.len(), 1);
        assert!((found[0].height_mm - 150.0).abs() < 1e-9);
        assert_eq!(found[0].background_mm, [0.0, 20.5, 1000.0]);
    }

    #[test]
    fn no_background_is_made_up_across_a_cut_or_a_missing_point() {
        let cut = [placed(20.0, 1000.0, 0, 9), placed(21.0, 700.0, 1, 10)];
        let missing = [placed(20.0, 1000.0, 0, 9), placed(21.0, 1000.0, 0, 11)];
        let object = [placed(20.5, 650.0, 0, 0)];
        assert!(find_differences(&cut, &object).is_empty());
        assert!(find_differences(&missing, &object).is_empty());
    }
}
