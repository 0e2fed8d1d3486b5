//! The shift table as CSV: one line per vertex that was read both without and with the object.
//!
//! Takes and gives [`ShiftRow`]s. The columns are those of the thesis's Appendix C with the shift beside the
//! depth: `vertex,row,column,x_px,y_px,shift_px,depth`. Columns are found by name, so their order does not
//! matter and further columns are left alone. The printed table of Appendix C itself has two objects in one
//! file and no shift (`object,vertex,row,column,x_px,y_px,depth,...`): [`read_appendix_c`] takes one of
//! them and gets the shift back from the depth. Source: the thesis, chapter 4.6 and Appendix C.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use csv::{Reader, StringRecord};
use shared::pattern::{Corner, GridIndex};
use thiserror::Error;

use crate::{
    pipeline::shift::{Shift, THESIS_DEPTH_PER_PX},
    scan::{ScanError, write_whole},
};

/// The header of the table that [`write_shift_table`] writes.
const COLUMNS: [&str; 7] = [
    "vertex", "row", "column", "x_px", "y_px", "shift_px", "depth",
];

/// Why a shift table can't be read or written.
#[derive(Debug, Error)]
pub enum ShiftTableError {
    /// A file that can't be read.
    #[error("{path}: {source}")]
    File {
        /// The table.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A file that can't be written.
    #[error(transparent)]
    Write(#[from] ScanError),
    /// Not CSV, not UTF-8, or a line with another number of fields than the header.
    #[error("{path}: {source}")]
    Csv {
        /// The table.
        path: PathBuf,
        /// What is wrong, with the line.
        source: csv::Error,
    },
    /// The header lacks a column.
    #[error("{path}, line 1: column {column:?} is missing; a shift table has {expected}")]
    MissingColumn {
        /// The table.
        path: PathBuf,
        /// The column.
        column: &'static str,
        /// All columns that are needed.
        expected: String,
    },
    /// A field that is not what its column asks for.
    #[error("{path}, line {line}, column {column:?}: {found:?} is not {expected}")]
    Field {
        /// The table.
        path: PathBuf,
        /// Line in the file, from 1.
        line: u64,
        /// Name of the column.
        column: &'static str,
        /// What stands there, at most 40 characters of it.
        found: String,
        /// What should stand there.
        expected: &'static str,
    },
    /// Appendix C has no such object.
    #[error("{path}: no vertex of object {object:?}; the table has {known}")]
    NoSuchObject {
        /// The table.
        path: PathBuf,
        /// The object asked for.
        object: String,
        /// The objects in the file.
        known: String,
    },
}

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
    Ok(write_whole(path, text.as_bytes())?)
}

/// Reads a table that [`write_shift_table`] or another program wrote.
///
/// # Errors
/// A file that is missing, not CSV, lacks a column, or has a field that is no vertex or no number.
pub fn read_shift_table(path: &Path) -> Result<Vec<ShiftRow>, ShiftTableError> {
    let bytes = fs::read(path).map_err(|source| ShiftTableError::File {
        path: path.to_owned(),
        source,
    })?;
    Table::new(path, &bytes, COLUMNS)?
        .lines()
        .map(|line| line?.shift_row(5, 6))
        .collect()
}

/// Reads one object, `cube` or `cylinder`, of the thesis's Appendix C in its CSV form.
///
/// The printed table has no shift; it is depth / [`THESIS_DEPTH_PER_PX`].
///
/// # Errors
/// As [`read_shift_table`], and [`ShiftTableError::NoSuchObject`].
pub fn read_appendix_c(path: &Path, object: &str) -> Result<Vec<ShiftRow>, ShiftTableError> {
    const APPENDIX: [&str; 7] = ["vertex", "row", "column", "x_px", "y_px", "depth", "object"];
    let bytes = fs::read(path).map_err(|source| ShiftTableError::File {
        path: path.to_owned(),
        source,
    })?;
    let (mut rows, mut known) = (Vec::new(), Vec::new());
    for line in Table::new(path, &bytes, APPENDIX)?.lines() {
        let line = line?;
        let name = line.text(6).to_owned();
        if name == object {
            let mut row = line.shift_row(5, 5)?;
            row.shift_px = row.depth / THESIS_DEPTH_PER_PX;
            rows.push(row);
        }
        if !known.contains(&name) && known.len() < 8 {
            known.push(name);
        }
    }
    if rows.is_empty() {
        return Err(ShiftTableError::NoSuchObject {
            path: path.to_owned(),
            object: object.to_owned(),
            known: if known.is_empty() {
                "no lines".to_owned()
            } else {
                known.join(", ")
            },
        });
    }
    Ok(rows)
}

/// A CSV file whose columns were found by name.
struct Table<'a> {
    path: &'a Path,
    reader: Reader<&'a [u8]>,
    names: [&'static str; 7],
    fields: [usize; 7],
}

impl<'a> Table<'a> {
    fn new(
        path: &'a Path,
        bytes: &'a [u8],
        names: [&'static str; 7],
    ) -> Result<Self, ShiftTableError> {
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(bytes);
        let headers = reader.headers().map_err(|source| ShiftTableError::Csv {
            path: path.to_owned(),
            source,
        })?;
        let mut fields = [0; 7];
        for (field, column) in fields.iter_mut().zip(names) {
            // a spreadsheet may put a byte order mark before the first name
            let found = headers
                .iter()
                .position(|h| h.trim_start_matches('\u{feff}') == column);
            *field = found.ok_or_else(|| ShiftTableError::MissingColumn {
                path: path.to_owned(),
                column,
                expected: names.join(", "),
            })?;
        }
        Ok(Self {
            path,
            reader,
            names,
            fields,
        })
    }

    fn lines(self) -> impl Iterator<Item = Result<Line<'a>, ShiftTableError>> {
        let Self {
            path,
            reader,
            names,
            fields,
        } = self;
        reader.into_records().map(move |record| match record {
            Ok(record) => Ok(Line {
                path,
                record,
                names,
                fields,
            }),
            Err(source) => Err(ShiftTableError::Csv {
                path: path.to_owned(),
                source,
            }),
        })
    }
}

/// One line of a [`Table`]; fields are asked for by their place in its list of names.
struct Line<'a> {
    path: &'a Path,
    record: StringRecord,
    names: [&'static str; 7],
    fields: [usize; 7],
}

impl Line<'_> {
    fn text(&self, column: usize) -> &str {
        self.record.get(self.fields[column]).unwrap_or("")
    }

