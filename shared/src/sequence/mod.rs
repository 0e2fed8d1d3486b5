//! Pseudo-random multi-valued sequences: the code that the lines of the grid carry.
//!
//! A shift register of m cells over GF(q), fed back through a primitive polynomial of degree m,
//! runs through all q^m - 1 states other than 0..0 before it repeats ([`generate`]). So a window of
//! any m neighbouring symbols of its output occurs only once, and tells where it lies ([`locate`]).
//! A grid is a sequence of rows and a sequence of columns, located one after the other
//! ([`locate_grid`]). What the pattern needs of all this is one function, [`line_symbols`].
//!
//! Source: chapter 3 of the thesis; F. J. MacWilliams and N. J. A. Sloane, "Pseudo-random
//! sequences and arrays", Proc. IEEE 64 (1976).
//!
//! ```
//! use shared::sequence::{Alphabet, GridLocator, Symbol, line_symbols};
//!
//! let symbols = line_symbols(Alphabet::Four, 15)?;
//! let text: Vec<String> = symbols.iter().map(Symbol::to_string).collect();
//! assert_eq!(text.join(" "), "0 1 1 w2 1 0 w w 1 w 0 w2 w2 w w2");
//!
//! // A camera that sees rows of colours 1, w2 and columns of colours w, 1 looks at:
//! let grid = GridLocator::new(Alphabet::Four, 15, 15)?;
//! let origin = grid.locate(&[Symbol(1), Symbol(3)], &[Symbol(2), Symbol(1)])?;
//! assert_eq!((origin.row, origin.column), (2, 7));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod lines;

mod recurrence;

pub mod generate;

pub mod locate;

pub mod locate_grid;

pub use generate::{FeedbackRegister, ModifiedRegister, Sequence};
pub use lines::{Alphabet, Symbol, line_symbols, window_order};
pub use locate::{Locator, Method, WindowError};
pub use locate_grid::{GridLocator, GridWindowError, LineLocator, WindowOrigin};
pub use recurrence::Recurrence;

use crate::field::FieldError;

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
    /// Only a primitive polynomial gives a sequence of full period.
    #[error("{polynomial} is not monic and primitive, so its windows would repeat")]
    NotPrimitive {
        /// The polynomial, as text.
        polynomial: String,
    },
    /// The sequence does not fit into the memory set aside for one.
    #[error("the sequence has {period} symbols; at most {limit} are supported")]
    TooLong {
        /// Number of symbols.
        period: u64,
        /// Greatest number of symbols.
        limit: u64,
    },
    /// A register's state is not one symbol of the field for each cell.
    #[error("the register needs {cells} symbols of its field as its state")]
    BadState {
        /// Number of cells.
        cells: usize,
    },
    /// The field or the polynomial cannot be made.
    #[error(transparent)]
    Field(#[from] FieldError),
}
