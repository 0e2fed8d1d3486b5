//! All figures of the summary, as tables.

use shared::stage::Stage;

use super::{
    body::Section,
    html::{PAIR_OF_TABLES, escaped, percent, table},
};
use crate::output::{
    Summary,
    summary::{DifferenceFigures, LineShiftFigures, ShiftFigures, StageFigures, SurfaceFigures},
};

/// What stands for a figure that there is not.
const NONE: &str = "–";

pub(super) fn section(summary: &Summary) -> Section<'static> {
    let mut tables = vec![stages(summary)];
    tables.extend(summary.shifts.as_ref().map(shifts));
    tables.extend(summary.line_shifts.as_ref().map(line_shifts));
    tables.extend(summary.surface.as_ref().map(surface));
    tables.extend(summary.difference.as_ref().map(difference));
    let warnings = summary.warnings.iter();
    let warnings: String = warnings
        .map(|warning| format!("<p>Warning: {}</p>\n", escaped(warning)))
        .collect();
    let [open, close] = PAIR_OF_TABLES;
    Section {
        id: "figures",
        title: "Figures",
        body: format!("{warnings}{open}{}{close}", tables.concat()).into(),
    }
}

fn stages(summary: &Summary) -> String {
    let stages = Stage::BOTH.map(|stage| summary.stage(stage));
    let row = |name: &str, value: &dyn Fn(&StageFigures) -> String| -> Vec<String> {
        let cells = stages.map(|figures| figures.map_or(NONE.to_owned(), value));
        [name.to_owned()].into_iter().chain(cells).collect()
    };
    let confidence = |f: &StageFigures| {
        let mean = f.mean_confidence;
        mean.map_or(NONE.to_owned(), |c| format!("{c:.3}"))
    };
    table(
        &["Reading", "before", "after"],
        &[
            row("Crossings of the grid", &|f| {
                f.crossings_possible.to_string()
            }),
            row("Crossings labelled", &|f| f.crossings_labelled.to_string()),
            row("Coverage", &|f| percent(f.coverage_percent / 100.0)),
            row("Vertices", &|f| f.vertices.to_string()),
            row("Mean confidence", &confidence),
            row("Crossings dropped", &|f| f.dropped_total.to_string()),
            row("Points along decoded lines", &|f| f.line_points.to_string()),
        ],
    )
}

/// A table of names and values.
fn facts<const N: usize>(title: &str, facts: [(&str, String); N]) -> String {
    let rows = facts.map(|(name, value)| vec![name.to_owned(), value]);
    table(&[title, ""], &rows)
}

fn shifts(s: &ShiftFigures) -> String {
    let pair = |a: f64, b: f64| format!("{a:.2} px, {b:.2} px");
    facts(
        "Shifts",
        [
            ("Vertices in both stages", s.vertices.to_string()),
            ("Smallest, median", pair(s.smallest_px, s.median_px)),
            ("Mean, largest", pair(s.mean_px, s.largest_px)),
            ("Relative depth of 1 px", s.depth_per_px.to_string()),
        ],
    )
}

fn line_shifts(s: &LineShiftFigures) -> String {
    let across = s.across_rms_px;
    let across = across.map_or(NONE.to_owned(), |px| format!("{px:.3} px"));
    facts(
        "Shifts along the epipolar direction",
        [
            ("Line points with a shift", s.points.to_string()),
            (
                "Line points without: along it",
                s.along_epipolar.to_string(),
            ),
            (
                "Line points without: no background",
                s.not_in_background.to_string(),
            ),
            ("Error across (RMS)", across),
            (
                "Vertices rejected (3 sigma)",
                s.rejected_vertices.to_string(),
            ),
        ],
    )
}

fn surface(s: &SurfaceFigures) -> String {
    let range = |[low, high]: [f64; 2]| format!("{low:.1} to {high:.1} mm");
    let left_out = s.dropped.iter().filter(|(_, count)| **count > 0);
    let left_out: Vec<String> = left_out
        .map(|(reason, count)| format!("{count} {}", reason.replace('_', " ")))
        .collect();
    facts(
        "Surface",
        [
            ("Points", s.points.to_string()),
            ("of these vertices", s.vertices.to_string()),
            (
                "Left out",
                if left_out.is_empty() {
                    "none".to_owned()
                } else {
                    left_out.join(", ")
                },
            ),
            ("x, to the right", range(s.x_mm)),
            ("y, downwards", range(s.y_mm)),
            ("z, forward", range(s.z_mm)),
            ("Median z", format!("{:.1} mm", s.median_z_mm)),
        ],
    )
}

fn difference(s: &DifferenceFigures) -> String {
    facts(
        "Object over background",
        [
            ("Points compared", s.points.to_string()),
            ("Median height", format!("{:.2} mm", s.median_mm)),
            ("95 % below", format!("{:.1} mm", s.p95_mm)),
            ("Largest height", format!("{:.1} mm", s.largest_mm)),
        ],
    )
}
