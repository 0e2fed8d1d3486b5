//! The camera's response as a plot: linear light over byte values, beside the sRGB curve.

use super::{
    body::Section,
    html::{PAIR, escaped, figure, table},
};
use crate::{
    output::{
        Summary,
        drawing::{Anchor, Drawing, Ink, Text},
        figure::{DARK, PALE},
        response::{CurveSource, ResponseFigures},
    },
    pipeline::response::{KNOTS, ResponseCurve},
};

/// Width and height of the plot's field, and the room around it for its letters.
const FIELD: [f64; 2] = [420.0, 300.0];
const MARGIN: [f64; 4] = [62.0, 14.0, 16.0, 50.0]; // left, top, right, bottom
const LETTERS: f64 = 14.0;
const CURVE: Ink = Ink::solid([194, 65, 12]);

/// The section about the response; without solid colours there is nothing to show.
pub(super) fn section(summary: &Summary) -> Option<Section<'static>> {
    let figures = summary.response.as_ref()?;
    let is_assumed = figures.curve == CurveSource::Srgb && figures.residual_levels.is_none();
    if is_assumed && figures.not_measured.is_none() {
        return None;
    }
    let plot = figure(
        &plot(figures).svg("plot", ""),
        "Linear light for each byte value of the camera: as used (orange), and the sRGB curve (grey).",
    );
    let levels = |value: Option<f64>| value.map(|v| format!("{v:.2} byte values"));
    let facts = [
        ("Curve", Some(figures.curve.words().to_owned())),
        (
            "Solid colours miss adding up by (RMS)",
            levels(figures.residual_levels),
        ),
        (
            "The same with the sRGB curve",
            levels(figures.srgb_residual_levels),
        ),
        (
            "White over red + green + blue",
            figures
                .white_over_primaries
                .map(|ratio| format!("{ratio:.3}")),
        ),
        ("Not measured", figures.not_measured.as_deref().map(escaped)),
    ];
    let rows: Vec<Vec<String>> = facts
        .into_iter()
        .filter_map(|(name, value)| Some(vec![name.to_owned(), value?]))
        .collect();
    let [open, close] = PAIR;
    Some(Section {
        id: "response",
        title: "The camera's response",
        body: format!("{open}{plot}{}{close}", table(&["Response", ""], &rows)).into(),
    })
}

fn plot(figures: &ResponseFigures) -> Drawing {
    let [left, top, right, bottom] = MARGIN;
    let [width, height] = FIELD;
    let mut drawing = Drawing::new(left + width + right, top + height + bottom);
    let place = |byte: f64, light: f64| [left + width * byte / 255.0, top + height * (1.0 - light)];
    let mut letters = |at: [f64; 2], text: String, anchor: Anchor| {
        drawing.text(Text {
            at,
            text,
            size: LETTERS,
            anchor,
            ink: DARK,
            halo: None,
        });
    };
    for k in 0..=5 {
        let light = f64::from(k) / 5.0;
        let [x, y] = place(0.0, light);
        letters([x - 8.0, y], format!("{light:.1}"), Anchor::End);
    }
    for byte in [0.0, 64.0, 128.0, 192.0, 255.0] {
        let [x, y] = place(byte, 0.0);
        letters([x, y + 14.0], format!("{byte}"), Anchor::Middle);
    }
    letters(
        [left + width / 2.0, top + height + 36.0],
        "byte value".into(),
        Anchor::Middle,
    );
    letters(
        [left + 8.0, top + LETTERS],
        "linear light, 1 = white point".into(),
        Anchor::Start,
    );
    for k in 0..=5 {
        let light = f64::from(k) / 5.0;
        drawing.stroke([place(0.0, light), place(255.0, light)], 1.0, PALE);
    }
    let mut curve = |light: [f64; KNOTS], width: f64, ink: Ink| {
        let points = light.iter().enumerate();
        let points: Vec<_> = points
            .map(|(k, &light)| place(255.0 * k as f64 / (KNOTS - 1) as f64, light))
            .collect();
        drawing.stroke(points, width, ink);
    };
    curve(ResponseCurve::srgb().knots(), 2.0, DARK.faded(0.4));
    curve(figures.light, 2.5, CURVE);
    drawing
}
