//! Why results can't be written.

use std::{
    io,
    path::{Path, PathBuf},
};

use image::ImageError;
use thiserror::Error;

use super::shift_table::ShiftTableError;
use crate::scan::ScanError;

/// Why results can't be written.
#[derive(Debug, Error)]
pub enum OutputError {
    /// A folder that can't be made or read.
    #[error("{path}: the results can't be put there: {source}; free the place or make it writable")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A file that can't be written.
    #[error(transparent)]
    File(#[from] ScanError),
    /// The shift table can't be written.
    #[error(transparent)]
    Shifts(#[from] ShiftTableError),
    /// A result of an earlier run that can't be removed.
    #[error("{path}: an outdated result can't be removed: {source}; remove it by hand")]
    Outdated {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A picture that can't be encoded.
    #[error("{path}: {source}")]
    Picture {
        /// The file it was meant for.
        path: PathBuf,
        /// What is wrong with it.
        source: ImageError,
    },
}

impl OutputError {
    /// A picture that can't be encoded.
    pub(super) fn picture(path: &Path, source: ImageError) -> Self {
        Self::Picture {
            path: path.to_owned(),
            source,
        }
    }
}
