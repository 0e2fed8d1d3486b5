//! Opens the rig that the command line names.

use std::path::Path;

use anyhow::bail;
use shared::{
    pattern::{Axis, GridSettings},
    protocol::Role,
};

use super::{args::RigArgs, console::Console};
use crate::{
    camera::{CameraSpec, open_camera, v4l2::list_cameras},
    config::Config,
    projector_link::{self, LinkSettings, ProjectorLink},
    scan::ScanFolder,
    session::{Cancel, Rig, SessionError, measure_latency, set_exposure},
};

/// Connects to the projector as its controller, then opens the camera.
///
/// # Errors
/// A projector that can't be reached or has another controller, a camera that can't be opened.
pub fn open_rig(args: &RigArgs, config: &Config) -> anyhow::Result<Rig> {
    let address = projector_link::resolve(&args.projector)?;
    let mut settings = LinkSettings::new(&address, "acquirer", Role::Controller);
    settings.take_over = args.take_over;
    let projector = ProjectorLink::connect(&settings)?;
    let spec = match &args.camera {
        Some(spec) => spec.clone(),
        None => first_camera()?,
    };
    if let CameraSpec::Replay(dir) = &spec {
        show_recorded_grid(&projector, dir)?;
    }
    let settings = args.camera_settings.over(&config.camera);
    let camera = open_camera(&spec, &settings, Some(&address))?;
    Ok(Rig::new(projector, camera))
}

/// Makes a rig ready for recording: sets the exposure if the configuration asks for it, measures the
/// latency, and tells both; a recording has neither.
///
/// # Errors
/// As [`set_exposure`] and [`measure_latency`].
pub(super) fn make_ready(
    rig: &mut Rig,
    config: &Config,
    cancel: &Cancel,
    console: &mut Console,
) -> Result<(), SessionError> {
    let follows = rig.camera.follows_projector();
    if config.exposure.set && follows {
        let exposure = set_exposure(rig, &config.exposure, cancel, &mut |p| console.show(&p))?;
        console.say(&exposure.sentence());
    }
    let latency = measure_latency(rig, &config.latency, cancel, &mut |p| console.show(&p))?;
    if follows {
        console.say(&latency.sentence());
    }
    Ok(())
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
