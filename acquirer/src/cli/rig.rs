//! Opens the rig that the command line names.

use std::path::Path;

use anyhow::bail;
use shared::{
    pattern::{Axis, GridSettings},
    protocol::Role,
};

use super::args::RigArgs;
use crate::{
    camera::{CameraSpec, open_camera, v4l2::list_cameras},
    config::Config,
    projector_link::{LinkSettings, ProjectorLink},
    scan::ScanFolder,
    session::Rig,
};

/// Connects to the projector as its controller, then opens the camera.
///
/// # Errors
/// A projector that can't be reached or has another controller, a camera that can't be opened.
pub fn open_rig(args: &RigArgs, config: &Config) -> anyhow::Result<Rig> {
    let mut settings = LinkSettings::new(&args.projector, "acquirer", Role::Controller);
    settings.take_over = args.take_over;
    let projector = ProjectorLink::connect(&settings)?;
    let spec = match &args.camera {
        Some(spec) => spec.clone(),
        None => first_camera()?,
    };
    if let CameraSpec::Replay(dir) = &spec {
        show_recorded_grid(&projector, dir)?;
    }
    let camera = open_camera(&spec, &config.camera, Some(&args.projector))?;
    Ok(Rig::new(projector, camera))
}

/// Gives the projector the grid of a recording that is replayed, so that what is recorded now is told rightly.
/// A folder of plain pictures has none.
fn show_recorded_grid(projector: &ProjectorLink, dir: &Path) -> anyhow::Result<()> {
    let Ok(folder) = ScanFolder::open(dir) else {
        return Ok(());
    };
    show_grid(projector, &folder.manifest().pattern)
}

/// Gives the projector the grid that a scan was begun with.
pub(super) fn show_grid(projector: &ProjectorLink, grid: &GridSettings) -> anyhow::Result<()> {
    let GridSettings { coded, unary } = grid;
    projector.set_lines(coded.rows(), coded.columns())?;
    projector.set_widths(coded.width_px(Axis::Row), coded.width_px(Axis::Column))?;
    projector.set_colours(coded.colours(), *unary)?;
    Ok(())
}

fn first_camera() -> anyhow::Result<CameraSpec> {
    let cameras = list_cameras();
    let Some(first) = cameras.first() else {
        bail!(
            "no camera is plugged in; plug one in, or use --camera replay:DIR (a recorded scan) or \
             --camera sim:SCENE (a simulated room)"
        );
    };
    Ok(CameraSpec::Device(first.path.clone()))
}
