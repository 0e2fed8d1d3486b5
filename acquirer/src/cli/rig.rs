//! Opens the rig that the command line names.

use anyhow::bail;
use shared::protocol::Role;

use super::args::RigArgs;
use crate::{
    camera::{CameraSpec, open_camera, v4l2::list_cameras},
    config::Config,
    pipeline::Projected,
    projector_link::{LinkSettings, ProjectorLink},
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
    let camera = open_camera(&spec, &config.camera, Some(&args.projector))?;
    Ok(Rig::new(projector, camera))
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

/// What the projector's coded grid is at the moment.
///
/// # Errors
/// A projector that does not answer.
pub fn projected(rig: &Rig) -> anyhow::Result<Projected> {
    let state = rig.projector.state()?;
    Ok(Projected {
        pattern: state.grid,
        raster: state.screen.raster,
    })
}
