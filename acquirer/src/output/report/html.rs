//! Pieces of HTML: figures, tables, colours.

use shared::pattern::Rgb;

pub(super) use crate::output::drawing::escaped;
use crate::output::figures::SavedFigure;

/// A figure from its content (HTML) and a caption in plain text.
pub(super) fn figure(content: &str, caption: &str) -> String {
    let caption = escaped(caption);
    format!("<figure>{content}<figcaption>{caption}</figcaption></figure>\n")
}

/// Figures one after the other.
pub(super) fn figures(figures: &[SavedFigure]) -> String {
    let html = figures.iter().map(|f| figure(&f.svg, f.caption));
    html.collect()
}

/// Around things that stand side by side where there is room.
pub(super) const PAIR: [&str; 2] = ["<div class=\"pair\">\n", "</div>\n"];
/// The same for narrow tables.
pub(super) const PAIR_OF_TABLES: [&str; 2] = ["<div class=\"pair tables\">\n", "</div>\n"];

/// A small field of a colour.
pub(super) fn swatch(colour: Rgb) -> String {
    format!("<i class=\"swatch\" style=\"background:{colour}\" title=\"{colour}\"></i>")
}

/// A table from its column names and rows; cells are HTML, the first column names the row.
pub(super) fn table(columns: &[&str], rows: &[Vec<String>]) -> String {
    let head: String = columns.iter().map(|c| format!("<th>{c}</th>")).collect();
    let body: String = rows
        .iter()
        .map(|row| {
            let cells: String = row
                .iter()
                .enumerate()
                .map(|(k, cell)| match k {
                    0 => format!("<th scope=\"row\">{cell}</th>"),
                    _ => format!("<td>{cell}</td>"),
                })
                .collect();
            format!("<tr>{cells}</tr>\n")
        })
        .collect();
    format!(
        "<div class=\"scroll\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody></table></div>\n"
    )
}

/// A share (0 to 1) as percent, with as many digits as it is worth.
pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        p if !p.is_finite() => "–".to_owned(),
        0.0 => "0 %".to_owned(),
        p if p < 0.01 => "&lt; 0.01 %".to_owned(),
        p if p < 1.0 => format!("{p:.2} %"),
        p if p < 99.95 => format!("{p:.1} %"),
        p => format!("{p:.0} %"),
    }
}

/// A bar for a share (0 to 1) in a colour.
pub(super) fn bar(share: f64, colour: Rgb) -> String {
    let share = if share.is_nan() { 0.0 } else { share };
    let width = 100.0 * share.clamp(0.0, 1.0);
    format!("<span class=\"bar\"><i style=\"width:{width:.1}%;background:{colour}\"></i></span>")
}
