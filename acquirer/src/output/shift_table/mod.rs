//! The shift table as CSV: one line per vertex that was read both without and with the object.
//!
//! Takes and gives [`ShiftRow`]s. The columns are those of the thesis's Appendix C with the shift beside the
//! depth: `vertex,row,column,x_px,y_px,shift_px,depth`. Columns are found by name, so their order does not
//! matter and further columns are left alone. The printed table of Appendix C itself has two objects in one
//! file and no shift (`object,vertex,row,column,x_px,y_px,depth,...`): [`read_appendix_c`] takes one of
//! them and gets the shift back from the depth. Source: the thesis, chapter 4.6 and Appendix C.

mod error;
mod read;

use std::path::Path;

use shared::pattern::{Corner, GridIndex};

pub use error::ShiftTableError;
pub use read::{read_appendix_c, read_shift_table};

use crate::{pipeline::shift::Shift, scan::write_whole};

/// The header of the table that [`write_shift_table`] writes.
const COLUMNS: [&str; 7] = [
    "vertex", "row", "column", "x_px", "y_px", "shift_px", "depth",
];

/// One line of the shift table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShiftRow {
    /// Which vertex of the crossing.
    pub corner: Corner,
    /// Row and column of the crossing.
    pub index: GridIndex,
    /// Where the vertex stands with the object: to the right, in camera pixels.
    pub x_px: f64,
    /// Where the vertex stands with the object: downwards, in camera pixels.
    pub y_px: f64,
    /// How far it moved between the two stages, in camera pixels.
    pub shift_px: f64,
    /// Relative depth: the shift times the rig's factor, without unit.
    pub depth: f64,
}

impl From<&Shift> for ShiftRow {
    fn from(shift: &Shift) -> Self {
        Self {
            corner: shift.corner,
            index: shift.index,
            x_px: shift.after.x,
            y_px: shift.after.y,
            shift_px: shift.shift_px,
            depth: shift.depth,
        }
    }
}

/// Writes the table, positions to 1/1000 px, shift and depth to 1/10 000; whole or not at all.
///
/// # Errors
/// [`ShiftTableError::Write`] with what the system says.
pub fn write_shift_table(path: &Path, rows: &[ShiftRow]) -> Result<(), ShiftTableError> {
    let mut text = COLUMNS.join(",") + "\n";
    for row in rows {
        text += &format!(
            "{},{},{},{:.3},{:.3},{:.4},{:.4}\n",
            row.corner,
            row.index.row,
            row.index.column,
            row.x_px,
            row.y_px,
            row.shift_px,
            row.depth
        );
    }
    write_whole(path, text.as_bytes())?;
    Ok(())
}

#[cfg(test)]
mod tests;
