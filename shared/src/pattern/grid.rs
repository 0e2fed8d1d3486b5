//! The grid of coded lines: how many, how wide, in which colours, in which order.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::Rgb;
use crate::sequence::{Alphabet, Symbol, line_symbols};

/// Most lines a grid may have in one direction.
pub const MAX_LINES: usize = 1023;
/// Widest line, in projector pixels.
pub const MAX_WIDTH_PX: u32 = 1024;
/// Most colours a grid may use.
pub const MAX_COLOURS: usize = 16;

/// Why a grid, colour or palette is not accepted.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PatternError {
    /// A colour that is not `#rrggbb`.
    #[error("{0:?} is not a colour: write #rrggbb, for example #ff8000")]
    Colour(String),
    /// A number of lines no sequence exists for.
    #[error("{0} lines: choose 15, 31, 63, 127 or 255, or give the symbols of every line")]
    LineCount(usize),
    /// More lines than [`MAX_LINES`], or none.
    #[error("{0} lines given by symbols: choose 1 to {MAX_LINES}")]
    ExplicitLineCount(usize),
    /// The number of lines and the number of symbols disagree.
    #[error("{lines} {axis} but {symbols} symbols for them")]
    SymbolCount {
        /// Which lines.
        axis: &'static str,
        /// Lines asked for.
        lines: usize,
        /// Symbols given.
        symbols: usize,
    },
    /// A symbol without a colour.
    #[error("symbol {symbol} but only {colours} colours")]
    SymbolWithoutColour {
        /// The symbol, from 0.
        symbol: u8,
        /// Number of colours given.
        colours: usize,
    },
    /// A number of colours that no code of ours has.
    #[error(
        "{0} colours: give 1 (unary), 2 (two-colour) or 4 (PRMVS), or give the symbols of every line (up to {MAX_COLOURS} colours)"
    )]
    ColourCount(usize),
    /// A line width outside 1 to [`MAX_WIDTH_PX`].
    #[error("line width {0} px: choose 1 to {MAX_WIDTH_PX}")]
    Width(u32),
}

/// Direction of a family of lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// Horizontal lines, counted downwards; they tell y.
    Row,
    /// Vertical lines, counted to the right; they tell x.
    Column,
}

impl Axis {
    /// Both directions, rows first.
    pub const BOTH: [Self; 2] = [Self::Row, Self::Column];

    /// The other direction.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Row => Self::Column,
            Self::Column => Self::Row,
        }
    }
}

/// The lines of one direction.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Family {
    symbols: Vec<Symbol>,
    width_px: u32,
    /// The symbols were given line by line and are not those of the pseudo-random sequence.
    explicit: bool,
}

/// A checked grid of coloured lines.
///
/// In JSON and TOML: `rows`, `columns`, `row_width_px`, `column_width_px`, `colours` (one for a unary
/// grid, two for PRBCS, four for PRMVS) and, for other people's codes, `row_symbols` and
/// `column_symbols` (one number from 0 per line, with up to 16 colours; `rows` and `columns` may then
/// be left out). Unknown keys are ignored.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "GridForm", into = "GridForm")]
pub struct Grid {
    rows: Family,
    columns: Family,
    colours: Vec<Rgb>,
}

impl Grid {
    /// The grid coded by the pseudo-random sequence: with one colour all lines are alike (unary), with
    /// two it is a PRBCS grid, with four a PRMVS grid.
    ///
    /// # Errors
    /// A line count other than 15, 31, 63, 127 or 255, a width outside 1 to [`MAX_WIDTH_PX`], or
    /// another number of colours.
    pub fn coded(
        rows: usize,
        columns: usize,
        row_width_px: u32,
        column_width_px: u32,
        colours: &[Rgb],
    ) -> Result<Self, PatternError> {
        let form = GridForm {
            rows: Some(rows),
            columns: Some(columns),
            row_width_px,
            column_width_px,
            colours: colours.to_vec(),
            row_symbols: None,
            column_symbols: None,
        };
        form.try_into()
    }

    /// A grid of these lines, the number of each one's colour given: rows, columns, and the widths of both in projector
    /// pixels, rows first.
    ///
    /// # Errors
    /// No line or more than [`MAX_LINES`] in a direction, a width outside 1 to [`MAX_WIDTH_PX`], a symbol without a
    /// colour, or none or more than [`MAX_COLOURS`] colours.
    pub fn explicit(
        rows: Vec<Symbol>,
        columns: Vec<Symbol>,
        (row_width_px, column_width_px): (u32, u32),
        colours: &[Rgb],
    ) -> Result<Self, PatternError> {
        let form = GridForm {
            rows: None,
            columns: None,
            row_width_px,
            column_width_px,
            colours: colours.to_vec(),
            row_symbols: Some(rows),
            column_symbols: Some(columns),
        };
        form.try_into()
    }

