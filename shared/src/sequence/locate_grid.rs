//! Where a window of crossings lies in the grid.
//!
//! Takes the symbols of neighbouring rows and of neighbouring columns, gives the indices of the
//! first row and the first column. Rows and columns carry independent sequences, so each index is
//! found alone. A grid has an end where its sequence has none: 31 and 127 lines are the first terms
//! of 63 and 255, and a window that would run over the last line is rejected.
//!
//! Source: section 3.1.4 of the thesis.
//!
//! As in one dimension, a wrong symbol nearly always gives another index rather than an error.

use super::lines::line_sequence;
use super::{Alphabet, Locator, Method, SequenceError, Symbol, WindowError, window_order};
use crate::field::Element;

/// Finds windows among the lines of one direction.
#[derive(Debug, Clone)]
pub struct LineLocator {
    locator: Locator,
    lines: usize,
    order: usize,
}

impl LineLocator {
    /// A locator for windows of [`window_order`] adjacent lines.
    ///
    /// # Errors
    /// [`SequenceError::UnsupportedLines`] unless `lines` is 15, 31, 63, 127 or 255.
    pub fn new(alphabet: Alphabet, lines: usize, method: Method) -> Result<Self, SequenceError> {
        let order = window_order(alphabet, lines)?;
        let locator = Locator::new(&line_sequence(alphabet, order)?, method);
        Ok(Self {
            locator,
            lines,
            order,
        })
    }

    /// The index of the window's first line.
    ///
    /// # Errors
    /// [`WindowError`] if no window of these lines has these symbols.
    pub fn locate(&self, window: &[Symbol]) -> Result<usize, WindowError> {
        let elements: Vec<Element> = window.iter().map(|&symbol| symbol.into()).collect();
        let start = self.locator.locate(&elements)?;
        let fits = start + self.order <= self.lines;
        fits.then_some(start).ok_or(WindowError::BeyondEnd {
            start,
            lines: self.lines,
        })
    }
}

/// The place of a window in the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct WindowOrigin {
    /// Index of the window's first row, from 0 at the top.
    pub row: usize,
    /// Index of the window's first column, from 0 at the left.
    pub column: usize,
}

/// Which of the two windows has no index, and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum GridWindowError {
    /// The rows' symbols.
    #[error("the window's rows: {0}")]
    Rows(WindowError),
    /// The columns' symbols.
    #[error("the window's columns: {0}")]
    Columns(WindowError),
}

/// Finds windows among the crossings of a grid.
#[derive(Debug, Clone)]
pub struct GridLocator {
    rows: LineLocator,
    columns: LineLocator,
}

impl GridLocator {
    /// A locator for a grid of this many rows and columns, by look-up.
    ///
    /// # Errors
    /// [`SequenceError::UnsupportedLines`] unless both are among 15, 31, 63, 127 and 255.
    pub fn new(alphabet: Alphabet, rows: usize, columns: usize) -> Result<Self, SequenceError> {
        Ok(Self {
            rows: LineLocator::new(alphabet, rows, Method::Table)?,
            columns: LineLocator::new(alphabet, columns, Method::Table)?,
        })
    }

    /// The origin of the window in which these symbols of rows (downwards) and of columns
    /// (rightwards) meet.
    ///
    /// # Errors
    /// [`GridWindowError`] if the grid has no such window.
    pub fn locate(
        &self,
        rows: &[Symbol],
        columns: &[Symbol],
    ) -> Result<WindowOrigin, GridWindowError> {
        Ok(WindowOrigin {
            row: self.rows.locate(rows).map_err(GridWindowError::Rows)?,
            column: self
                .columns
                .locate(columns)
                .map_err(GridWindowError::Columns)?,
        })
    }
}
