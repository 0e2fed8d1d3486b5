//! The content of a section: HTML, and photographs that are read and encoded only when the page is written.

use std::path::Path;

use image::RgbImage;

use super::{html::escaped, page::Page};
use crate::{
    output::{EncodedPicture, OutputError},
    scan::{CaptureEntry, ScanFolder},
};

/// A part of the page.
#[derive(Debug)]
pub(super) struct Section<'a> {
    /// Where the page's menu jumps to.
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    pub(super) body: Body<'a>,
}

/// Where a photograph is until then.
#[derive(Debug)]
pub(super) enum Photo<'a> {
    /// In the scan folder.
    Capture(&'a CaptureEntry),
    /// In memory, encoded.
    Encoded(&'a EncodedPicture),
}

impl Photo<'_> {
    fn read(&self, folder: &ScanFolder) -> Result<RgbImage, OutputError> {
        match self {
            Self::Capture(entry) => Ok(folder.picture(entry)?),
            Self::Encoded(picture) => picture
                .decode()
                .map_err(|source| OutputError::picture(Path::new(&picture.file), source)),
        }
    }
}

#[derive(Debug)]
enum Piece<'a> {
    Html(String),
    Figure { photo: Photo<'a>, caption: String },
}

/// HTML and photographs in their order.
#[derive(Debug, Default)]
pub(super) struct Body<'a> {
    pieces: Vec<Piece<'a>>,
}

impl From<String> for Body<'_> {
    fn from(html: String) -> Self {
        Self {
            pieces: vec![Piece::Html(html)],
        }
    }
}

impl<'a> Body<'a> {
    /// Adds HTML.
    pub(super) fn html(&mut self, html: impl Into<String>) -> &mut Self {
        self.pieces.push(Piece::Html(html.into()));
        self
    }

    /// Adds a photograph as a figure; the caption is plain text.
    pub(super) fn photograph(&mut self, photo: Photo<'a>, caption: String) -> &mut Self {
        self.pieces.push(Piece::Figure { photo, caption });
        self
    }

    /// Adds another body between an opening and a closing tag, if it holds anything.
    pub(super) fn within(&mut self, [open, close]: [&str; 2], inner: Self) -> &mut Self {
        if !inner.is_empty() {
            self.html(open);
            self.pieces.extend(inner.pieces);
            self.html(close);
        }
        self
    }

    /// Whether it holds nothing.
    pub(super) fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// Writes it, one photograph after the other.
    ///
    /// # Errors
    /// A photograph that can't be read or encoded, and what the page says.
    pub(super) fn write(&self, folder: &ScanFolder, page: &mut Page) -> Result<(), OutputError> {
        for piece in &self.pieces {
            match piece {
                Piece::Html(html) => page.text(html)?,
                Piece::Figure { photo, caption } => {
                    let caption = escaped(caption);
                    page.text("<figure><img src=\"")?;
                    page.photograph(&photo.read(folder)?)?;
                    let end = "</figcaption></figure>\n";
                    page.text(&format!("\" alt=\"{caption}\"><figcaption>{caption}{end}"))?;
                }
            }
        }
        Ok(())
    }
}
