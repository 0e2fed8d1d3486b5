//! Pieces of HTML: sections, figures, tables, colours.

use std::path::PathBuf;

use base64::{Engine as _, engine::general_purpose::STANDARD};
use image::{ImageFormat, RgbImage, codecs::jpeg::JpegEncoder};
use shared::pattern::Rgb;

pub(super) use crate::output::drawing::escaped;
use crate::output::{OutputError, figure::Figure};

/// Quality of embedded photographs: without visible blocks round thin coloured lines.
const JPEG_QUALITY: u8 = 90;

/// A part of the page.
#[derive(Debug)]
pub(super) struct Section {
    /// Where the page's menu jumps to.
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    /// HTML.
    pub(super) body: String,
}

impl Section {
    pub(super) fn html(&self) -> String {
        format!(
            "<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n",
            self.id,
            escaped(self.title),
            self.body
        )
    }
}

/// How a picture is embedded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    /// For photographs.
    Jpeg,
    /// For pictures with flat colours.
    Png,
}

/// A picture as the address of itself.
pub(super) fn data_uri(picture: &RgbImage, encoding: Encoding) -> Result<String, OutputError> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let done = match encoding {
        Encoding::Jpeg => {
            picture.write_with_encoder(JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY))
        }
        Encoding::Png => picture.write_to(&mut bytes, ImageFormat::Png),
    };
    done.map_err(|source| OutputError::Picture {
        path: PathBuf::from("report.html"),
        source,
    })?;
    let kind = match encoding {
        Encoding::Jpeg => "jpeg",
        Encoding::Png => "png",
    };
    let data = STANDARD.encode(bytes.get_ref());
    Ok(format!("data:image/{kind};base64,{data}"))
}

/// A figure from its content (HTML) and a caption in plain text.
pub(super) fn figure(content: &str, caption: &str) -> String {
    let caption = escaped(caption);
    format!("<figure>{content}<figcaption>{caption}</figcaption></figure>\n")
}

/// A photograph with a caption.
pub(super) fn photograph(picture: &RgbImage, caption: &str) -> Result<String, OutputError> {
    let uri = data_uri(picture, Encoding::Jpeg)?;
    let image = format!("<img src=\"{uri}\" alt=\"{}\">", escaped(caption));
    Ok(figure(&image, caption))
}

/// A drawing over its picture, as SVG.
pub(super) fn drawn(figure: &Figure, encoding: Encoding) -> Result<String, OutputError> {
    let size = [figure.picture.width(), figure.picture.height()];
    let [width, height] = size.map(|px| f64::from(px) / figure.px_per_unit);
    let below = format!(
        "<image width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" href=\"{}\"/>",
        data_uri(&figure.picture, encoding)?
    );
    Ok(figure.drawing.svg("paper", &below))
}

/// Things that stand side by side where there is room.
pub(super) fn side_by_side(content: &str) -> String {
    format!("<div class=\"pair\">\n{content}</div>\n")
}

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
