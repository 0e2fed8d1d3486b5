//! Rectangular parts of a picture.

use std::ops::Range;

/// A part of a picture, px.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Region {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

impl Region {
    /// A whole picture of the given width and height.
    pub(super) fn whole((width, height): (usize, usize)) -> Self {
        Self {
            columns: 0..width,
            rows: 0..height,
        }
    }

    /// Its pixels' numbers in a picture with rows of `width`, row by row.
    pub(super) fn pixels(&self, width: usize) -> impl Iterator<Item = usize> {
        let columns = self.columns.clone();
        let rows = self.rows.clone();
        rows.flat_map(move |y| y * width + columns.start..y * width + columns.end)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.columns.is_empty() || self.rows.is_empty()
    }
}
