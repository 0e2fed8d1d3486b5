//! Why a scan folder can't be read or written.

use std::{io, path::PathBuf};

use shared::{geometry::CalibrationError, pattern::RasterSize};
use thiserror::Error;

use super::manifest::FORMAT;

/// Why a scan folder can't be read or written.
#[derive(Debug, Error)]
pub enum ScanError {
    /// A file that can't be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A manifest or a choice of colours that is not what the format asks for.
    #[error("{path}: {source}")]
    Json {
        /// The file.
        path: PathBuf,
        /// What is wrong, with line and column.
        source: serde_json::Error,
    },
    /// A calibration with a number that makes no sense.
    #[error("{path}: {source}")]
    Calibration {
        /// The file that it was meant for.
        path: PathBuf,
        /// What is wrong with it.
        source: CalibrationError,
    },
    /// Written by a newer program.
    #[error("{path}: format {found}, but this program reads format {FORMAT}; use a newer acquirer")]
    Format {
        /// The manifest.
        path: PathBuf,
        /// The format it says.
        found: u32,
    },
    /// A picture that can't be decoded or encoded.
    #[error("{path}: {source}")]
    Picture {
        /// The picture.
        path: PathBuf,
        /// What is wrong with it.
        source: image::ImageError,
    },
    /// A picture that is not of the camera's size.
    #[error("{path}: {found} px, but scan.json says that the camera gives {expected} px")]
    Size {
        /// The picture.
        path: PathBuf,
        /// Its size.
        found: RasterSize,
        /// The size in the manifest.
        expected: RasterSize,
    },
    /// A manifest entry that points outside of the folder.
    #[error("{path}: capture file {file:?} must be a relative path inside the scan folder")]
    Outside {
        /// The manifest.
        path: PathBuf,
        /// The path it gives.
        file: String,
    },
    /// A folder that already holds a scan.
    #[error("{0} already holds a scan; go on with it by --resume, or choose another folder")]
    Exists(PathBuf),
    /// A list of checksums that has a line which is none.
    #[error("{path}, line {line}: not 64 hexadecimal digits, two spaces and a file name")]
    Sums {
        /// The list.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
    },
}
