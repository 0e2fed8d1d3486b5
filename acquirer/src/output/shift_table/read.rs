//! Reads shift tables: ours, and the thesis's Appendix C.

use std::{fs, path::Path};

use csv::{Reader, StringRecord};
use shared::pattern::{Corner, GridIndex};

use super::{COLUMNS, ShiftRow, ShiftTableError};
use crate::pipeline::shift::THESIS_DEPTH_PER_PX;

/// Reads a table that [`write_shift_table`](super::write_shift_table) or another program wrote.
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
