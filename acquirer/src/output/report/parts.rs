//! The parts of the report about the scan itself: headline figures, scene, reading, labels, shape, settings.

use shared::stage::Stage;

use super::{
    Content,
    html::{
        Encoding, Section, bar, drawn, escaped, figure, percent, photograph, side_by_side, table,
    },
};
use crate::{
    output::{
        OutputError, Summary,
        maps::{reason_colour, reason_words},
        pictures::Named,
        summary::StageFigures,
    },
    pipeline::{Captures, Method, grid::DropReason},
};

/// What stands for a figure that there is not.
const NONE: &str = "–";

/// The title and the figures that matter most.
pub(super) fn header(summary: &Summary) -> String {
    let grid = &summary.pattern.coded;
    let mut cards = Vec::new();
    for (stage, words) in [
        (Stage::Object, "of the grid read with the object"),
        (Stage::Background, "of the grid read before"),
    ] {
        if let Some(figures) = summary.stage(stage) {
            let share = figures.coverage_percent / 100.0;
            let detail = format!(
                "{} of {} crossings",
                figures.crossings_labelled, figures.crossings_possible
            );
            cards.push((percent(share), words.to_owned(), detail));
        }
    }
    if let Some(shifts) = &summary.shifts {
        let detail = format!("largest of {} vertices in both stages", shifts.vertices);
        cards.push((
            format!("{:.1} px", shifts.largest_px),
            "shift".into(),
            detail,
        ));
    }
    if let Some(surface) = &summary.surface {
        let [near, far] = surface.z_mm;
        let detail = format!(
            "{} vertices; z from {near:.0} to {far:.0} mm",
            surface.vertices
        );
        cards.push((surface.points.to_string(), "surface points".into(), detail));
    }
    let cards: String = cards
        .into_iter()
        .map(|(value, what, detail)| {
            format!("<div><b>{value}</b><span>{what}</span><small>{detail}</small></div>")
        })
        .collect();
    format!(
        "<header>\n<h1>Scan report</h1>\n<p>{} × {} coded grid, projector {} × {} px, camera {} × {} px, {}, {}.</p>\n<div class=\"cards\">{cards}</div>\n</header>",
        grid.rows(),
        grid.columns(),
        summary.projector.width,
        summary.projector.height,
        summary.camera.width,
        summary.camera.height,
        method_words(summary.method),
        if summary.calibrated {
            "calibrated"
        } else {
            "without calibration"
        }
    )
}

fn method_words(method: Method) -> &'static str {
    match method {
        Method::Likelihood => "likelihood method",
        Method::Thesis => "method of the thesis of 2001",
    }
}

/// The scene before and after, as the camera saw it.
pub(super) fn scene(content: &Content<'_>) -> Result<Option<Section>, OutputError> {
    let mut body = String::new();
    for (captures, when) in content.captures.into_iter().zip(["Before", "After"]) {
        let mut row = String::new();
        for (pictures, light) in kinds(captures) {
            if let Some(picture) = pictures.first() {
                row += &photograph(picture, &format!("{when}: {light}."))?;
            }
        }
        if !row.is_empty() {
            body += &format!("<div class=\"row\">\n{row}</div>\n");
        }
    }
    Ok((!body.is_empty()).then_some(Section {
        id: "scene",
        title: "The scene",
        body,
    }))
}

