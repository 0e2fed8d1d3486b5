//! A simulated room as a file: camera, projector, light, and the things that stand there.
//!
//! Takes a TOML text (`config/scenes/`), gives a checked [`Scene`]. An unknown key or a value out of range is an
//! error with file and line. The room's frame has y down like the camera's; where its origin is, is up to the file.

mod build;
mod checked;
mod error;
mod faults;
mod file;

use std::{borrow::Cow, path::Path, time::Duration};

use nalgebra::Vector3;

pub use error::SceneError;
pub(super) use faults::FaultsTable;
pub(super) use file::{AmbientTable, CameraTable, ProjectorTable, ToneCurve, When};

use super::{light::ProjectedLight, random::Random, scaler::Scaler, solid::Solid};
use crate::{
    geometry::{Lens, Pose, RigCalibration},
    pattern::{Raster, RasterSize},
    stage::Stage,
};

/// The stream of random numbers that decides which frames are lost.
const LOSSES: u64 = u64::MAX - 1;

/// A checked description of a simulated room.
#[derive(Debug, Clone)]
pub struct Scene {
    pub(super) title: String,
    pub(super) seed: u64,
    pub(super) camera: CameraTable,
    pub(super) projector: ProjectorTable,
    pub(super) ambient: AmbientTable,
    pub(super) faults: FaultsTable,
    pub(super) room_from_camera: Pose,
    pub(super) room_from_projector: Pose,
    /// Distance at which the projector's white light on a surface that faces it counts as 1.
    pub(super) reference_mm: f64,
    solids: Vec<(When, Solid)>,
}

impl Scene {
    /// Reads a scene file and the files it names, which lie relative to it.
    ///
    /// # Errors
    /// When a file can't be read, or what it says can't be.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(path).map_err(|source| SceneError::Read {
            path: path.to_owned(),
            source,
        })?;
        let folder = path.parent().unwrap_or_else(|| Path::new("."));
        build::scene(&text, &path.display().to_string(), folder)
    }

    /// Reads the text of a scene file; files it names lie relative to `base_dir`.
    ///
    /// # Errors
    /// When what it says can't be, or a file that it names can't be read.
    pub fn parse(text: &str, base_dir: &Path) -> Result<Self, SceneError> {
        build::scene(text, "scene", base_dir)
    }

    /// What the scene is, in a few words.
    #[must_use]
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Size of the camera's picture, px: width, height.
    #[must_use]
    pub fn camera_size(&self) -> (u32, u32) {
        (self.camera.width, self.camera.height)
    }

    /// Size of the projector's raster.
    #[must_use]
    pub fn projector_size(&self) -> RasterSize {
        RasterSize {
            width: self.projector.width,
            height: self.projector.height,
        }
    }

    /// Time from one frame of the camera to the next, as the camera says.
    #[must_use]
    pub fn frame_period(&self) -> Duration {
        Duration::from_secs_f64(1.0 / self.camera.frame_rate_hz)
    }

    /// Time from one frame to the next as they really come.
    #[must_use]
    pub fn delivered_period(&self) -> Duration {
        let rate_hz = self.faults.delivered_rate_hz;
        if rate_hz > 0.0 {
            Duration::from_secs_f64(1.0 / rate_hz)
        } else {
            self.frame_period()
        }
    }

    /// Whether the camera has no controls that programs may set.
    #[must_use]
    pub fn has_no_controls(&self) -> bool {
        self.faults.no_controls
    }

    /// Whether a frame is lost on its way from the camera.
    #[must_use]
    pub fn loses(&self, frame_number: u64) -> bool {
        self.random().part(LOSSES).uniform(frame_number) < self.faults.lost_share
    }

    /// How long each row of the camera gathers light.
    #[must_use]
    pub fn exposure(&self) -> Duration {
        milliseconds(self.camera.exposure_ms)
    }

    /// Time from the start of the first row's exposure to that of the last (rolling shutter); 0 is global.
    #[must_use]
    pub fn readout(&self) -> Duration {
        milliseconds(self.camera.readout_ms)
    }

    /// Whether the camera sets its exposure by itself when it is opened.
    #[must_use]
    pub fn auto_exposure(&self) -> bool {
        self.camera.auto_exposure
    }

    /// Whether the camera sets its white balance by itself when it is opened.
    #[must_use]
    pub fn auto_white_balance(&self) -> bool {
        self.camera.auto_white_balance
    }

    /// The true calibration of the rig.
    #[must_use]
    pub fn calibration(&self) -> RigCalibration {
        let projector_from_room = self.room_from_projector.inverse();
        RigCalibration {
            camera: camera_lens(&self.camera),
            projector: projector_lens(&self.projector),
            projector_from_camera: projector_from_room.after(&self.room_from_camera),
        }
    }

    /// The light that the projector makes of a picture; a picture of another size is stretched over its raster.
    #[must_use]
    pub fn project(&self, picture: &Raster) -> ProjectedLight {
        let picture = self.on_screen(picture);
        ProjectedLight::new(&self.projector, &picture)
    }

    /// What becomes of a picture on its way to the projector's pixels.
    fn on_screen<'a>(&self, picture: &'a Raster) -> Cow<'a, Raster> {
        if let Some(colour) = self.faults.other_output {
            return Cow::Owned(Raster::from_fn(picture.size(), |_, _| colour));
        }
        match Scaler::new(&self.faults) {
            Some(scaler) => Cow::Owned(scaler.apply(picture)),
            None => Cow::Borrowed(picture),
        }
    }

    /// The solids that are there in a stage.
    pub(super) fn solids(&self, stage: Stage) -> Vec<Solid> {
        let is_there = |when: When| when == When::Always || stage == Stage::Object;
        self.solids
            .iter()
            .filter(|(when, _)| is_there(*when))
            .map(|(_, s)| s.clone())
            .collect()
    }

    /// Random numbers of this scene.
    pub(super) fn random(&self) -> Random {
        Random::new(self.seed)
    }
}

fn milliseconds(value: f64) -> Duration {
    Duration::from_secs_f64(value / 1000.0)
}

fn camera_lens(table: &CameraTable) -> Lens {
    Lens {
        width: table.width,
        height: table.height,
        fx: table.focal_px[0],
        fy: table.focal_px[1],
        cx: table.centre_px[0],
        cy: table.centre_px[1],
        distortion: table.distortion,
    }
}

fn projector_lens(table: &ProjectorTable) -> Lens {
    Lens {
        width: table.width,
        height: table.height,
        fx: table.focal_px[0],
        fy: table.focal_px[1],
        cx: table.centre_px[0],
        cy: table.centre_px[1],
        distortion: table.distortion,
    }
}

/// `room_from_device` from a table's three keys.
fn device_pose(position: [f64; 3], looks_at: [f64; 3], roll_deg: f64) -> Option<Pose> {
    Pose::looking_at(
        Vector3::from(position),
        Vector3::from(looks_at),
        roll_deg.to_radians(),
    )
}
