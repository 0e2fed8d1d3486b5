//! The decoded grids and what was dropped.

use shared::{pattern::Rgb, stage::Stage};

use super::{
    Content,
    body::Section,
    html::{bar, figures, table},
};
use crate::{
    output::{
        Summary,
        maps::{reason_colour, reason_words},
        summary::StageFigures,
    },
    pipeline::grid::DropReason,
};

pub(super) fn section<'a>(content: &Content<'a>) -> Option<Section<'a>> {
    let labels = figures(&content.figures.labels);
    if labels.is_empty() {
        return None;
    }
    let lead = "<p>Lines are drawn in the colour they were projected in, grey where they have no label. Numbers count \
                rows and columns from 0. Point at a vertex for its label, position and confidence.</p>\n";
    let body = format!(
        "{lead}{labels}<h3>Crossings found and not labelled</h3>\n{}",
        holes(content.summary)
    );
    Some(Section {
        id: "labels",
        title: "The decoded grid",
        body: body.into(),
    })
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
            let colour = Rgb(reason_colour(reason));
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
    let stages = Stage::BOTH.into_iter().zip(["before", "after"]);
    let stages = stages.filter(|(stage, _)| summary.stage(*stage).is_some());
    let columns: Vec<&str> = ["Reason"]
        .into_iter()
        .chain(stages.map(|(_, when)| when))
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
