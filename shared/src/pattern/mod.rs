//! What the projector can show, defined once for the side that draws and the side that reads.
//!
//! # Conventions
//! - A raster is W x H projector pixels, origin at the upper left, x to the right, y down.
//! - Positions are edge coordinates: pixel k covers [k, k + 1), its centre lies at k + 1/2.
//! - Row i is the horizontal line centred at y = (i + 1/2) H/R, column j the vertical line centred at
//!   x = (j + 1/2) W/C. A line of width w covers w whole pixels from round(centre - w/2), halves up.
//! - Where a row and a column cross, the column is drawn on top. The field between lines is black.
//! - Line k has colour number b\[k\] of the pseudo-random sequence (see [`crate::sequence`]).
//!
//! ```
//! use shared::pattern::{Axis, Grid, GridIndex, Corner, Pattern, RasterSize, Rgb};
//! let colours = ["#ff0000", "#ffff00", "#ff00ff", "#00ff00"].map(|c| c.parse::<Rgb>().unwrap());
//! let grid = Grid::coded(15, 15, 6, 6, &colours)?;
//! let size = RasterSize { width: 1024, height: 768 };
//! assert_eq!(grid.line(Axis::Column, 0, size).start_px, 31); // round(34.13 - 3)
//! let corner = grid.vertex(GridIndex { row: 0, column: 0 }, Corner::LowerRight, size);
//! assert_eq!((corner.x, corner.y), (37.0, 29.0));
//! let picture = Pattern::Grid(grid).raster(size);
//! assert_eq!(picture.pixel(31, 100), colours[0]);
//! # Ok::<(), shared::pattern::PatternError>(())
//! ```

mod colour;
mod density;
mod grid;
mod identify;
mod pairing_card;
mod palette;
mod place;
mod raster;
mod settings;
mod test_card;
mod text;

pub use colour::Rgb;
pub use density::{CameraScale, LEAST_PITCH_PX, LEAST_WIDTH_PX, LINE_COUNTS};
pub use grid::{Axis, Grid, MAX_COLOURS, MAX_LINES, MAX_WIDTH_PX, PatternError};
pub use palette::{NamedColour, PALETTE_SIZE, Palette, PaletteError};
pub use place::{Corner, GridIndex, LineSpan};
pub use raster::{Pattern, Raster, RasterSize};
pub use settings::GridSettings;
