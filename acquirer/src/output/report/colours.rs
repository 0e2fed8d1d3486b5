//! How the grid's colours were chosen: each colour's scores, how well pairs are told apart, region by region.

use std::path::Path;

use image::RgbImage;
use shared::{pattern::Rgb, stage::Stage};

use super::{
    Content,
    body::Section,
    html::{bar, escaped, figure, percent, swatch, table},
};
use crate::{
    output::{
        OutputError,
        data_uri::Encoding,
        drawing::{Anchor, Drawing, Ink, Text},
        figure::{Figure, PAPER, subdued},
        figures::scene_of,
    },
    pipeline::colour_choice::{ColourScore, ColourSelection, ColourSet, TileScore},
};

/// The largest error of a pair: the two can't be told apart at all.
const WORST_PAIR_ERROR: f64 = 0.5;

pub(super) fn section(
    selection: &ColourSelection,
    content: &Content<'_>,
) -> Result<Section<'static>, OutputError> {
    let reasons: String = selection
        .reasons
        .iter()
        .map(|reason| format!("<li>{}</li>", escaped(reason)))
        .collect();
    let measured = if selection.measured {
        ""
    } else {
        "<p><b>No projected light was seen; this is the choice for a grey wall.</b></p>\n"
    };
    let regions = regions(selection, content)?;
    let body = format!(
        "{measured}<p>{} Expected share of line pixels read wrongly: <b>{}</b>. Single-colour grid: {}</p>\n\
         <ul>{reasons}</ul>\n\
         <h3>Each colour on this scene</h3>\n{}\
         <h3>How well pairs are told apart</h3>\n<p class=\"note\">Probability that a pixel of one colour is taken \
         for the other, in percent; the last column: that its lines are not seen in a coded frame without a single-colour \
         one.</p>\n{}\
         <h3>The best sets of four</h3>\n{}{regions}",
        chips(selection, &selection.best),
        percent(selection.expected_error),
        chips(selection, &[selection.unary]),
        scores(selection),
        separability(selection),
        ranking(selection),
    );
    Ok(Section {
        id: "colours",
        title: "Why these colours",
        body: body.into(),
    })
}

fn name(selection: &ColourSelection, colour: Rgb) -> String {
    let known = selection.colours.iter().find(|c| c.colour == colour);
    known.map_or(colour.to_string(), |c| escaped(&c.name))
}

fn chips(selection: &ColourSelection, colours: &[Rgb]) -> String {
    let chips: Vec<_> = colours
        .iter()
        .map(|&colour| format!("{}{}", swatch(colour), name(selection, colour)))
        .collect();
    format!("{}.", chips.join(", "))
}

fn scores(selection: &ColourSelection) -> String {
    let most = selection.colours.iter().map(|c| c.recovered_px).max();
    let most = most.unwrap_or(0).max(1) as f64;
    let rows: String = selection
        .colours
        .iter()
        .map(|colour| score_row(selection, colour, most))
        .collect();
    format!(
        "<div class=\"scroll\"><table>\n<thead><tr><th>Colour</th><th>Recovered grid pixels</th>\
         <th>of those expected</th><th>Hues recovered</th><th>Line error</th><th></th></tr></thead>\n\
         <tbody>\n{rows}</tbody></table></div>\n"
    )
}

fn score_row(selection: &ColourSelection, score: &ColourScore, most: f64) -> String {
    let colour = score.colour;
    let in_grid = selection.best.contains(&colour);
    let grid_tag = if in_grid {
        "<span class=\"tag\">grid</span> "
    } else {
        ""
    };
    let unary_tag = if colour == selection.unary {
        "<span class=\"tag\">unary</span>"
    } else {
        ""
    };
    format!(
        "<tr{}><th scope=\"row\">{}{}</th><td>{}{}</td><td>{}</td><td>{}</td><td>{:.3} px</td><td>{grid_tag}{unary_tag}</td></tr>\n",
        if in_grid { " class=\"chosen\"" } else { "" },
        swatch(colour),
        escaped(&score.name),
        bar(score.recovered_px as f64 / most, colour),
        score.recovered_px,
        percent(score.share_of_expected),
        histogram(&score.hue_histogram),
        score.line_error_px,
    )
}

