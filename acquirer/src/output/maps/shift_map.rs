//! How far each crossing moved when the object was put in, as arrows over the object's picture.
//!
//! Takes the shifts of the vertices, gives one arrow per crossing: the mean of its vertices, from where it was to
//! where it is, coloured by its length in camera pixels.

use std::collections::BTreeMap;

use image::RgbImage;

use super::{RIM, unit, with_bar};
use crate::{
    output::{
        colour_map::Scale,
        drawing::{Drawing, Ink},
        figure::{Figure, PAPER, subdued},
    },
    pipeline::shift::Shift,
};

/// A shorter way than this is drawn as a dot, in units.
const LEAST_ARROW: f64 = 2.5;
/// The share of shifts on either side that may be outliers; they take the colours of the ends.
const OUTLIERS: f64 = 0.01;

/// Draws the shifts over a picture of the scene with the object.
#[must_use]
pub fn shift_map(shifts: &[Shift], picture: &RgbImage) -> Figure {
    let lengths = shifts.iter().map(|s| s.shift_px);
    let mut scale = Scale::covering(lengths, OUTLIERS, "shift / px");
    scale.low = 0.0;
    let mut drawing = with_bar(picture, &scale);
    let mut crossings: BTreeMap<_, Vec<&Shift>> = BTreeMap::new();
    for shift in shifts {
        crossings.entry(shift.index).or_default().push(shift);
    }
    let unit = unit(picture);
    for (index, group) in crossings {
        let mean = |value: &dyn Fn(&Shift) -> f64| {
            group.iter().map(|s| value(s)).sum::<f64>() / group.len() as f64
        };
        let from = [mean(&|s| s.before.x), mean(&|s| s.before.y)];
        let to = [mean(&|s| s.after.x), mean(&|s| s.after.y)];
        let length = mean(&|s| s.shift_px);
        let ink = Ink::solid(scale.colour(length));
        draw_arrow(&mut drawing, (from, to), ink, unit);
        drawing.titled(format!(
            "row {}, column {}: {length:.2} px, relative depth {:.2}",
            index.row,
            index.column,
            mean(&|s| s.depth)
        ));
    }
    Figure {
        picture: subdued(picture, 0.55),
        px_per_unit: 1.0,
        drawing,
    }
}

/// An arrow, or a dot where there is hardly a way; the last form added is its head.
fn draw_arrow(drawing: &mut Drawing, (from, to): ([f64; 2], [f64; 2]), ink: Ink, unit: f64) {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    if length.is_nan() || length < LEAST_ARROW * unit {
        drawing
            .disc(to, 2.8 * unit, PAPER.faded(0.7))
            .disc(to, 2.2 * unit, ink);
        return;
    }
    let (ux, uy) = (dx / length, dy / length);
    let head = (0.45 * length).min(6.0 * unit);
    let point = |along: f64, across: f64| {
        [
            to[0] - along * ux - across * uy,
            to[1] - along * uy + across * ux,
        ]
    };
    let neck = point(0.8 * head, 0.0);
    let tip = |grow: f64| {
        [
            point(-1.4 * grow, 0.0),
            point(head + grow, 0.5 * head + grow),
            point(head + grow, -0.5 * head - grow),
        ]
    };
    drawing
        .stroke([from, neck], 2.8 * unit, RIM)
        .area(tip(0.7 * unit), RIM)
        .stroke([from, neck], 1.5 * unit, ink)
        .area(tip(0.0), ink);
}
