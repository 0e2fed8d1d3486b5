//! What was projected: the coded grid as a drawing, its colours, and the sequence of its lines.

use shared::{
    pattern::{Axis, Grid, Palette, RasterSize},
    sequence::{Alphabet, window_order},
};

use super::{
    body::Section,
    html::{escaped, figure, swatch},
};
use crate::output::{
    Summary,
    drawing::{Drawing, Ink},
};

/// More lines than this are not listed one by one.
const MOST_LISTED: usize = 63;

pub(super) fn section(summary: &Summary) -> Section<'static> {
    let grid = &summary.pattern.coded;
    let drawing = figure(
        &raster_drawing(grid, summary.projector).svg("raster", ""),
        "The coded grid as the projector shows it. Columns lie over rows.",
    );
    let palette = Palette::default();
    let colours: String = grid
        .colours()
        .iter()
        .enumerate()
        .map(|(k, &colour)| {
            let name = escaped(&palette.name_of(colour));
            let symbol = ["0", "1", "w", "w²"].get(k).copied().unwrap_or("–");
            format!(
                "<li>{}<b>{symbol}</b> {name} <small>{colour}</small></li>",
                swatch(colour)
            )
        })
        .collect();
    let unary = summary.pattern.unary;
    let unary_name = escaped(&palette.name_of(unary));
    let facts = format!(
        "<div><p>{}</p>\n<ul class=\"colours\">{colours}<li>{}<b>unary</b> {unary_name} <small>{unary}</small></li></ul>\n{}{}</div>",
        description(grid, summary.projector),
        swatch(unary),
        sequence(grid, Axis::Row, "Rows, from the top"),
        sequence(grid, Axis::Column, "Columns, from the left"),
    );
    Section {
        id: "pattern",
        title: "What was projected",
        body: format!("<div class=\"pair\">\n{drawing}{facts}\n</div>\n").into(),
    }
}

fn description(grid: &Grid, size: RasterSize) -> String {
    let alphabet = match grid.colours().len() {
        2 => Some(Alphabet::Two),
        4 => Some(Alphabet::Four),
        _ => None,
    };
    let window = |lines| alphabet.and_then(|a| window_order(a, lines).ok());
    let code = match (window(grid.rows()), window(grid.columns())) {
        (Some(rows), Some(columns)) => format!(
            " The colours follow a pseudo-random sequence: any {rows} neighbouring rows and any {columns} \
             neighbouring columns occur only once, so a piece of that size tells where it belongs."
        ),
        _ => String::new(),
    };
    format!(
        "{} rows and {} columns on {} × {} projector pixels; rows are {} px wide, columns {} px.{code}",
        grid.rows(),
        grid.columns(),
        size.width,
        size.height,
        grid.width_px(Axis::Row),
        grid.width_px(Axis::Column)
    )
}

/// The grid line by line: exact at any size, and far smaller than its pixels.
fn raster_drawing(grid: &Grid, size: RasterSize) -> Drawing {
    let (width, height) = (f64::from(size.width), f64::from(size.height));
    let mut drawing = Drawing::new(width, height);
    drawing.rectangle([0.0; 2], [width, height], Ink::solid([0; 3]));
    for (axis, word) in [(Axis::Row, "row"), (Axis::Column, "column")] {
        for k in 0..grid.lines(axis) {
            let span = grid.line(axis, k, size);
            let Some(colour) = grid.line_colour(axis, k) else {
                continue;
            };
            let wide = f64::from(span.width_px);
            let (corner, extent) = match axis {
                Axis::Row => ([0.0, span.low_px()], [width, wide]),
                Axis::Column => ([span.low_px(), 0.0], [wide, height]),
            };
            drawing
                .rectangle(corner, extent, Ink::solid(colour.0))
                .titled(format!("{word} {k}: {colour}"));
        }
    }
    drawing
}

fn sequence(grid: &Grid, axis: Axis, title: &str) -> String {
    let symbols = grid.symbols(axis);
    if grid.is_unary() || symbols.len() > MOST_LISTED {
        return String::new();
    }
    let cells: String = symbols
        .iter()
        .enumerate()
        .filter_map(|(k, symbol)| {
            let colour = grid.line_colour(axis, k)?;
            Some(format!(
                "<i style=\"border-color:{colour}\" title=\"line {k}: {colour}\">{}</i>",
                match symbol.0 {
                    2 => "w".to_owned(),
                    3 => "w²".to_owned(),
                    other => other.to_string(),
                }
            ))
        })
        .collect();
    format!("<p class=\"note\">{title}</p><p class=\"sequence\">{cells}</p>\n")
}