/// Bars from red round to red, each in its own hue.
fn histogram(bins: &[u32]) -> String {
    let most = f64::from(bins.iter().max().copied().unwrap_or(0).max(1));
    let (width, height) = (140.0, 28.0);
    let mut drawing = Drawing::new(width, height);
    let step = width / bins.len().max(1) as f64;
    let grey = Ink::solid([127; 3]).faded(0.5);
    drawing.stroke([[0.0, height - 0.5], [width, height - 0.5]], 1.0, grey);
    for (k, &count) in bins.iter().enumerate().filter(|(_, count)| **count > 0) {
        let share = (k as f64 + 0.5) / bins.len() as f64;
        let bar = (height - 1.0) * f64::from(count) / most;
        drawing
            .rectangle(
                [k as f64 * step, height - 1.0 - bar],
                [step, bar],
                Ink::solid(pure_hue(share)),
            )
            .titled(format!("hue {:.0}°: {count} px", 360.0 * share));
    }
    drawing.svg("histogram", "")
}

/// The fully saturated colour of a hue, as a share of the circle from red.
fn pure_hue(share: f64) -> [u8; 3] {
    let channel = |shift: f64| {
        let sixth = (6.0 * share + shift).rem_euclid(6.0);
        let level = (sixth.min(4.0 - sixth)).clamp(0.0, 1.0);
        (225.0 * level) as u8
    };
    [channel(2.0), channel(0.0), channel(4.0)]
}

/// A cell whose ground is redder the larger the share (0 to 1) of the worst.
fn heat_cell(share: f64, text: &str, title: &str) -> String {
    let share = if share.is_nan() { 0.0 } else { share };
    let depth = 0.85 * share.clamp(0.0, 1.0).sqrt();
    format!(
        "<td style=\"background:rgba(var(--wrong),{depth:.2})\" title=\"{}\">{text}</td>",
        escaped(title)
    )
}

fn separability(selection: &ColourSelection) -> String {
    let (table, colours) = (&selection.separability, &selection.colours);
    let value = |rows: &[Vec<f64>], a: usize, b: usize| {
        rows.get(a)
            .and_then(|row| row.get(b))
            .copied()
            .unwrap_or(f64::NAN)
    };
    let entry = |list: &[f64], a: usize| list.get(a).copied().unwrap_or(f64::NAN);
    let short = |error: f64| match 100.0 * error {
        p if p.is_nan() || p < 0.05 => "·".to_owned(),
        p if p < 9.95 => format!("{p:.1}"),
        p => format!("{p:.0}"),
    };
    let rows: String = (0..colours.len())
        .map(|a| {
            let cells: String = (0..colours.len())
                .map(|b| {
                    if a == b {
                        return "<td></td>".to_owned();
                    }
                    let (error, distance) =
                        (value(&table.error, a, b), value(&table.distance, a, b));
                    let title = format!(
                        "{} and {}: error {:.2} %, distance {distance:.1}",
                        colours[a].name,
                        colours[b].name,
                        100.0 * error
                    );
                    heat_cell(error / WORST_PAIR_ERROR, &short(error), &title)
                })
                .collect();
            let (error, distance) = (entry(&table.dark_error, a), entry(&table.dark_distance, a));
            let title = format!(
                "{} lines: {:.2} % not seen, distance {distance:.1}",
                colours[a].name,
                100.0 * error
            );
            let dark = heat_cell(error, &short(error), &title);
            format!("<tr>{}{cells}{dark}</tr>\n", row_head(&colours[a]))
        })
        .collect();
    heat_table(colours, "<th>not seen</th>", &rows)
}

fn row_head(score: &ColourScore) -> String {
    format!(
        "<th scope=\"row\">{}{}</th>",
        swatch(score.colour),
        escaped(&score.name)
    )
}

fn heat_table(colours: &[ColourScore], last: &str, rows: &str) -> String {
    let head: String = colours
        .iter()
        .map(|c| {
            format!(
                "<th title=\"{}\">{}</th>",
                escaped(&c.name),
                swatch(c.colour)
            )
        })
        .collect();
    format!(
        "<div class=\"scroll\"><table class=\"heat\">\n<thead><tr><th></th>{head}{last}</tr></thead>\n\
         <tbody>\n{rows}</tbody></table></div>\n"
    )
}

