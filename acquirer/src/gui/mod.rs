//! The acquirer's window: the live picture first and largest, the steps of a scan beside it.
//!
//! ```text
//! rig's thread (camera, projector, live reading) --\
//!                                                    events -> model -> panels -> screen
//! files' thread (reading, results, copies) --------/      <- jobs
//! ```
//! Events and jobs go over bounded channels, the newest picture over a place for one. Nothing in the window's own
//! thread waits for camera, projector, files or pipeline.

mod events;
mod keys;
mod live_picture;
mod model;
mod open_scan;
mod panels;
mod pictures;
mod preferences;
mod repaints;
mod sources;
mod style;
#[cfg(test)]
mod tests;
mod waker;
mod window;
mod worker;

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    path::PathBuf,
};

use anyhow::anyhow;
use eframe::egui;
use look::log::Warnings;
use shared::geometry::RigCalibration;

use crate::{cli::RigArgs, config::Config, session::Cancel};
use preferences::Preferences;

/// What the window starts with.
pub struct Startup {
    /// Which rig.
    pub rig: RigArgs,
    /// The configuration.
    pub config: Config,
    /// Folder under which scans are recorded.
    pub out: PathBuf,
    /// Calibration to put into each scan.
    pub calibration: Option<RigCalibration>,
    /// Run through all steps once, without waiting for the operator.
    pub run_all: bool,
    /// The file that the window's settings are kept in; without one nothing is remembered.
    pub remember: Option<PathBuf>,
    /// What the log warns of: the window tells it.
    pub log: Warnings,
}

/// Where the window's settings are kept, if there is a home for them.
#[must_use]
pub fn usual_settings_file() -> Option<PathBuf> {
    preferences::usual_path()
}

/// Smallest useful size of the window, in points.
const MIN_SIZE: [f32; 2] = [960.0, 600.0];

/// Opens the window and runs until it is closed.
///
/// # Errors
/// No display, or no usable graphics driver, or the desktop ended meanwhile.
pub fn run(startup: Startup, cancel: &Cancel) -> anyhow::Result<()> {
    let remembered = startup.remember.as_deref().map(Preferences::load);
    let (preferences, told) = remembered.unwrap_or_default();
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("acquirer")
            .with_inner_size(preferences.window)
            .with_min_inner_size(MIN_SIZE),
        ..Default::default()
    };
    let cancel = cancel.clone();
    let app: eframe::AppCreator<'_> = Box::new(move |context| {
        let remembered = (preferences, told);
        let window = window::Window::new(startup, remembered, cancel, context)?;
        Ok(Box::new(window))
    });
    // winit and wgpu panic where the desktop does not answer any more
    match catch_unwind(AssertUnwindSafe(|| {
        eframe::run_native("acquirer", options, app)
    })) {
        Ok(Ok(())) => Ok(()),
        Ok(Err(eframe::Error::Wgpu(error))) => Err(anyhow!(
            "no graphics driver can draw into the window: install one (on Debian without a GPU: apt-get install \
             mesa-vulkan-drivers), or use the commands (acquirer --help): {error}"
        )),
        Ok(Err(error)) => Err(anyhow!(
            "the window can't be opened: {error}; without a display use the commands (acquirer --help)"
        )),
        Err(_) => Err(anyhow!(
            "the desktop ended, and the window with it; what was recorded is kept: start the acquirer again and load it, \
             or use the commands (acquirer --help)"
        )),
    }
}
