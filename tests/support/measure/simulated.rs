//! A whole scan of a simulated room in memory, with its truth: no projector, no camera, no files.

use std::{fs, path::Path};

use acquirer::{
    pipeline::{Captures, Projected},
    scan::{ScanFolder, Shows},
};
use anyhow::Context;
use image::RgbImage;
use shared::{
    geometry::RigCalibration,
    pattern::{GridSettings, Pattern, RasterSize},
    simulation::{Room, Scene, TruthVertex, write_truth_csv},
    stage::Stage,
};

use super::Condition;

/// How often each picture is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Repeats {
    /// Under black and white light.
    pub references: usize,
    /// Of the coded grid.
    pub coded: usize,
    /// Of the single-colour grid.
    pub unary: usize,
}

impl Repeats {
    /// Two frames each of black and white, one of the coded grid: what reading a single frame takes.
    pub const SINGLE_FRAME: Self = Self {
        references: 2,
        coded: 1,
        unary: 0,
    };
}

impl Default for Repeats {
    /// As `config/acquirer.toml` records.
    fn default() -> Self {
        Self {
            references: 3,
            coded: 2,
            unary: 2,
        }
    }
}

/// A scan of a simulated room.
#[derive(Debug, Clone)]
pub struct SimulatedScan {
    /// What the projector showed.
    pub projected: Projected,
    /// The true calibration.
    pub calibration: RigCalibration,
    /// The captures of the stages, in the order of [`Stage::BOTH`].
    pub stages: [Captures; 2],
    /// The truth of both stages.
    pub truth: Vec<TruthVertex>,
}

impl SimulatedScan {
    /// Records both stages of a scene; the same arguments give the same bytes.
    #[must_use]
    pub fn record(scene: &Scene, pattern: &GridSettings, repeats: Repeats) -> Self {
        let raster = scene.projector_size();
        let mut truth = Vec::new();
        let stages = Stage::BOTH.map(|stage| {
            let room = Room::new(scene, stage);
            truth.extend(room.truth(&pattern.coded, raster));
            captures(scene, &room, pattern, repeats)
        });
        Self {
            projected: Projected {
                pattern: pattern.clone(),
                raster,
            },
            calibration: scene.calibration(),
            stages,
            truth,
        }
    }

    /// The box before the wall (`config/scenes/cube.toml`) under the shipped grid, seen by a camera of this size with
    /// the shipped camera's field across.
    ///
    /// # Errors
    /// A scene file that is not there.
    pub fn of_camera(size: (u32, u32), repeats: Repeats) -> anyhow::Result<Self> {
        let scene = scene_of_camera("cube", size)?;
        Ok(Self::record(&scene, &GridSettings::default(), repeats))
    }

    /// Writes the scan as a scan folder with `calibration.json` and `truth.csv`, so that `acquirer process` reads it.
    ///
    /// # Errors
    /// A file that can't be written, or a folder that already holds a scan.
    pub fn save(&self, dir: &Path) -> anyhow::Result<()> {
        let first = self.stages[0].prmvs.first().context("no coded capture")?;
        let camera = RasterSize {
            width: first.width(),
            height: first.height(),
        };
        let mut folder = ScanFolder::create(dir, &self.projected, camera)?;
        for (stage, captures) in Stage::BOTH.into_iter().zip(&self.stages) {
            for (shows, frames) in [
                (Shows::Black, &captures.black),
                (Shows::White, &captures.white),
                (Shows::Prmvs, &captures.prmvs),
                (Shows::Unary, &captures.unary),
            ] {
                for frame in frames {
                    folder.add_capture(stage, shows, frame)?;
                }
            }
        }
        folder.set_calibration(&self.calibration)?;
        write_truth_csv(&self.truth, fs::File::create(dir.join("truth.csv"))?)?;
        Ok(())
    }
}

/// A shipped scene, seen by a camera of this size with the shipped camera's field across.
///
/// # Errors
/// A scene file that is not there.
pub fn scene_of_camera(name: &str, (width, height): (u32, u32)) -> anyhow::Result<Scene> {
    let scale = f64::from(width) / 640.0;
    let condition: Condition = toml::from_str(&format!(
        "name = \"\"\n[set]\n\"camera.width\" = {width}\n\"camera.height\" = {height}\n\
         \"camera.focal_px\" = [{focal:?}, {focal:?}]\n\"camera.centre_px\" = [{x:?}, {y:?}]\n",
        focal = 690.0 * scale,
        x = 324.3 * scale,
        y = f64::from(height) / 2.0 - 3.1 * scale,
    ))?;
    condition.scene(name, &toml::Table::new())
}

fn captures(scene: &Scene, room: &Room, pattern: &GridSettings, repeats: Repeats) -> Captures {
    let mut frame_number = 0;
    let mut shoot = |pattern: Pattern, count: usize| -> Vec<RgbImage> {
        if count == 0 {
            return Vec::new();
        }
        let light = scene.project(&pattern.raster(scene.projector_size()));
        let frames = (0..count).map(|_| {
            frame_number += 1;
            room.render(&light, frame_number)
        });
        frames.collect()
    };
    Captures {
        black: shoot(Pattern::BLACK, repeats.references),
        white: shoot(Pattern::WHITE, repeats.references),
        prmvs: shoot(pattern.coded.clone().into(), repeats.coded),
        unary: shoot(pattern.unary_grid().into(), repeats.unary),
    }
}