    /// Number of lines in one direction.
    #[must_use]
    pub fn lines(&self, axis: Axis) -> usize {
        self.family(axis).symbols.len()
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.lines(Axis::Row)
    }

    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.lines(Axis::Column)
    }

    /// Width of the lines in one direction, in projector pixels.
    #[must_use]
    pub fn width_px(&self, axis: Axis) -> u32 {
        self.family(axis).width_px
    }

    /// The colours; symbol k is drawn in colour k.
    #[must_use]
    pub fn colours(&self) -> &[Rgb] {
        &self.colours
    }

    /// The symbols of the lines in one direction, in line order.
    #[must_use]
    pub fn symbols(&self, axis: Axis) -> &[Symbol] {
        &self.family(axis).symbols
    }

    /// The colour of line `k`, or `None` beyond the last line.
    #[must_use]
    pub fn line_colour(&self, axis: Axis, k: usize) -> Option<Rgb> {
        let symbol = self.family(axis).symbols.get(k)?;
        self.colours.get(usize::from(symbol.0)).copied()
    }

    /// Whether all lines have the same colour, so that nothing can be decoded.
    #[must_use]
    pub fn is_unary(&self) -> bool {
        self.colours.len() == 1
    }

    /// The same lines, all in one colour.
    #[must_use]
    pub fn unary(&self, colour: Rgb) -> Self {
        let blank = |family: &Family| Family {
            symbols: vec![Symbol(0); family.symbols.len()],
            ..family.clone()
        };
        Self {
            rows: blank(&self.rows),
            columns: blank(&self.columns),
            colours: vec![colour],
        }
    }

    /// The same lines and symbols in other colours.
    ///
    /// # Errors
    /// Another number of colours than this grid has.
    pub fn recoloured(&self, colours: &[Rgb]) -> Result<Self, PatternError> {
        if colours.len() != self.colours.len() {
            return Err(PatternError::ColourCount(colours.len()));
        }
        Ok(Self {
            colours: colours.to_vec(),
            ..self.clone()
        })
    }

    /// The same grid with other line widths in projector pixels.
    ///
    /// # Errors
    /// A width outside 1 to [`MAX_WIDTH_PX`].
    pub fn with_widths(&self, row_px: u32, column_px: u32) -> Result<Self, PatternError> {
        let mut grid = self.clone();
        grid.rows.width_px = checked_width(row_px)?;
        grid.columns.width_px = checked_width(column_px)?;
        Ok(grid)
    }

    fn family(&self, axis: Axis) -> &Family {
        match axis {
            Axis::Row => &self.rows,
            Axis::Column => &self.columns,
        }
    }
}

/// The grid as written in files and messages, before it is checked.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct GridForm {
    #[serde(default)]
    rows: Option<usize>,
    #[serde(default)]
    columns: Option<usize>,
    row_width_px: u32,
    column_width_px: u32,
    colours: Vec<Rgb>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    row_symbols: Option<Vec<Symbol>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    column_symbols: Option<Vec<Symbol>>,
}

impl TryFrom<GridForm> for Grid {
    type Error = PatternError;

    fn try_from(form: GridForm) -> Result<Self, PatternError> {
        let count = form.colours.len();
        if count == 0 || count > MAX_COLOURS {
            return Err(PatternError::ColourCount(count));
        }
        let rows = family(
            "rows",
            form.rows,
            form.row_symbols,
            form.row_width_px,
            count,
        )?;
        let columns = family(
            "columns",
            form.columns,
            form.column_symbols,
            form.column_width_px,
            count,
        )?;
        Ok(Self {
            rows,
            columns,
            colours: form.colours,
        })
    }
}

impl From<Grid> for GridForm {
    fn from(grid: Grid) -> Self {
        let symbols = |family: &Family| family.explicit.then(|| family.symbols.clone());
        Self {
            rows: Some(grid.rows.symbols.len()),
            columns: Some(grid.columns.symbols.len()),
            row_width_px: grid.rows.width_px,
            column_width_px: grid.columns.width_px,
            row_symbols: symbols(&grid.rows),
            column_symbols: symbols(&grid.columns),
            colours: grid.colours,
        }
    }
}

fn checked_width(width_px: u32) -> Result<u32, PatternError> {
    if (1..=MAX_WIDTH_PX).contains(&width_px) {
        Ok(width_px)
    } else {
        Err(PatternError::Width(width_px))
    }
}

fn family(
    axis: &'static str,
    lines: Option<usize>,
    symbols: Option<Vec<Symbol>>,
    width_px: u32,
    colours: usize,
) -> Result<Family, PatternError> {
    let width_px = checked_width(width_px)?;
    let Some(symbols) = symbols else {
        let lines = lines.unwrap_or(0);
        return Ok(Family {
            symbols: coded_symbols(lines, colours)?,
            width_px,
            explicit: false,
        });
    };
    if symbols.is_empty() || symbols.len() > MAX_LINES {
        return Err(PatternError::ExplicitLineCount(symbols.len()));
    }
    if let Some(lines) = lines.filter(|&lines| lines != symbols.len()) {
        return Err(PatternError::SymbolCount {
            axis,
            lines,
            symbols: symbols.len(),
        });
    }
    if let Some(symbol) = symbols.iter().find(|s| usize::from(s.0) >= colours) {
        return Err(PatternError::SymbolWithoutColour {
            symbol: symbol.0,
            colours,
        });
    }
    Ok(Family {
        symbols,
        width_px,
        explicit: true,
    })
}

fn coded_symbols(lines: usize, colours: usize) -> Result<Vec<Symbol>, PatternError> {
    let alphabet = match colours {
        1 | 4 => Alphabet::Four,
        2 => Alphabet::Two,
        other => return Err(PatternError::ColourCount(other)),
    };
    let symbols = line_symbols(alphabet, lines).map_err(|_| PatternError::LineCount(lines))?;
    if colours == 1 {
        return Ok(vec![Symbol(0); symbols.len()]);
    }
    Ok(symbols)
}
