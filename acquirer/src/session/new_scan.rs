//! Begins a scan folder for what the rig is about to record, with everything that belongs beside the captures.

use std::path::Path;

use shared::{
    geometry::RigCalibration,
    pattern::{CameraScale, Grid, PatternError, RasterSize},
};

use super::{RecordSettings, Rig, SessionError, finer::finer_patterns};
use crate::{
    config::Config,
    pipeline::{Projected, colour_choice::ColourSelection},
    projector_link::LinkError,
    scan::ScanFolder,
};

/// What is known of a scan before its first capture.
#[derive(Debug, Clone, Copy)]
pub struct NewScan<'a> {
    /// The new folder.
    pub dir: &'a Path,
    /// The configuration in use.
    pub config: &'a Config,
    /// How the grid's colours were chosen, if they were chosen on this scene.
    pub selection: Option<&'a ColourSelection>,
    /// The rig's calibration, if there is one.
    pub calibration: Option<&'a RigCalibration>,
}

impl NewScan<'_> {
    /// Makes the folder, and notes in it the camera, the latency if it was measured, the configuration, the choice of
    /// colours and the calibration.
    ///
    /// # Errors
    /// A projector that does not tell its grid, a folder that holds a scan already, a file that can't be written.
    pub fn begin(&self, rig: &Rig) -> Result<ScanFolder, SessionError> {
        let projected = projected(rig)?;
        let mut folder = ScanFolder::create(self.dir, &projected, camera_size(rig))?;
        folder.note("camera_name", &rig.camera.description())?;
        folder.note("settings", self.config)?;
        if let Some(latency) = &rig.latency {
            folder.note("latency", latency)?;
        }
        if let Some(selection) = self.selection {
            folder.set_selection(selection)?;
        }
        if let Some(calibration) = self.calibration {
            folder.set_calibration(calibration)?;
        }
        Ok(folder)
    }
}

/// What the projector's coded grid is at the moment.
///
/// # Errors
/// A projector that does not answer.
pub fn projected(rig: &Rig) -> Result<Projected, LinkError> {
    let state = rig.projector.state()?;
    Ok(Projected {
        pattern: state.grid,
        raster: state.screen.raster,
    })
}

/// What the operator should know before this grid is recorded: lines that touch, or that the camera can't resolve
/// even if the projector's picture fills its own.
#[must_use]
pub fn grid_warnings(rig: &Rig, projected: &Projected) -> Vec<String> {
    warnings(rig, &projected.pattern.coded, projected.raster)
}

/// As [`grid_warnings`], for the grid and the finer ones that are recorded after it.
///
/// # Errors
/// A finer grid that there is not.
pub fn recording_warnings(
    rig: &Rig,
    projected: &Projected,
    settings: &RecordSettings,
) -> Result<Vec<String>, PatternError> {
    let mut all = grid_warnings(rig, projected);
    for finer in finer_patterns(projected, settings)? {
        all.extend(warnings(rig, &finer.coded, projected.raster));
    }
    Ok(all)
}

fn warnings(rig: &Rig, grid: &Grid, raster: RasterSize) -> Vec<String> {
    let mut warnings = grid.warnings(raster);
    warnings.extend(grid.camera_warnings(raster, CameraScale::filling(raster, camera_size(rig))));
    warnings
}

fn camera_size(rig: &Rig) -> RasterSize {
    let format = rig.camera.format();
    RasterSize {
        width: format.width,
        height: format.height,
    }
}
