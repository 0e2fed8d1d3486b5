//! The scan folder: captures on disk, what was projected, and where the results go.

mod check;
mod checksum;
mod copy;
mod error;
mod finer;
mod folder;
mod fresh_folder;
mod manifest;
mod picture;
mod response;
mod shows;
mod whole_file;

pub use check::{CheckedScan, DamagedFile, UnrecordedFiner, check_scan};
pub(crate) use check::{sums_path, write_sums};
pub use checksum::{Checksum, ChecksumError};
pub use copy::copy_scan;
pub use error::ScanError;
pub use finer::FinerGrid;
pub(crate) use finer::{FINER_KEY, PREFIX as FINER_PREFIX, finer_folders};
pub use folder::ScanFolder;
pub use fresh_folder::fresh_folder;
pub(crate) use manifest::write_json;
pub use manifest::{CaptureEntry, FORMAT, ScanManifest};
pub use picture::{read_picture, write_picture};
pub use response::measure_scan_response;
pub use shows::Shows;
pub(crate) use whole_file::make_dir;
pub use whole_file::{WholeFile, write_whole};
