//! The report: one HTML file that holds everything a reader needs, pictures included.
//!
//! Takes what was projected, captured, chosen and read, gives a page without scripts and without references to
//! anything outside of it. Photographs are embedded as JPEG, drawings as SVG, so that letters stay crisp on
//! paper; marks say what they are when pointed at. A part that was not recorded is left out.

mod colours;

mod finer;

mod html;

mod parts;

mod pattern;

mod response;

use super::{OutputError, Summary, pictures::Pictures};
use crate::pipeline::{Captures, colour_choice::ColourSelection};
use html::{Section, escaped};

/// The look of the page: light, dark, narrow, printed.
const STYLE: &str = include_str!("style.css");

/// What the report is about.
#[derive(Debug, Clone, Copy)]
pub(super) struct Content<'a> {
    pub(super) summary: &'a Summary,
    /// Before and after.
    pub(super) captures: [&'a Captures; 2],
    pub(super) pictures: &'a Pictures<'a>,
    pub(super) selection: Option<&'a ColourSelection>,
}

/// The whole page.
///
/// # Errors
/// A picture that can't be encoded.
pub(super) fn page(content: &Content<'_>) -> Result<String, OutputError> {
    let colours = content
        .selection
        .map(|selection| colours::section(selection, content))
        .transpose()?;
    let sections: Vec<Section> = [
        parts::shape(content)?,
        Some(pattern::section(content.summary)),
        parts::scene(content)?,
        colours,
        parts::reading(content)?,
        parts::labels(content)?,
        finer::section(content)?,
        Some(parts::figures(content.summary)),
        response::section(content.summary),
        parts::settings(content.summary),
        Some(parts::guide()),
    ]
    .into_iter()
    .flatten()
    .collect();
    Ok(document(content.summary, &sections))
}

fn document(summary: &Summary, sections: &[Section]) -> String {
    let entries: String = sections
        .iter()
        .map(|s| format!("<a href=\"#{}\">{}</a>", s.id, escaped(s.title)))
        .collect();
    let bodies: String = sections.iter().map(Section::html).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>Scan report</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         {}\n<nav>{entries}</nav>\n<main>\n{bodies}</main>\n</body>\n</html>\n",
        parts::header(summary)
    )
}
