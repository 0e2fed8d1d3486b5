//! The decoded grid over the picture it was read from.
//!
//! Takes a stage's decoded grid, gives a figure: followed lines in the colours they were projected in (grey
//! where not decoded), a dot for each vertex, the numbers of rows and columns where their lines begin, a cross
//! for each dropped crossing in the colour of its reason, and a legend below.

use std::collections::BTreeMap;

use image::RgbImage;
use shared::{
    geometry::CameraPixel,
    pattern::{Axis, Corner, Grid},
};

use super::{RIM, unit};
use crate::{
    output::{
        drawing::{Anchor, Drawing, Ink, Text, simplified},
        figure::{DARK, Figure, PAPER},
    },
    pipeline::grid::{DecodedCrossing, DecodedGrid, DropReason, LineTrack},
};

/// Height of the legend for a picture 640 px wide.
const LEGEND: f64 = 40.0;
/// Crossings at least this far from each other, on a picture 640 px wide, have room for their own label.
const ROOM_FOR_LABELS: f64 = 27.0;
/// More dots than this make the report heavy and can't be told apart; crossings get one dot then.
const MOST_VERTEX_DOTS: usize = 4_000;
/// How far a line may be from the one that was followed, in units.
const TOLERANCE: f64 = 0.15;
/// Colour of lines without a label.
const UNREAD: Ink = Ink::solid([150, 154, 162]);
/// Colour of vertices and numbers.
const LIGHT: Ink = Ink::solid([255, 255, 255]);

/// The colour that stands for a reason; all six can be told apart with any colour vision.
#[must_use]
pub fn reason_colour(reason: DropReason) -> [u8; 3] {
    // M. Okabe and K. Ito, "Color universal design", 2002
    match reason {
        DropReason::TooDark => [0x56, 0xb4, 0xe9],
        DropReason::Clipped => [0xf0, 0xe4, 0x42],
        DropReason::AmbiguousColour => [0xcc, 0x79, 0xa7],
        DropReason::BrokenLine => [0xe6, 0x9f, 0x00],
        DropReason::NotInCode => [0xd5, 0x5e, 0x00],
        DropReason::OffEpipolarLine => [0x00, 0x9e, 0x73],
    }
}

/// A reason in words.
#[must_use]
pub fn reason_words(reason: DropReason) -> &'static str {
    match reason {
        DropReason::TooDark => "too dark",
        DropReason::Clipped => "clipped",
        DropReason::AmbiguousColour => "ambiguous colour",
        DropReason::BrokenLine => "broken line",
        DropReason::NotInCode => "not in code",
        DropReason::OffEpipolarLine => "off epipolar line",
    }
}

/// Draws a decoded grid over the picture it was read from.
#[must_use]
pub fn label_map(grid: &DecodedGrid, pattern: &Grid, picture: &RgbImage) -> Figure {
    let unit = unit(picture);
    let (width, height) = (f64::from(picture.width()), f64::from(picture.height()));
    let mut drawing = Drawing::new(width, height + LEGEND * unit);
    for track in &grid.tracks {
        draw_track(track, pattern, unit, &mut drawing);
    }
    let few = 4 * grid.crossings.len() <= MOST_VERTEX_DOTS;
    let labelled = spacing(grid).is_some_and(|px| px >= ROOM_FOR_LABELS * unit);
    for crossing in &grid.crossings {
        draw_crossing(crossing, (few, labelled), unit, &mut drawing);
    }
    for dropped in &grid.dropped {
        let ink = Ink::solid(reason_colour(dropped.reason));
        let at = [dropped.centre.x, dropped.centre.y];
        drawing.cross(at, 3.4 * unit, 2.6 * unit, RIM);
        drawing.cross(at, 3.2 * unit, 1.5 * unit, ink);
        drawing.titled(format!("dropped: {}", reason_words(dropped.reason)));
    }
    draw_line_numbers(grid, unit, &mut drawing);
    draw_legend(grid, [width, height], unit, &mut drawing);
    Figure {
        picture: picture.clone(),
        px_per_unit: 1.0,
        drawing,
    }
}

fn xy(p: CameraPixel) -> [f64; 2] {
    [p.x, p.y]
}

fn axis_word(axis: Axis) -> &'static str {
    match axis {
        Axis::Row => "row",
        Axis::Column => "column",
    }
}

