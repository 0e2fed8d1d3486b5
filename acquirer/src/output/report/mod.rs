//! The report: one HTML file that holds everything a reader needs, pictures included.
//!
//! Takes what was projected, captured, chosen and read, gives a page without scripts and without references to
//! anything outside of it. Photographs are embedded as JPEG, drawings as SVG, so that letters stay crisp on
//! paper; marks say what they are when pointed at. A part that was not recorded is left out. One file for each
//! section, in the order of the page.

mod body;
mod html;
mod page;

mod header;

mod shape;

mod pattern;

mod scene;

mod colours;

mod reading;

mod labels;

mod finer;

mod figures;

mod response;

mod settings;

use std::path::Path;

use super::{EncodedPicture, OutputError, Summary, figures::Figures};
use crate::{pipeline::colour_choice::ColourSelection, scan::ScanFolder};
use body::Section;
use html::escaped;
use page::Page;

/// The look of the page: light, dark, narrow, printed.
const STYLE: &str = include_str!("style.css");
/// How to read the page, and what lies beside it.
const GUIDE: &str = include_str!("guide.html");

/// What the report is about.
#[derive(Debug, Clone, Copy)]
pub(super) struct Content<'a> {
    pub(super) folder: &'a ScanFolder,
    pub(super) summary: &'a Summary,
    pub(super) figures: &'a Figures,
    /// Before and after.
    pub(super) stage_pictures: &'a [Vec<EncodedPicture>; 2],
    pub(super) selection: Option<&'a ColourSelection>,
}

/// Writes the whole page.
///
/// # Errors
/// A picture that can't be read or encoded, and what the system says of the file.
pub(super) fn write(path: &Path, content: &Content<'_>) -> Result<(), OutputError> {
    let colours = content
        .selection
        .map(|selection| colours::section(selection, content))
        .transpose()?;
    let guide = Section {
        id: "guide",
        title: "How to read this report",
        body: GUIDE.to_owned().into(),
    };
    let sections = [
        shape::section(content),
        Some(pattern::section(content.summary)),
        scene::section(content),
        colours,
        reading::section(content),
        labels::section(content),
        finer::section(content),
        Some(figures::section(content.summary)),
        response::section(content.summary),
        settings::section(content.summary),
        Some(guide),
    ];
    let sections: Vec<Section<'_>> = sections.into_iter().flatten().collect();
    let mut page = Page::create(path)?;
    page.text(&head(content.summary, &sections))?;
    for section in &sections {
        let title = escaped(section.title);
        page.text(&format!(
            "<section id=\"{}\">\n<h2>{title}</h2>\n",
            section.id
        ))?;
        section.body.write(content.folder, &mut page)?;
        page.text("</section>\n")?;
    }
    page.text("</main>\n</body>\n</html>\n")?;
    page.finish()
}

fn head(summary: &Summary, sections: &[Section<'_>]) -> String {
    let entries: String = sections
        .iter()
        .map(|s| format!("<a href=\"#{}\">{}</a>", s.id, escaped(s.title)))
        .collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>Scan report</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         {}\n<nav>{entries}</nav>\n<main>\n",
        header::header(summary)
    )
}