    fn wrong(&self, column: usize, expected: &'static str) -> ShiftTableError {
        ShiftTableError::Field {
            path: self.path.to_owned(),
            line: self.record.position().map_or(0, csv::Position::line),
            column: self.names[column],
            found: self.text(column).chars().take(40).collect(),
            expected,
        }
    }

    fn number(&self, column: usize) -> Result<f64, ShiftTableError> {
        let value: Option<f64> = self.text(column).parse().ok();
        value
            .filter(|value| value.is_finite())
            .ok_or_else(|| self.wrong(column, "a number"))
    }

    fn line_number(&self, column: usize) -> Result<u16, ShiftTableError> {
        let value = self.text(column).parse();
        value.map_err(|_| self.wrong(column, "a whole number from 0 to 65535"))
    }

    fn shift_row(&self, shift: usize, depth: usize) -> Result<ShiftRow, ShiftTableError> {
        let corner = Corner::ALL.into_iter().find(|c| c.name() == self.text(0));
        Ok(ShiftRow {
            corner: corner.ok_or_else(|| {
                self.wrong(0, "UPPER_LEFT, UPPER_RIGHT, LOWER_RIGHT or LOWER_LEFT")
            })?,
            index: GridIndex {
                row: self.line_number(1)?,
                column: self.line_number(2)?,
            },
            x_px: self.number(3)?,
            y_px: self.number(4)?,
            shift_px: self.number(shift)?,
            depth: self.number(depth)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn appendix_c() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/recorded/appendix-c.csv")
    }

    fn table_with(text: &str) -> (tempfile::TempDir, PathBuf) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("shifts.csv");
        fs::write(&path, text).unwrap();
        (dir, path)
    }

    #[test]
    fn appendix_c_holds_400_vertices_of_the_cube_and_390_of_the_cylinder() {
        let cube = read_appendix_c(&appendix_c(), "cube").unwrap();
        let cylinder = read_appendix_c(&appendix_c(), "cylinder").unwrap();
        assert_eq!((cube.len(), cylinder.len()), (400, 390));
        let first = cube[0];
        assert_eq!(
            (first.corner, first.x_px, first.y_px),
            (Corner::UpperLeft, 51.0, 22.0)
        );
        assert_eq!(first.depth, 9.32);
    }

    #[test]
    fn a_depth_of_9_43_in_appendix_c_is_a_shift_of_11_rows_and_9_columns() {
        let rows = read_appendix_c(&appendix_c(), "cube").unwrap();
        let row = rows.iter().find(|row| row.depth == 9.43).unwrap();
        assert!((row.shift_px - 202_f64.sqrt()).abs() < 0.01, "{row:?}");
    }

    #[test]
    fn a_table_read_back_is_the_one_written() {
        let (_dir, path) = table_with("");
        let rows = read_appendix_c(&appendix_c(), "cylinder").unwrap();
        write_shift_table(&path, &rows).unwrap();
        let back = read_shift_table(&path).unwrap();
        assert_eq!(back.len(), rows.len());
        for (a, b) in rows.iter().zip(&back) {
            assert_eq!(
                (a.corner, a.index, a.x_px, a.depth),
                (b.corner, b.index, b.x_px, b.depth)
            );
            assert!((a.shift_px - b.shift_px).abs() <= 0.5e-4);
        }
    }

    #[test]
    fn an_error_names_file_line_and_column() {
        let (_dir, path) = table_with(
            "vertex,row,column,x_px,y_px,shift_px,depth\nUPPER_LEFT,0,0,1,2,3,4\nUPPER_LEFT,0,1,1,far,3,4\n",
        );
        let message = read_shift_table(&path).unwrap_err().to_string();
        for part in ["shifts.csv", "line 3", "\"y_px\"", "\"far\""] {
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn a_missing_column_an_unknown_vertex_and_a_number_without_end_are_refused() {
        let (_dir, path) = table_with("vertex,row,column,x_px,y_px,depth\n");
        assert!(matches!(
            read_shift_table(&path),
            Err(ShiftTableError::MissingColumn {
                column: "shift_px",
                ..
            })
        ));
        for line in [
            "MIDDLE,0,0,1,2,3,4",
            "UPPER_LEFT,0,0,1,2,inf,4",
            "UPPER_LEFT,-1,0,1,2,3,4",
        ] {
            let (_dir, path) = table_with(&format!(
                "vertex,row,column,x_px,y_px,shift_px,depth\n{line}\n"
            ));
            assert!(matches!(
                read_shift_table(&path),
                Err(ShiftTableError::Field { line: 2, .. })
            ));
        }
    }

    #[test]
    fn an_object_that_is_not_in_the_table_is_refused_with_those_that_are() {
        let error = read_appendix_c(&appendix_c(), "cone").unwrap_err();
        assert!(error.to_string().contains("cube, cylinder"), "{error}");
    }

    proptest! {
        #[test]
        fn no_bytes_make_the_reader_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("broken.csv");
            fs::write(&path, [b"vertex,row,column,x_px,y_px,shift_px,depth,object\n", &bytes[..]].concat()).unwrap();
            let _read = read_shift_table(&path);
            let _read = read_appendix_c(&path, "cube");
        }
    }
}