fn ranking(selection: &ColourSelection) -> String {
    let row = |name: String, set: &ColourSet| {
        let chips: Vec<_> = set
            .colours
            .iter()
            .zip(&set.names)
            .map(|(&colour, name)| format!("{}{}", swatch(colour), escaped(name)))
            .collect();
        vec![
            name,
            chips.join(" &nbsp; "),
            percent(set.expected_error),
            format!("{:.1}", set.least_distance),
        ]
    };
    let mut rows: Vec<Vec<String>> = selection
        .ranking
        .iter()
        .enumerate()
        .map(|(k, set)| row((k + 1).to_string(), set))
        .collect();
    rows.push(row(
        "most pixels recovered".into(),
        &selection.thesis_choice,
    ));
    if let Some(current) = &selection.current {
        rows.push(row("in use before".into(), current));
    }
    let columns = ["Place", "Colours", "Expected error", "Least distance"];
    table(&columns, &rows)
}

/// The scene in regions: over its picture, and as a table of all colours.
fn regions(selection: &ColourSelection, content: &Content<'_>) -> Result<String, OutputError> {
    if selection.tiles.is_empty() {
        return Ok(String::new());
    }
    let map = match scene_of(content.folder, Stage::Background)? {
        Some(scene) => tile_map(&selection.tiles, &scene)?,
        None => String::new(),
    };
    let rows: String = selection
        .tiles
        .iter()
        .enumerate()
        .map(|(k, tile)| format!("<tr>{}</tr>\n", tile_cells(k, tile, &selection.colours)))
        .collect();
    Ok(format!(
        "<h3>Region by region</h3>\n<div class=\"pair\">\n{map}<div><p class=\"note\">How often a line of each colour is \
         seen in a region, in percent; empty where no projected light arrives.</p>\n{}</div></div>\n",
        heat_table(&selection.colours, "", &rows)
    ))
}

/// The regions over the scene's picture.
fn tile_map(tiles: &[TileScore], scene: &RgbImage) -> Result<String, OutputError> {
    let mut drawing = Drawing::new(scene.width().into(), scene.height().into());
    let unit = f64::from(scene.width()) / 640.0;
    for (k, tile) in tiles.iter().enumerate() {
        draw_tile(&mut drawing, k, tile, unit);
    }
    let map = Figure {
        picture: subdued(scene, 0.6),
        px_per_unit: 1.0,
        drawing,
    };
    let svg = map.svg(Encoding::Jpeg);
    let svg = svg.map_err(|source| OutputError::picture(Path::new("report.html"), source))?;
    let caption = "Regions of the scene with the expected error of the chosen four.";
    Ok(figure(&svg, caption))
}

fn draw_tile(drawing: &mut Drawing, k: usize, tile: &TileScore, unit: f64) {
    let [x, y, w, h] = [tile.x_px, tile.y_px, tile.width_px, tile.height_px].map(f64::from);
    let rim = [[x, y], [x + w, y], [x + w, y + h], [x, y + h], [x, y]];
    if let Some(error) = tile.expected_error {
        let share = if error.is_nan() {
            0.0
        } else {
            error.clamp(0.0, 1.0)
        };
        let red = Ink::solid([0xf0, 0x3c, 0x32]).faded(0.7 * share.sqrt());
        drawing.rectangle([x, y], [w, h], red);
    }
    drawing.stroke(rim, unit, PAPER.faded(0.6));
    let error = tile.expected_error.map_or("no light".to_owned(), |error| {
        percent(error).replace("&lt;", "<")
    });
    for (text, dy, size) in [(error, 0.0, 16.0), (format!("region {}", k + 1), 16.0, 9.5)] {
        drawing.text(Text {
            at: [x + w / 2.0, y + h / 2.0 + dy * unit],
            text,
            size: size * unit,
            anchor: Anchor::Middle,
            ink: PAPER,
            halo: Some(Ink::solid([16, 18, 22]).faded(0.6)),
        });
    }
}

fn tile_cells(k: usize, tile: &TileScore, colours: &[ColourScore]) -> String {
    let cells: String = colours
        .iter()
        .enumerate()
        .map(|(c, colour)| match tile.seen.get(c) {
            Some(&seen) => {
                let title = format!(
                    "region {}, {}: seen {:.1} %",
                    k + 1,
                    colour.name,
                    100.0 * seen
                );
                heat_cell(1.0 - seen, &format!("{:.0}", 100.0 * seen), &title)
            }
            None => "<td></td>".to_owned(),
        })
        .collect();
    format!("<th scope=\"row\">region {}</th>{cells}", k + 1)
}
