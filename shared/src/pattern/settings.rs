//! The operator's choice: one coded grid and the unary colour that goes with it.

use serde::{Deserialize, Serialize};

use super::{Axis, Grid, PatternError, Rgb};

/// The `pattern` object of a scan: a coded grid and the colour of its unary twin.
///
/// In JSON and TOML: the keys of [`Grid`] and `unary`. Unknown keys are ignored.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct GridSettings {
    /// The coded grid.
    #[serde(flatten)]
    pub coded: Grid,
    /// Colour of the single-colour grid that gives the geometry.
    pub unary: Rgb,
}

impl GridSettings {
    /// The single-colour grid with the same lines.
    #[must_use]
    pub fn unary_grid(&self) -> Grid {
        self.coded.unary(self.unary)
    }

    /// The grid of as many lines in the first two colours of the coded grid, coded by the two-colour (PRBCS)
    /// sequence. A grid that has no such twin (fewer than two colours, or a number of lines that no sequence has)
    /// stands for itself.
    #[must_use]
    pub fn two_colour_grid(&self) -> Grid {
        let coded = &self.coded;
        let colours: Vec<Rgb> = coded.colours().iter().copied().take(2).collect();
        if colours.len() < 2 {
            return coded.clone();
        }
        let (row_px, column_px) = (coded.width_px(Axis::Row), coded.width_px(Axis::Column));
        Grid::coded(coded.rows(), coded.columns(), row_px, column_px, &colours)
            .unwrap_or_else(|_| coded.clone())
    }

    /// The same lines in other colours.
    ///
    /// # Errors
    /// Another number of colours than the grid has.
    pub fn with_colours(&self, colours: &[Rgb], unary: Rgb) -> Result<Self, PatternError> {
        Ok(Self {
            coded: self.coded.recoloured(colours)?,
            unary,
        })
    }

    /// The same colours on another number of lines, coded by the pseudo-random sequence.
    ///
    /// # Errors
    /// A line count other than 15, 31, 63, 127 or 255, or a number of colours no sequence exists for.
    pub fn with_lines(&self, rows: usize, columns: usize) -> Result<Self, PatternError> {
        let (row_px, column_px) = (
            self.coded.width_px(Axis::Row),
            self.coded.width_px(Axis::Column),
        );
        let coded = Grid::coded(rows, columns, row_px, column_px, self.coded.colours())?;
        Ok(Self {
            coded,
            unary: self.unary,
        })
    }

    /// The same grid with other line widths in projector pixels.
    ///
    /// # Errors
    /// A width outside 1 to [`super::MAX_WIDTH_PX`].
    pub fn with_widths(&self, row_px: u32, column_px: u32) -> Result<Self, PatternError> {
        Ok(Self {
            coded: self.coded.with_widths(row_px, column_px)?,
            unary: self.unary,
        })
    }
}

impl Default for GridSettings {
    /// The thesis's test case II: 15 x 15 lines of 6 px in red, yellow, magenta and green; unary white.
    fn default() -> Self {
        let colours = [[255, 0, 0], [255, 255, 0], [255, 0, 255], [0, 255, 0]].map(Rgb);
        match Grid::coded(15, 15, 6, 6, &colours) {
            Ok(coded) => Self {
                coded,
                unary: Rgb::WHITE,
            },
            Err(error) => unreachable!("the built-in grid is valid: {error}"),
        }
    }
}
