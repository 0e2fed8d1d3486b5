//! The title of the report and the figures that matter most.

use shared::stage::Stage;

use super::html::percent;
use crate::{output::Summary, pipeline::Method};

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
