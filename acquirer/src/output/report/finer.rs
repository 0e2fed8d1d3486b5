//! The finer grids: what each adds, and where.

use shared::stage::Stage;

use super::{
    Content,
    body::Section,
    html::{PAIR, figures, percent, table},
};
use crate::output::finer::FinerFigures;

/// The section about finer grids; none without any.
pub(super) fn section<'a>(content: &Content<'a>) -> Option<Section<'a>> {
    let finer = &content.summary.finer;
    if finer.is_empty() {
        return None;
    }
    let rows: Vec<Vec<String>> = finer.iter().map(row).collect();
    let columns = [
        "Grid",
        "labelled before",
        "labelled with the object",
        "line points",
        "surface points",
    ];
    let lead = "<p>Each grid is read beside the known places of the coarser ones: a patch of it too small for its own \
                code gets its place from them, and one that contradicts them is dropped.</p>\n";
    let [open, close] = PAIR;
    let figures = figures(&content.figures.finer);
    let body = format!("{lead}{}{open}{figures}{close}", table(&columns, &rows));
    Some(Section {
        id: "finer",
        title: "Finer grids",
        body: body.into(),
    })
}

fn row(figures: &FinerFigures) -> Vec<String> {
    let [rows, columns] = figures.lines;
    let labelled = |stage: Stage| {
        figures.stage(stage).map_or("–".to_owned(), |f| {
            let share = percent(f.coverage_percent / 100.0);
            format!("{} ({share})", f.crossings_labelled)
        })
    };
    let line_points = figures.stage(Stage::Object).map_or(0, |f| f.line_points);
    vec![
        format!("{rows} × {columns}"),
        labelled(Stage::Background),
        labelled(Stage::Object),
        line_points.to_string(),
        figures.points.to_string(),
    ]
}
