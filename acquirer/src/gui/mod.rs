//! The acquirer's window: the live picture first and largest, the steps of a scan beside it.
//!
//! The rig lives in a worker thread; the window sends it jobs and takes its events, both over bounded channels,
//! and takes the newest camera frame from a place for one. Nothing in the window's thread waits for camera,
//! projector or pipeline.

mod events;
mod window;
mod worker;

use std::path::PathBuf;

use anyhow::anyhow;
use eframe::egui;
use shared::geometry::RigCalibration;

use crate::{cli::RigArgs, config::Config, session::Cancel};

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
}

/// Smallest useful size of the window, in points.
const MIN_SIZE: [f32; 2] = [900.0, 600.0];

/// Opens the window and runs until it is closed.
///
/// # Errors
/// No display, or no usable graphics driver.
pub fn run(startup: Startup, cancel: &Cancel) -> anyhow::Result<()> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("acquirer")
            .with_inner_size([1280.0, 760.0])
            .with_min_inner_size(MIN_SIZE),
        ..Default::default()
    };
    let cancel = cancel.clone();
    eframe::run_native(
        "acquirer",
        options,
        Box::new(move |context| Ok(Box::new(window::Window::new(startup, cancel, &context.egui_ctx)?))),
    )
    .map_err(|error| {
        anyhow!("the window can't be opened: {error}; without a display use the commands (acquirer --help)")
    })
}
