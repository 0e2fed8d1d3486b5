//! The box round the surface: its ranges, its back walls with a grid, its ticks and names.

use super::view::Projection;
use crate::output::{
    colour_map::{spread, tick_label, ticks},
    drawing::{Anchor, Drawing, Ink, Text},
    figure::{DARK, PALE},
};

/// One axis of the box.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    /// Its name with the unit.
    pub(super) name: &'static str,
    /// First and last number.
    pub(super) low: f64,
    pub(super) high: f64,
    /// What one unit of data is in the room; negative when the data grow towards the viewer.
    pub(super) factor: f64,
}

/// The three axes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axes(pub(super) [Axis; 3]);

impl Axes {
    /// Axes round positions, with room for 4 % on all sides.
    pub(super) fn around(positions: &[[f64; 3]], names: [&'static str; 3]) -> Self {
        Self([0, 1, 2].map(|k| {
            let range = spread(positions.iter().map(|p| p[k]), 0.0);
            let [low, high] = range.unwrap_or([0.0, 1.0]);
            let room = (0.04 * (high - low)).max(1e-3 * low.abs()).max(1e-6);
            Axis {
                name: names[k],
                low: low - room,
                high: high + room,
                factor: 1.0,
            }
        }))
    }

    /// The corners of the box.
    pub(super) fn corners(&self) -> [[f64; 3]; 8] {
        std::array::from_fn(|k| self.corner([k & 1 > 0, k & 2 > 0, k & 4 > 0]))
    }

    fn corner(&self, at_high: [bool; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| self.end(k, at_high[k]))
    }

    fn end(&self, k: usize, at_high: bool) -> f64 {
        if at_high {
            self.0[k].high
        } else {
            self.0[k].low
        }
    }

    fn ticks(&self, k: usize) -> Vec<f64> {
        let Axis {
            low, high, factor, ..
        } = self.0[k];
        let longest = self.0.iter().map(|a| (a.high - a.low) * a.factor.abs());
        let share = (high - low) * factor.abs() / longest.fold(f64::MIN_POSITIVE, f64::max);
        ticks(low, high, (2.0 + 5.0 * share).round() as usize)
    }

    /// For each axis, whether the wall at its high end is behind the data.
    fn back(&self, projection: &Projection) -> [bool; 3] {
        [0, 1, 2].map(|k| {
            let distance = |at_high| {
                let mut ends = [false; 3];
                ends[k] = at_high;
                projection.place(self.corner(ends))[2]
            };
            distance(true) > distance(false)
        })
    }

    /// The three walls behind the surface, with lines at the ticks.
    pub(super) fn draw_walls(&self, projection: &Projection, drawing: &mut Drawing) {
        let back = self.back(projection);
        let flat = |p: [f64; 3]| {
            let [x, y, _] = projection.place(p);
            [x, y]
        };
        for wall in 0..3 {
            let (i, j) = ((wall + 1) % 3, (wall + 2) % 3);
            let point = |u: f64, v: f64| {
                let mut p = [0.0; 3];
                (p[wall], p[i], p[j]) = (self.end(wall, back[wall]), u, v);
                flat(p)
            };
            let (a, b) = (&self.0[i], &self.0[j]);
            let rim = [
                point(a.low, b.low),
                point(a.high, b.low),
                point(a.high, b.high),
                point(a.low, b.high),
            ];
            drawing.area(rim, Ink::solid([248, 249, 251]));
            for u in self.ticks(i) {
                drawing.stroke([point(u, b.low), point(u, b.high)], 1.0, PALE);
            }
            for v in self.ticks(j) {
                drawing.stroke([point(a.low, v), point(a.high, v)], 1.0, PALE);
            }
            drawing.stroke([rim[0], rim[1], rim[2], rim[3], rim[0]], 1.2, PALE);
        }
    }

    /// Ticks and names along the outline of the box.
    pub(super) fn draw_labels(&self, projection: &Projection, drawing: &mut Drawing) {
        let back = self.back(projection);
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            // an edge belongs to the outline when one of its walls is in front and the other behind
            let ends = [(true, false), (false, true)].map(|(i_back, j_back)| {
                let mut at_high = [false; 3];
                at_high[i] = back[i] == i_back;
                at_high[j] = back[j] == j_back;
                at_high
            });
            let middle = |at_high: [bool; 3]| {
                let mut p = self.corner(at_high);
                p[k] = (self.0[k].low + self.0[k].high) / 2.0;
                projection.place(p)
            };
            let [first, second] = ends.map(middle);
            // y is labelled on the left, the others below
            let take_first = if k == 1 {
                first[0] <= second[0]
            } else {
                first[1] >= second[1]
            };
            let edge = if take_first { ends[0] } else { ends[1] };
            self.draw_edge(k, edge, projection, drawing);
        }
    }

    fn draw_edge(&self, k: usize, edge: [bool; 3], projection: &Projection, out: &mut Drawing) {
        let place = |value: f64| {
            let mut p = self.corner(edge);
            p[k] = value;
            let [x, y, _] = projection.place(p);
            [x, y]
        };
        let axis = &self.0[k];
        let (from, to) = (place(axis.low), place(axis.high));
        let middle = place((axis.low + axis.high) / 2.0);
        let centre = projection.place([0, 1, 2].map(|n| (self.0[n].low + self.0[n].high) / 2.0));
        let outward = outward(from, to, [middle[0] - centre[0], middle[1] - centre[1]]);
        let off = |p: [f64; 2], by: f64| [p[0] + by * outward[0], p[1] + by * outward[1]];
        let anchor = match outward[0] {
            x if x < -0.3 => Anchor::End,
            x if x > 0.3 => Anchor::Start,
            _ => Anchor::Middle,
        };
        let text = |at, text: String, size| Text {
            at,
            text,
            size,
            anchor,
            ink: DARK,
            halo: None,
        };
        out.stroke([from, to], 1.4, DARK);
        for value in self.ticks(k) {
            let at = place(value);
            out.stroke([at, off(at, 6.0)], 1.2, DARK);
            let label = tick_label(value, axis.high - axis.low);
            out.text(text(off(at, 15.0), label, 15.0));
        }
        out.text(text(off(middle, 58.0), axis.name.to_owned(), 17.0));
    }
}

/// The direction square to an edge that points the same way as `away`, of length 1.
fn outward(from: [f64; 2], to: [f64; 2], away: [f64; 2]) -> [f64; 2] {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    let normal = if length > 1e-9 {
        [-dy / length, dx / length]
    } else {
        [0.0, 1.0]
    };
    if normal[0] * away[0] + normal[1] * away[1] < 0.0 {
        normal.map(|v| -v)
    } else {
        normal
    }
}