fn kinds(captures: &Captures) -> [(&[image::RgbImage], &'static str); 4] {
    [
        (&captures.black, "projector black"),
        (&captures.white, "projector white"),
        (&captures.prmvs, "coded grid"),
        (&captures.unary, "single-colour grid"),
    ]
}

/// The pipeline's own pictures, both stages side by side.
pub(super) fn reading(content: &Content<'_>) -> Result<Option<Section>, OutputError> {
    let stages = &content.pictures.stages;
    let most = stages.iter().map(|(_, pictures)| pictures.len()).max();
    let mut body = String::new();
    for k in 0..most.unwrap_or(0) {
        let mut row = String::new();
        for (stage, pictures) in stages {
            if let Some(picture) = pictures.get(k) {
                let caption = format!("{}. {} ({stage})", k + 1, picture.caption);
                row += &photograph(&picture.picture, &caption)?;
            }
        }
        body += &side_by_side(&row);
    }
    Ok((!body.is_empty()).then_some(Section {
        id: "reading",
        title: "How the grid was read, step by step",
        body,
    }))
}

/// The decoded grids and what was dropped.
pub(super) fn labels(content: &Content<'_>) -> Result<Option<Section>, OutputError> {
    let figures = all_drawn(&content.pictures.labels, Encoding::Jpeg)?;
    if figures.is_empty() {
        return Ok(None);
    }
    let lead = "<p>Lines are drawn in the colour they were projected in, grey where they have no label. Numbers count \
                rows and columns from 0. Point at a vertex for its label, position and confidence.</p>\n";
    Ok(Some(Section {
        id: "labels",
        title: "The decoded grid",
        body: format!(
            "{lead}{figures}<h3>Crossings found and not labelled</h3>\n{}",
            holes(content.summary)
        ),
    }))
}

/// How many crossings were dropped for each reason.
fn holes(summary: &Summary) -> String {
    let stages: Vec<&StageFigures> = Stage::BOTH
        .iter()
        .filter_map(|s| summary.stage(*s))
        .collect();
    let count = |figures: &StageFigures, reason: DropReason| {
        figures.dropped.get(reason.name()).copied().unwrap_or(0)
    };
    let most = stages
        .iter()
        .flat_map(|figures| figures.dropped.values())
        .max()
        .copied()
        .unwrap_or(0)
        .max(1);
    let rows: Vec<Vec<String>> = DropReason::ALL
        .into_iter()
        .map(|reason| {
            let colour = shared::pattern::Rgb(reason_colour(reason));
            let counts = stages.iter().map(|figures| {
                let count = count(figures, reason);
                format!("{} {count}", bar(count as f64 / most as f64, colour))
            });
            [reason_words(reason).to_owned()]
                .into_iter()
                .chain(counts)
                .chain([reason_advice(reason).to_owned()])
                .collect()
        })
        .collect();
    let stages = Stage::BOTH
        .into_iter()
        .filter(|s| summary.stage(*s).is_some());
    let columns: Vec<&str> = ["Reason"]
        .into_iter()
        .chain(stages.map(Stage::name))
        .chain(["What it means"])
        .collect();
    table(&columns, &rows)
}

fn reason_advice(reason: DropReason) -> &'static str {
    match reason {
        DropReason::TooDark => {
            "Too little projected light came back: shadow, black or far surface."
        }
        DropReason::Clipped => "The camera was saturated: expose shorter, or avoid shine.",
        DropReason::AmbiguousColour => {
            "A line could be more than one of the colours: choose colours for this scene."
        }
        DropReason::BrokenLine => "Too few connected neighbours: edges, fine structure, gaps.",
        DropReason::NotInCode => "No place of the sequence fits, or more than one does.",
        DropReason::OffEpipolarLine => {
            "The label contradicts the geometry or better supported neighbours."
        }
    }
}

/// Shifts, depth, and the surface.
pub(super) fn shape(content: &Content<'_>) -> Result<Option<Section>, OutputError> {
    let views = all_drawn(&content.pictures.views, Encoding::Png)?;
    let maps = all_drawn(&content.pictures.maps, Encoding::Png)?;
    let body = [views, maps]
        .iter()
        .filter(|figures| !figures.is_empty())
        .map(|figures| side_by_side(figures))
        .collect::<String>();
    Ok((!body.is_empty()).then_some(Section {
        id: "shape",
        title: "Shape of the object",
        body,
    }))
}

fn all_drawn(named: &[Named], encoding: Encoding) -> Result<String, OutputError> {
    named
        .iter()
        .map(|n| Ok(figure(&drawn(&n.figure, encoding)?, n.caption)))
        .collect()
}

