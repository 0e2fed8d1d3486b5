//! The scan folder: captures on disk, what was projected, and where the results go.

mod finer;
mod folder;

mod response;

pub use finer::FinerGrid;
pub use folder::{
    CaptureEntry, FORMAT, ScanError, ScanFolder, ScanManifest, Shows, read_picture, write_whole,
};
pub use response::measure_scan_response;
