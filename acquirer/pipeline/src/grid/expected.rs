//! Which lines the crossings should lie on, from what is known of their places.
//!
//! Takes known places on the projector, gives for each crossing and family the expected line number (a fraction, in
//! the picture's order of counting) with its spread, and what a label costs that differs from it.

use shared::pattern::Axis;

use super::vertices::Placement;
use crate::{crossings::Crossings, densify::KnownPlaces};

/// Most that one crossing's expected line may speak against another, in nats: the place may be wrong.
const MOST_NATS: f64 = 8.0;

/// The lines expected at the crossings.
pub(super) struct ExpectedLines {
    /// Per family, per crossing: line number and its standard deviation.
    on: [Vec<Option<(f64, f64)>>; 2],
}

impl ExpectedLines {
    pub(super) fn new(
        crossings: &Crossings,
        known: &KnownPlaces,
        placement: &Placement<'_>,
    ) -> Self {
        let places: Vec<_> = crossings
            .all
            .iter()
            .map(|crossing| known.at(crossing.centre))
            .collect();
        let on = Axis::BOTH.map(|family| {
            let axis = placement.orientation.pattern_axis(family);
            let pitch_px = placement.grid.pitch_px(axis, placement.raster);
            let last = placement.grid.lines(axis) as f64 - 1.0;
            let line = |place: &crate::densify::KnownPlace| {
                let along_px = match axis {
                    Axis::Row => place.at.y,
                    Axis::Column => place.at.x,
                };
                let number = along_px / pitch_px - 0.5;
                let is_flipped = placement.orientation.flipped(family);
                let number = if is_flipped { last - number } else { number };
                (number, place.spread_px / pitch_px)
            };
            places
                .iter()
                .map(|place| place.as_ref().map(line))
                .collect()
        });
        Self { on }
    }

    /// Whether the place of most of these crossings is known.
    pub(super) fn knows_most(&self, nodes: &[usize]) -> bool {
        let known = nodes.iter().filter(|&&node| self.on[0][node].is_some());
        2 * known.count() > nodes.len()
    }

    /// The line that a crossing should lie on.
    pub(super) fn nearest(&self, family: Axis, node: usize) -> Option<i32> {
        self.of(family)[node].map(|(number, _)| number.round() as i32)
    }

    /// What speaks against a crossing's line number, in nats from 0 to [`MOST_NATS`].
    pub(super) fn cost(&self, family: Axis, node: usize, line: i32) -> f32 {
        self.of(family)[node].map_or(0.0, |(number, spread)| {
            let off = (f64::from(line) - number) / spread;
            (0.5 * off * off).min(MOST_NATS) as f32
        })
    }

    /// Whether a crossing can't lie on this line.
    pub(super) fn contradicts(&self, family: Axis, node: usize, line: i32) -> bool {
        f64::from(self.cost(family, node, line)) >= MOST_NATS
    }

    fn of(&self, family: Axis) -> &[Option<(f64, f64)>] {
        match family {
            Axis::Row => &self.on[0],
            Axis::Column => &self.on[1],
        }
    }
}
