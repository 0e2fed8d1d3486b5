//! Where a window lies in its sequence.
//!
//! Takes m neighbouring symbols, gives the index of the first of them. The register is shifted back
//! from the window, step by step, until it shows a window whose index is known, a milestone; the
//! index sought is the milestone's plus the number of steps. The three methods of the thesis differ
//! only in how many milestones there are: the serial one knows the first window alone, the table
//! knows every window, and the serial/parallel one knows every s-th.
//!
//! Source: section 3.1.3 of the thesis; E. M. Petriu, "Absolute-type position transducers using a
//! pseudorandom encoding" (1987).
//!
//! A window with a wrong symbol is, nearly always, another window of the sequence: it is located
//! elsewhere without notice. Only the all-zero window is in no sequence.
//!
//! ```
//! use shared::field::appendix_a;
//! use shared::sequence::{Locator, Method, Sequence};
//!
//! let gf4 = appendix_a::field(4)?;
//! let sequence = Sequence::new(&gf4, &appendix_a::primitive_polynomial(&gf4, 2)?)?;
//! let [w, one] = [2, 1].map(|index| gf4.element(index).unwrap());
//!
//! // 0 1 1 w2 1 0 w [w 1] w 0 w2 w2 w w2
//! let serial = Locator::new(&sequence, Method::Serial);
//! assert_eq!(serial.locate(&[w, one])?, 7);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::{FeedbackRegister, Recurrence, Sequence};
use crate::field::Element;
use std::collections::HashMap;
use std::num::NonZeroUsize;

/// How the index of a window is found: time against memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// Steps back to the start of the sequence: no table, up to a whole period of steps.
    Serial,
    /// Looks the window up: a table of the whole period, no step.
    Table,
    /// Steps back to the nearest of a few known windows.
    Milestones {
        /// Number of symbols between milestones: one more than the greatest number of steps.
        spacing: NonZeroUsize,
    },
}

/// Why a window has no index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WindowError {
    /// The window has too few or too many symbols.
    #[error("the window has {found} symbols; this sequence needs {expected}")]
    WrongLength {
        /// Symbols in a window of this sequence.
        expected: usize,
        /// Symbols in the window that was given.
        found: usize,
    },
    /// A symbol is not in the alphabet.
    #[error("symbol {symbol} at place {place} of the window is not in the alphabet")]
    UnknownSymbol {
        /// The symbol's index.
        symbol: usize,
        /// Where it stands in the window, from 0.
        place: usize,
    },
    /// All symbols are 0: the one window that no sequence contains.
    #[error("a window of zeros occurs nowhere")]
    AllZero,
    /// The sequence contains the window, but the grid ends before it does.
    #[error("the window starts at line {start}, too near the end of {lines} lines")]
    BeyondEnd {
        /// Index of the window's first line.
        start: usize,
        /// Number of lines of the grid.
        lines: usize,
    },
}

/// Finds the index of windows of one sequence.
#[derive(Debug, Clone)]
pub struct Locator {
    recurrence: Recurrence,
    milestones: HashMap<Vec<Element>, usize>,
    spacing: usize,
}

impl Locator {
    /// Prepares the milestones for a sequence.
    #[must_use]
    pub fn new(sequence: &Sequence, method: Method) -> Self {
        let period = sequence.symbols().len();
        let spacing = match method {
            Method::Serial => period,
            Method::Table => 1,
            Method::Milestones { spacing } => spacing.get().min(period),
        };
        let indices = (0..period).step_by(spacing);
        let milestones = indices
            .map(|index| (sequence.window(index), index))
            .collect();
        Self {
            recurrence: sequence.recurrence().clone(),
            milestones,
            spacing,
        }
    }

    /// The index of the window's first symbol, from 0 to the period - 1; the sequence is a circle.
    ///
    /// # Errors
    /// Any [`WindowError`] but `BeyondEnd`.
    pub fn locate(&self, window: &[Element]) -> Result<usize, WindowError> {
        let expected = self.recurrence.order();
        if window.len() != expected {
            return Err(WindowError::WrongLength {
                expected,
                found: window.len(),
            });
        }
        let field = self.recurrence.field();
        if let Some(place) = window.iter().position(|&symbol| !field.contains(symbol)) {
            return Err(WindowError::UnknownSymbol {
                symbol: window[place].index(),
                place,
            });
        }
        self.step_back_to_milestone(window)
            .ok_or(WindowError::AllZero)
    }

    /// None for the window of zeros alone: back-shifting leads every other one through the period.
    fn step_back_to_milestone(&self, window: &[Element]) -> Option<usize> {
        let mut register = FeedbackRegister::at(&self.recurrence, window).ok()?;
        for steps in 0..self.spacing {
            if let Some(milestone) = self.milestones.get(register.state()) {
                return Some(milestone + steps);
            }
            register.step_back();
        }
        None
    }
}
