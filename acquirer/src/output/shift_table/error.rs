//! Why a shift table can't be read or written.

use std::{io, path::PathBuf};

use thiserror::Error;

use crate::scan::ScanError;

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
