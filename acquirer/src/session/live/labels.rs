//! Labels that crossings keep from frame to frame.
//!
//! Takes the crossings of a coded frame with their labels, then those of unary frames, which have none; each labelled
//! crossing goes on as the crossing that is nearest to it, if that is much nearer than its neighbours are and nobody
//! else's. What finds no successor is lost until the coded grid is seen again. It fails quietly when the lines move by
//! half their pitch between two frames.

use pipeline::grid::DecodedGrid;
use shared::{geometry::CameraPixel, pattern::GridIndex};

/// Farthest step of a crossing, as a share of the way to its nearest neighbour.
const FARTHEST_STEP: f64 = 0.35;

/// A crossing's label and where the crossing was seen last.
pub type CarriedLabel = (GridIndex, CameraPixel);

/// Labelled crossings and where they were seen last.
#[derive(Debug, Default)]
pub(super) struct CarriedLabels(Vec<CarriedLabel>);

impl CarriedLabels {
    /// The labels of a coded frame.
    pub(super) fn of(grid: &DecodedGrid) -> Self {
        let crossings = grid.crossings.iter();
        Self(crossings.map(|c| (c.index, c.centre)).collect())
    }

    /// All that have a label.
    pub(super) fn all(&self) -> &[CarriedLabel] {
        &self.0
    }

    /// How many crossings have a label.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Goes on to the crossings of the next frame, whatever their own labels; gives how many were lost.
    pub(super) fn follow(&mut self, grid: &DecodedGrid) -> usize {
        let labelled = grid.crossings.iter().map(|crossing| crossing.centre);
        let dropped = grid.dropped.iter().map(|crossing| crossing.centre);
        let seen: Vec<CameraPixel> = labelled.chain(dropped).collect();
        let old = self.0.iter().map(|(_, centre)| *centre).collect::<Vec<_>>();
        let before = self.0.len();
        self.0 = self
            .0
            .iter()
            .enumerate()
            .filter_map(|(own, &(index, centre))| {
                let (next, step) = nearest(&seen, centre, None)?;
                let (back, _) = nearest(&old, seen[next], None)?;
                let (_, pitch) = nearest(&old, centre, Some(own))?;
                (back == own && step < FARTHEST_STEP * pitch).then(|| (index, seen[next]))
            })
            .collect();
        before - self.0.len()
    }
}

/// The place of the point that is nearest, and its distance in pixels; `not` is left out.
fn nearest(points: &[CameraPixel], to: CameraPixel, not: Option<usize>) -> Option<(usize, f64)> {
    let distances = points
        .iter()
        .enumerate()
        .filter(|(place, _)| Some(*place) != not)
        .map(|(place, point)| (place, (point.x - to.x).hypot(point.y - to.y)));
    distances.min_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use pipeline::grid::{DropReason, DroppedCrossing};

    use super::*;

    fn labels() -> CarriedLabels {
        let places = (0..9).map(|k| (k % 3, k / 3));
        CarriedLabels(
            places
                .map(|(column, row)| {
                    let centre = CameraPixel::new(20.0 * column as f64, 20.0 * row as f64);
                    (GridIndex { row, column }, centre)
                })
                .collect(),
        )
    }

    fn unlabelled(centres: impl Iterator<Item = CameraPixel>) -> DecodedGrid {
        DecodedGrid {
            dropped: centres
                .map(|centre| DroppedCrossing {
                    centre,
                    reason: DropReason::NotInCode,
                })
                .collect(),
            ..DecodedGrid::default()
        }
    }

    #[test]
    fn crossings_that_move_a_little_keep_their_labels() {
        let mut carried = labels();
        for step in 1..=10 {
            let moved = labels().0.into_iter().map(|(_, at)| {
                CameraPixel::new(at.x + 4.0 * f64::from(step), at.y - 3.0 * f64::from(step))
            });
            assert_eq!(carried.follow(&unlabelled(moved)), 0);
        }
        let first = carried.0[0];
        assert_eq!((first.0.row, first.0.column), (0, 0));
        assert_eq!((first.1.x, first.1.y), (40.0, -30.0));
    }

    #[test]
    fn a_crossing_without_a_successor_is_lost_and_takes_nobody_elses() {
        let mut carried = labels();
        let rest = labels().0.into_iter().skip(1).map(|(_, at)| at);
        assert_eq!(carried.follow(&unlabelled(rest)), 1);
        assert_eq!(carried.len(), 8);
    }

    #[test]
    fn a_jump_of_half_a_pitch_loses_the_labels_rather_than_mixing_them_up() {
        let mut carried = labels();
        let jumped = labels().0.into_iter();
        let jumped = jumped.map(|(_, at)| CameraPixel::new(at.x + 9.0, at.y));
        carried.follow(&unlabelled(jumped));
        assert_eq!(carried.len(), 0);
    }
}
