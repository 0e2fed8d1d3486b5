//! Pseudo-random multi-valued sequences: the code that the lines of the grid carry.
//!
//! Source: chapter 3 of the thesis; F. J. MacWilliams and N. J. A. Sloane, "Pseudo-random
//! sequences and arrays", Proc. IEEE 64 (1976).

mod lines;

pub use lines::{Alphabet, Symbol, line_symbols, window_order};

/// Why a sequence cannot be made.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SequenceError {
    /// The grid offers only five numbers of lines.
    #[error("a grid cannot have {lines} lines; choose 15, 31, 63, 127 or 255")]
    UnsupportedLines {
        /// The number that was asked for.
        lines: usize,
    },
}
