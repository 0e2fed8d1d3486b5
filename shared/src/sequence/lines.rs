//! The symbols of the grid's lines.
//!
//! Takes the alphabet and the number of lines, gives one symbol for each line, in line order. The
//! symbols are the first terms of the m-sequence that starts in the state 0..0 1, so every window
//! of `window_order` adjacent lines occurs only once.

use super::{Sequence, SequenceError};
use crate::field::{Element, appendix_a};
use serde::{Deserialize, Serialize};
use std::fmt;

/// How many colours the lines of a grid may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Alphabet {
    /// Two colours: sequences over GF(2), "PRBCS" in the literature.
    Two,
    /// Four colours: sequences over GF(4), "PRMVS" in the thesis.
    Four,
}

/// One line's symbol: 0, 1, 2, 3 stand for the field elements 0, 1, w, w^2 and for the first to
/// the fourth colour of the palette.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Symbol(pub u8);

impl From<Symbol> for Element {
    fn from(symbol: Symbol) -> Self {
        Self::from_index(u16::from(symbol.0))
    }
}

impl fmt::Display for Symbol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            2 => f.write_str("w"),
            3 => f.write_str("w2"),
            other => write!(f, "{other}"),
        }
    }
}

/// The smallest number of adjacent lines whose symbols say which lines they are.
///
/// # Errors
/// [`SequenceError::UnsupportedLines`] unless `lines` is 15, 31, 63, 127 or 255.
pub fn window_order(alphabet: Alphabet, lines: usize) -> Result<usize, SequenceError> {
    let (two, four) = match lines {
        15 => (4, 2),
        31 => (5, 3),
        63 => (6, 3),
        127 => (7, 4),
        255 => (8, 4),
        _ => return Err(SequenceError::UnsupportedLines { lines }),
    };
    Ok(match alphabet {
        Alphabet::Two => two,
        Alphabet::Four => four,
    })
}

/// The symbols of `lines` lines, in line order.
///
/// # Errors
/// [`SequenceError::UnsupportedLines`] unless `lines` is 15, 31, 63, 127 or 255.
pub fn line_symbols(alphabet: Alphabet, lines: usize) -> Result<Vec<Symbol>, SequenceError> {
    let sequence = line_sequence(alphabet, window_order(alphabet, lines)?)?;
    // At most four elements, so an index fits in a byte.
    let symbols = sequence
        .symbols()
        .iter()
        .map(|element| Symbol(element.index() as u8));
    Ok(symbols.take(lines).collect())
}

/// The whole sequence whose first terms are the symbols of the lines.
pub(super) fn line_sequence(alphabet: Alphabet, order: usize) -> Result<Sequence, SequenceError> {
    let field = appendix_a::field(match alphabet {
        Alphabet::Two => 2,
        Alphabet::Four => 4,
    })?;
    Sequence::new(&field, &appendix_a::primitive_polynomial(&field, order)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fifteen_lines_carry_the_sequence_of_the_thesis() {
        let symbols = line_symbols(Alphabet::Four, 15).unwrap();
        let text: Vec<String> = symbols.iter().map(ToString::to_string).collect();
        assert_eq!(text.join(" "), "0 1 1 w2 1 0 w w 1 w 0 w2 w2 w w2");
    }

    #[test]
    fn every_window_of_every_grid_occurs_once() {
        for alphabet in [Alphabet::Two, Alphabet::Four] {
            for lines in [15, 31, 63, 127, 255] {
                let symbols = line_symbols(alphabet, lines).unwrap();
                let order = window_order(alphabet, lines).unwrap();
                let windows: std::collections::HashSet<_> = symbols.windows(order).collect();
                assert_eq!(symbols.len(), lines);
                assert_eq!(windows.len(), lines - order + 1, "{alphabet:?} {lines}");
            }
        }
    }

    #[test]
    fn another_number_of_lines_is_refused() {
        assert_eq!(
            line_symbols(Alphabet::Four, 16),
            Err(SequenceError::UnsupportedLines { lines: 16 })
        );
    }
}