fn draw_track(track: &LineTrack, pattern: &Grid, unit: f64, drawing: &mut Drawing) {
    let points: Vec<_> = track.points.iter().map(|p| xy(p.position)).collect();
    let points = simplified(&points, TOLERANCE * unit);
    let colour = track
        .line
        .and_then(|k| pattern.line_colour(track.axis, k.into()));
    let ink = colour.map_or(UNREAD, |c| Ink::solid(c.0));
    let title = match track.line {
        Some(k) => format!("{} {k}", axis_word(track.axis)),
        None => format!("{} without a label", axis_word(track.axis)),
    };
    drawing.stroke(points, 1.1 * unit, ink).titled(title);
}

fn draw_crossing(
    crossing: &DecodedCrossing,
    (few, labelled): (bool, bool),
    unit: f64,
    drawing: &mut Drawing,
) {
    let index = crossing.index;
    let name = format!("row {}, column {}", index.row, index.column);
    let trust = format!("confidence {:.3}", crossing.confidence);
    if few {
        for (corner, at) in Corner::ALL.iter().zip(crossing.vertices) {
            drawing.disc(xy(at), 1.5 * unit, RIM);
            drawing.disc(xy(at), 1.0 * unit, LIGHT).titled(format!(
                "{name}, {corner}: ({:.2}, {:.2}) px, {trust}",
                at.x, at.y
            ));
        }
    } else {
        drawing
            .disc(xy(crossing.centre), 0.9 * unit, LIGHT)
            .titled(format!("{name}, {trust}"));
    }
    if labelled {
        let [x, y] = xy(crossing.centre);
        drawing.text(Text {
            at: [x + 4.0 * unit, y + 7.5 * unit],
            text: format!("{},{}", index.row, index.column),
            size: 5.6 * unit,
            anchor: Anchor::Start,
            ink: LIGHT.faded(0.9),
            halo: Some(RIM),
        });
    }
}

/// The median distance from a crossing to the next one of its row, in px.
fn spacing(grid: &DecodedGrid) -> Option<f64> {
    let mut distances: Vec<f64> = grid
        .crossings
        .windows(2)
        .filter(|pair| pair[0].index.row == pair[1].index.row)
        .filter(|pair| pair[0].index.column + 1 == pair[1].index.column)
        .map(|pair| {
            let (a, b) = (pair[0].centre, pair[1].centre);
            (b.x - a.x).hypot(b.y - a.y)
        })
        .collect();
    distances.sort_by(f64::total_cmp);
    distances.get(distances.len() / 2).copied()
}

/// Writes each line's number where its first piece begins: rows on the left, columns above.
fn draw_line_numbers(grid: &DecodedGrid, unit: f64, drawing: &mut Drawing) {
    let mut begins: BTreeMap<(Axis, u16), [f64; 2]> = BTreeMap::new();
    for track in &grid.tracks {
        let Some(line) = track.line else { continue };
        let along = usize::from(track.axis == Axis::Column);
        for point in &track.points {
            let at = xy(point.position);
            let begin = begins.entry((track.axis, line)).or_insert(at);
            if at[along] < begin[along] {
                *begin = at;
            }
        }
    }
    let size = 11.0 * unit;
    for ((axis, line), [x, y]) in begins {
        let (at, anchor) = match axis {
            Axis::Row => ([(x - 5.0 * unit).max(2.0 * size), y], Anchor::End),
            Axis::Column => ([x, (y - 0.7 * size).max(0.7 * size)], Anchor::Middle),
        };
        drawing.text(Text {
            at,
            text: line.to_string(),
            size,
            anchor,
            ink: LIGHT,
            halo: Some(RIM),
        });
    }
}

fn draw_legend(grid: &DecodedGrid, [width, height]: [f64; 2], unit: f64, drawing: &mut Drawing) {
    drawing.rectangle([0.0, height], [width, LEGEND * unit], PAPER);
    for (k, (reason, count)) in grid.dropped_by_reason().into_iter().enumerate() {
        let at = [
            width * (0.02 + 0.333 * (k % 3) as f64) + 4.0 * unit,
            height + (11.0 + 18.0 * (k / 3) as f64) * unit,
        ];
        drawing.cross(
            at,
            3.6 * unit,
            2.2 * unit,
            Ink::solid(reason_colour(reason)),
        );
        drawing.text(Text {
            at: [at[0] + 10.0 * unit, at[1]],
            text: format!("{}: {count}", reason_words(reason)),
            size: 9.6 * unit,
            anchor: Anchor::Start,
            ink: DARK,
            halo: None,
        });
    }
}
