//! Helpers for the tests of whole programs.

pub mod endurance;
pub mod frame_server;
pub mod fuzz;
pub mod guest;
mod listening;
pub mod measure;
pub mod numbered;
mod projector;
pub mod told;
mod truth;
pub mod usb_camera;
mod vertices;

use std::{fs, path::Path};

pub use guest::built_program;
pub use projector::{ProjectorProgram, Usage};
pub use truth::read_truth;
pub use vertices::read_vertices;

/// Copies a folder with everything in it.
///
/// # Errors
/// A file that can't be read or written.
pub fn copy_folder(from: &Path, to: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy_folder(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}