/// All figures of the summary.
pub(super) fn figures(summary: &Summary) -> Section {
    let stages = [Stage::Background, Stage::Object].map(|stage| summary.stage(stage));
    let row = |name: &str, value: &dyn Fn(&StageFigures) -> String| -> Vec<String> {
        let cells = stages.map(|figures| figures.map_or(NONE.to_owned(), value));
        [name.to_owned()].into_iter().chain(cells).collect()
    };
    let mut body = table(
        &["Reading", "before", "after"],
        &[
            row("Crossings of the grid", &|f| {
                f.crossings_possible.to_string()
            }),
            row("Crossings labelled", &|f| f.crossings_labelled.to_string()),
            row("Coverage", &|f| percent(f.coverage_percent / 100.0)),
            row("Vertices", &|f| f.vertices.to_string()),
            row("Mean confidence", &|f| {
                f.mean_confidence
                    .map_or(NONE.to_owned(), |c| format!("{c:.3}"))
            }),
            row("Crossings dropped", &|f| f.dropped_total.to_string()),
            row("Points along decoded lines", &|f| f.line_points.to_string()),
        ],
    );
    let fact = |name: &str, value: String| vec![name.to_owned(), value];
    if let Some(s) = &summary.shifts {
        body += &table(
            &["Shifts", ""],
            &[
                fact("Vertices in both stages", s.vertices.to_string()),
                fact(
                    "Smallest, median",
                    format!("{:.2} px, {:.2} px", s.smallest_px, s.median_px),
                ),
                fact(
                    "Mean, largest",
                    format!("{:.2} px, {:.2} px", s.mean_px, s.largest_px),
                ),
                fact("Relative depth of 1 px", s.depth_per_px.to_string()),
            ],
        );
    }
    if let Some(s) = &summary.line_shifts {
        let across = s
            .across_rms_px
            .map_or(NONE.to_owned(), |px| format!("{px:.3} px"));
        body += &table(
            &["Shifts along the epipolar direction", ""],
            &[
                fact("Line points with a shift", s.points.to_string()),
                fact("Lines along the direction", s.along_epipolar.to_string()),
                fact(
                    "Not read in the background",
                    s.not_in_background.to_string(),
                ),
                fact("Error across (RMS)", across),
                fact(
                    "Vertices rejected (3 sigma)",
                    s.rejected_vertices.to_string(),
                ),
            ],
        );
    }
    if let Some(s) = &summary.difference {
        body += &table(
            &["Object over background", ""],
            &[
                fact("Points compared", s.points.to_string()),
                fact("Median height", format!("{:.2} mm", s.median_mm)),
                fact("95 % below", format!("{:.1} mm", s.p95_mm)),
                fact("Largest height", format!("{:.1} mm", s.largest_mm)),
            ],
        );
    }
    for warning in &summary.warnings {
        body += &format!("<p>Warning: {}</p>\n", escaped(warning));
    }
    if let Some(s) = &summary.surface {
        let range = |[low, high]: [f64; 2]| format!("{low:.1} to {high:.1} mm");
        body += &table(
            &["Surface", ""],
            &[
                fact("Points", s.points.to_string()),
                fact("of these vertices", s.vertices.to_string()),
                fact("x, to the right", range(s.x_mm)),
                fact("y, downwards", range(s.y_mm)),
                fact("z, forward", range(s.z_mm)),
                fact("Median z", format!("{:.1} mm", s.median_z_mm)),
            ],
        );
    }
    Section {
        id: "figures",
        title: "Figures",
        body: format!("<div class=\"pair tables\">\n{body}</div>\n"),
    }
}

/// The effective settings, one line each.
pub(super) fn settings(summary: &Summary) -> Option<Section> {
    let mut rows = Vec::new();
    flatten("", &summary.settings, &mut rows);
    (!rows.is_empty()).then(|| Section {
        id: "settings",
        title: "Settings",
        body: table(&["Setting", "Value"], &rows),
    })
}

fn flatten(path: &str, value: &serde_json::Value, rows: &mut Vec<Vec<String>>) {
    match value {
        serde_json::Value::Null => {}
        serde_json::Value::Object(entries) => {
            for (key, value) in entries {
                let path = if path.is_empty() {
                    key.clone()
                } else {
                    format!("{path}.{key}")
                };
                flatten(&path, value, rows);
            }
        }
        serde_json::Value::String(text) => rows.push(vec![escaped(path), escaped(text)]),
        other => rows.push(vec![escaped(path), escaped(&other.to_string())]),
    }
}

/// How to read the page and what lies beside it.
pub(super) fn guide() -> Section {
    Section {
        id: "guide",
        title: "How to read this report",
        body: include_str!("guide.html").to_owned(),
    }
}
