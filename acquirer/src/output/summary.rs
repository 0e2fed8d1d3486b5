//! The figures of a scan in one small object: what was read, what was not and why, shifts, surface.
//!
//! Takes the scan and its result, gives a [`Summary`] that serialises to `summary.json`. It holds no time and
//! no path, so that the same scan processed twice gives the same bytes. Lengths end in `_px` or `_mm`.

use std::collections::BTreeMap;

use serde::Serialize;
use shared::{
    pattern::{CameraScale, GridSettings, RasterSize},
    stage::Stage,
};

use super::{
    finer::FinerFigures,
    response::ResponseFigures,
    tables::{finite_points, share},
};
use crate::{
    pipeline::{
        Method, StageReading,
        dense::{DenseLine, measured_scale},
        grid::{DecodedGrid, DropReason},
        result::ScanResult,
        shift::epipolar::DirectionSource,
    },
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

/// What was read from one stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageFigures {
    /// Crossings of the projected grid.
    pub crossings_possible: usize,
    /// Crossings with a label.
    pub crossings_labelled: usize,
    /// Labelled of possible crossings, in percent.
    pub coverage_percent: f64,
    /// Vertices: four for each labelled crossing.
    pub vertices: usize,
    /// Mean confidence of the labels, 0 to 1; `None` without labels.
    pub mean_confidence: Option<f64>,
    /// Crossings found and dropped, for each reason by its name.
    pub dropped: BTreeMap<&'static str, usize>,
    /// All dropped crossings.
    pub dropped_total: usize,
    /// Points along decoded lines.
    pub line_points: usize,
}

/// How far the vertices moved between the stages, in camera pixels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShiftFigures {
    /// Vertices read in both stages.
    pub vertices: usize,
    /// Crossings read in both stages.
    pub crossings: usize,
    /// Relative depth for one pixel of shift.
    pub depth_per_px: f64,
    /// Smallest shift.
    pub smallest_px: f64,
    /// Half of the vertices moved less.
    pub median_px: f64,
    /// Mean shift.
    pub mean_px: f64,
    /// Largest shift.
    pub largest_px: f64,
}

/// Where the surface lies, in millimetres of the camera frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfaceFigures {
    /// All points.
    pub points: usize,
    /// Points that are vertices of crossings.
    pub vertices: usize,
    /// Vertices and line points of the object without a point, for each reason by its name.
    pub dropped: BTreeMap<&'static str, usize>,
    /// Smallest and largest x (to the right).
    pub x_mm: [f64; 2],
    /// Smallest and largest y (downwards).
    pub y_mm: [f64; 2],
    /// Smallest and largest z (forward).
    pub z_mm: [f64; 2],
    /// Half of the points are nearer.
    pub median_z_mm: f64,
}

/// What moved along the epipolar direction, in camera pixels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LineShiftFigures {
    /// Where the direction comes from.
    pub direction: DirectionSource,
    /// Line points with a shift.
    pub points: usize,
    /// Line points without: the line runs along the epipolar direction.
    pub along_epipolar: usize,
    /// Line points without: not read where they should be in the background.
    pub not_in_background: usize,
    /// Vertices that moved by more than a pixel.
    pub moved_vertices: usize,
    /// Root mean square of their shifts across the direction, which is error only; `None` when none moved.
    pub across_rms_px: Option<f64>,
    /// Vertices whose error is more than three standard deviations.
    pub rejected_vertices: usize,
}

/// How far the object stands out of the background, in mm along the projector's rays.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DifferenceFigures {
    /// Points compared.
    pub points: usize,
    /// Half of the points stand out less.
    pub median_mm: f64,
    /// 95 % of the points stand out less.
    pub p95_mm: f64,
    /// The largest height.
    pub largest_mm: f64,
}

impl LineShiftFigures {
    fn of(result: &ScanResult) -> Option<Self> {
        let found = &result.line_shifts;
        Some(Self {
            direction: found.source?,
            points: found.points.len(),
            along_epipolar: found.along_epipolar,
            not_in_background: found.not_in_background,
            moved_vertices: found.across.map_or(0, |a| a.moved),
            across_rms_px: found.across.map(|a| rounded(a.rms_px)),
            rejected_vertices: found.across.map_or(0, |a| a.rejected),
        })
    }
}

impl DifferenceFigures {
    fn of(result: &ScanResult) -> Option<Self> {
        let mut heights: Vec<f64> = result.differences.iter().map(|d| d.height_mm).collect();
        heights.retain(|height| height.is_finite());
        heights.sort_by(f64::total_cmp);
        let at = |share: f64| {
            heights
                .get((share * heights.len() as f64) as usize)
                .copied()
        };
        Some(Self {
            points: heights.len(),
            median_mm: rounded(at(0.5)?),
            p95_mm: rounded(at(0.95)?),
            largest_mm: rounded(*heights.last()?),
        })
    }
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

impl StageFigures {
    pub(super) fn of(reading: &StageReading, lines: &[DenseLine], possible: usize) -> Self {
        let grid: &DecodedGrid = &reading.grid;
        let labelled = grid.crossings.len();
        let confidences: Vec<f64> = grid.crossings.iter().map(|c| share(c.confidence)).collect();
        let by_reason = grid.dropped_by_reason();
        Self {
            crossings_possible: possible,
            crossings_labelled: labelled,
            coverage_percent: rounded(100.0 * labelled as f64 / possible.max(1) as f64),
            vertices: 4 * labelled,
            mean_confidence: mean(&confidences).map(rounded),
            dropped: by_reason
                .map(|(reason, count)| (DropReason::name(reason), count))
                .into(),
            dropped_total: grid.dropped.len(),
            line_points: lines.iter().map(|line| line.points.len()).sum(),
        }
    }
}

impl ShiftFigures {
    fn of(result: &ScanResult) -> Option<Self> {
        let mut shifts: Vec<f64> = result.shifts.iter().map(|s| s.shift_px).collect();
        shifts.retain(|shift| shift.is_finite());
        shifts.sort_by(f64::total_cmp);
        let mut crossings: Vec<_> = result.shifts.iter().map(|s| s.index).collect();
        crossings.sort_unstable();
        crossings.dedup();
        Some(Self {
            vertices: shifts.len(),
            crossings: crossings.len(),
            depth_per_px: result.depth_per_px,
            smallest_px: rounded(*shifts.first()?),
            median_px: rounded(shifts[shifts.len() / 2]),
            mean_px: rounded(mean(&shifts)?),
            largest_px: rounded(*shifts.last()?),
        })
    }
}

impl SurfaceFigures {
    fn of(result: &ScanResult) -> Option<Self> {
        let along = |axis: usize| {
            let mut values: Vec<f64> = finite_points(&result.surface)
                .map(|point| point.position_mm[axis])
                .collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let range = |values: &[f64]| Some([rounded(*values.first()?), rounded(*values.last()?)]);
        let z = along(2);
        Some(Self {
            points: z.len(),
            vertices: finite_points(&result.surface)
                .filter(|point| point.corner.is_some())
                .count(),
            dropped: result.surface_dropped[1]
                .iter()
                .map(|(reason, count)| (reason.name(), *count))
                .collect(),
            x_mm: range(&along(0))?,
            y_mm: range(&along(1))?,
            z_mm: range(&z)?,
            median_z_mm: rounded(z[z.len() / 2]),
        })
    }
}

/// Lines too fine for the camera, by the scale measured on the decoded grid, else by the pictures' sizes.
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
