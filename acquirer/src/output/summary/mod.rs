//! The figures of a scan in one small object: what was read, what was not and why, shifts, surface.
//!
//! Takes the scan and its result, gives a [`Summary`] that serialises to `summary.json`. It holds no time and
//! no path, so that the same scan processed twice gives the same bytes. Lengths end in `_px` or `_mm`.

mod reading;
mod shifts;
mod surface;

use serde::Serialize;
use shared::{
    pattern::{CameraScale, GridSettings, RasterSize},
    stage::Stage,
};

pub use reading::StageFigures;
pub use shifts::{LineShiftFigures, ShiftFigures};
pub use surface::{DifferenceFigures, SurfaceFigures};

use super::{finer::FinerFigures, response::ResponseFigures};
use crate::{
    pipeline::{Method, dense::measured_scale, result::ScanResult},
    scan::ScanFolder,
};

/// Version of the summary's layout.
pub const FORMAT: u32 = 1;

/// The figures of one scan.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Version of this layout: [`FORMAT`].
    pub format: u32,
    /// How the grid was read.
    pub method: Method,
    /// What was projected.
    pub pattern: GridSettings,
    /// The projector's raster, in pixels.
    pub projector: RasterSize,
    /// Size of the captures, in pixels.
    pub camera: RasterSize,
    /// Whether the scan has a calibration.
    pub calibrated: bool,
    /// What was read before the object was put in, if that was recorded.
    pub background: Option<StageFigures>,
    /// What was read with the object, if that was recorded.
    pub object: Option<StageFigures>,
    /// How far the vertices moved, if any was read in both stages.
    pub shifts: Option<ShiftFigures>,
    /// What moved along the epipolar direction, if that is known.
    pub line_shifts: Option<LineShiftFigures>,
    /// Where the surface lies, if there is one.
    pub surface: Option<SurfaceFigures>,
    /// How far the object stands out of the background, with a calibration.
    pub difference: Option<DifferenceFigures>,
    /// What finer grids gave, coarse before fine; empty without any.
    pub finer: Vec<FinerFigures>,
    /// The curve from camera bytes to light; the thesis's method needs none.
    pub response: Option<ResponseFigures>,
    /// What an operator should change: a grid that the camera can't resolve, pictures that do not add up.
    pub warnings: Vec<String>,
    /// The effective settings of the pipeline.
    pub settings: serde_json::Value,
}

impl Summary {
    /// Counts what a result holds.
    #[must_use]
    pub fn of(folder: &ScanFolder, result: &ScanResult) -> Self {
        let manifest = folder.manifest();
        let coded = &manifest.pattern.coded;
        let possible = coded.rows() * coded.columns();
        let figures = |stage| {
            let lines = &result.lines[usize::from(stage == Stage::Object)];
            let reading = result.stage(stage)?;
            Some(StageFigures::of(reading, lines, possible))
        };
        Self {
            format: FORMAT,
            method: result.method,
            pattern: manifest.pattern.clone(),
            projector: manifest.projector,
            camera: manifest.camera,
            calibrated: manifest.calibration.is_some(),
            background: figures(Stage::Background),
            object: figures(Stage::Object),
            shifts: ShiftFigures::of(result),
            line_shifts: LineShiftFigures::of(result),
            surface: SurfaceFigures::of(result),
            difference: DifferenceFigures::of(result),
            finer: result.finer.iter().map(FinerFigures::of).collect(),
            response: ResponseFigures::of(result),
            warnings: warnings(folder, result),
            settings: result.settings.clone(),
        }
    }

    /// The figures of one stage.
    #[must_use]
    pub fn stage(&self, stage: Stage) -> Option<&StageFigures> {
        match stage {
            Stage::Background => self.background.as_ref(),
            Stage::Object => self.object.as_ref(),
        }
    }
}

/// Lines too fine for the camera, by the scale measured on the decoded grid, else by the pictures' sizes; and solid
/// colours that tell no response.
fn warnings(folder: &ScanFolder, result: &ScanResult) -> Vec<String> {
    let manifest = folder.manifest();
    let (grid, raster) = (&manifest.pattern.coded, manifest.projector);
    let measured = Stage::BOTH
        .into_iter()
        .filter_map(|stage| measured_scale(&result.stage(stage)?.grid, grid, raster))
        .next();
    let scale = measured.unwrap_or_else(|| CameraScale::filling(raster, manifest.camera));
    let finer = result.finer.iter().map(|scan| &scan.pattern.coded);
    let grids = std::iter::once(grid).chain(finer);
    let mut warnings: Vec<String> = grids
        .flat_map(|grid| grid.camera_warnings(raster, scale))
        .collect();
    if let Some(Err(refused)) = &result.response {
        warnings.push(refused.to_string());
    }
    warnings
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Three digits after the point: finer than anything measured here, and short to read.
pub(super) fn rounded(value: f64) -> f64 {
    (1000.0 * value).round() / 1000.0
}
