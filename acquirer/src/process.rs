//! Reads a recorded scan and writes its results: what `acquirer process`, `scan` and `demo` share.

use std::{fs, path::Path, time::Instant};

use serde::Serialize;
use shared::{
    geometry::{CalibrationError, RigCalibration},
    stage::Stage,
};
use thiserror::Error;

use crate::{
    config::Config,
    densify::read_finer_grids,
    output::{OutputError, ResultPaths, write_results},
    pipeline::{
        Captures, PipelineError, Projected,
        colour_choice::ColourSelection,
        dense::find_dense_lines,
        read_stage,
        response::{MeasuredResponse, NoMeasurement, ResponseSettings},
        result::ScanResult,
        shift::{
            epipolar::{self, Epipolar},
            find_shifts,
            lines::find_line_shifts,
        },
        surface::{difference::find_differences, read_surface},
    },
    scan::{ScanError, ScanFolder, measure_scan_response},
};

/// The colour selection of a scan, in its folder.
pub const SELECTION_FILE: &str = "colours.json";

/// Why a scan can't be processed.
#[derive(Debug, Error)]
pub enum ProcessError {
    /// The scan folder.
    #[error(transparent)]
    Scan(#[from] ScanError),
    /// The calibration.
    #[error("{path}: {source}")]
    Calibration {
        /// The file.
        path: String,
        /// What is wrong.
        source: CalibrationError,
    },
    /// A file beside the captures.
    #[error("{path}: {reason}")]
    File {
        /// The file.
        path: String,
        /// What is wrong.
        reason: String,
    },
    /// The captures.
    #[error("{stage}: {source}")]
    Pipeline {
        /// Which stage.
        stage: Stage,
        /// What is wrong with it.
        source: PipelineError,
    },
    /// The results.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// No capture of the coded grid in either stage.
    #[error(
        "{0}: the scan has no capture of the coded grid (shows = \"prmvs\"), nothing can be read"
    )]
    Empty(String),
}

/// Time spent on one step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepTime {
    /// What was done.
    pub step: &'static str,
    /// Milliseconds of wall time.
    pub ms: f64,
}

/// A processed scan.
#[derive(Debug)]
pub struct Processed {
    /// What was read.
    pub result: ScanResult,
    /// Where it was written.
    pub paths: ResultPaths,
    /// How long each step took; not part of the results, so that they are the same every time.
    pub times: Vec<StepTime>,
}

/// Reads both stages of a scan, compares them, and writes `DIR/results/`.
///
/// # Errors
/// What is wrong with the folder, its pictures, its calibration, or the place for the results. A picture in which
/// nothing can be read is no error: its crossings are dropped with their reasons.
pub fn process_scan(folder: &ScanFolder, config: &Config) -> Result<Processed, ProcessError> {
    let mut times = Vec::new();
    let mut clock = Instant::now();
    let mut lap = |step, times: &mut Vec<StepTime>| {
        times.push(StepTime {
            step,
            ms: 1000.0 * clock.elapsed().as_secs_f64(),
        });
        clock = Instant::now();
    };
    let projected = folder.projected();
    let calibration = load_calibration(folder)?;
    let selection = load_selection(folder)?;
    let mut settings = config.pipeline;
    let response = measure_response(folder, &mut settings.response)?;
    lap("measure response", &mut times);
    let mut result = ScanResult {
        method: settings.method,
        depth_per_px: config.shift.depth_per_px,
        response,
        settings: serde_json::to_value(settings).unwrap_or_default(),
        ..ScanResult::default()
    };
    // one stage after the other, so that the repeats of only one are in memory
    let mut read = |stage, steps: [&'static str; 2]| {
        let mut captures = folder.captures(stage)?;
        lap(steps[0], &mut times);
        let reading = if captures.prmvs.is_empty() {
            None
        } else {
            let read = read_stage(&captures, &projected, calibration.as_ref(), &settings);
            Some(read.map_err(|source| ProcessError::Pipeline { stage, source })?)
        };
        captures.keep_first();
        lap(steps[1], &mut times);
        Ok::<_, ProcessError>((captures, reading))
    };
    let (background, before) = read(Stage::Background, ["load background", "read background"])?;
    let (object, after) = read(Stage::Object, ["load object", "read object"])?;
    if background.prmvs.is_empty() && object.prmvs.is_empty() {
        return Err(ProcessError::Empty(folder.dir().display().to_string()));
    }
    (result.background, result.object) = (before, after);
    find_shape(
        &mut result,
        [&background, &object],
        &projected,
        calibration.as_ref(),
    );
    lap("shift and surface", &mut times);
    result.finer = read_finer_grids(folder, &result, calibration.as_ref(), &settings)?;
    lap("read finer grids", &mut times);
    let captures = [&background, &object];
    let paths = write_results(folder, captures, &result, selection.as_ref())?;
    lap("write results", &mut times);
    Ok(Processed {
        result,
        paths,
        times,
    })
}

/// Takes the response that the scan's solid colours tell, unless the settings give one.
fn measure_response(
    folder: &ScanFolder,
    settings: &mut ResponseSettings,
) -> Result<Option<Result<MeasuredResponse, NoMeasurement>>, ScanError> {
    if settings.power().is_some() || settings.curve.is_some() {
        return Ok(None);
    }
    let measured = measure_scan_response(folder)?;
    if let Some(Ok(measured)) = &measured
        && !measured.is_srgb
    {
        settings.curve = Some(measured.curve);
    }
    Ok(measured)
}

fn load_calibration(folder: &ScanFolder) -> Result<Option<RigCalibration>, ProcessError> {
    let Some(path) = folder.calibration_path() else {
        return Ok(None);
    };
    read_calibration(&path).map(Some)
}

/// Dense lines, shifts, and with a calibration the surfaces of both stages and their difference.
pub(crate) fn find_shape(
    result: &mut ScanResult,
    captures: [&Captures; 2],
    projected: &Projected,
    calibration: Option<&RigCalibration>,
) {
    for (stage, lines) in [&result.background, &result.object]
        .into_iter()
        .zip(&mut result.lines)
    {
        *lines = stage
            .as_ref()
            .map(|stage| find_dense_lines(&stage.grid))
            .unwrap_or_default();
    }
    if let (Some(before), Some(after)) = (&result.background, &result.object) {
        result.shifts = find_shifts(&before.grid, &after.grid, result.depth_per_px);
        let directions = calibration
            .map(Epipolar::Rig)
            .or_else(|| epipolar::from_shifts(&result.shifts));
        let lines = [&result.lines[0][..], &result.lines[1]];
        result.line_shifts =
            find_line_shifts(lines, &result.shifts, directions, result.depth_per_px);
    }
    let Some(rig) = calibration else { return };
    let mut surfaces = Vec::new();
    for (k, stage) in Stage::BOTH.into_iter().enumerate() {
        let surface = result
            .stage(stage)
            .map(|reading| read_surface((reading, &result.lines[k]), captures[k], projected, rig));
        surfaces.push(surface.unwrap_or_default());
    }
    result.differences = find_differences(&surfaces[0].points, &surfaces[1].points);
    for (k, surface) in surfaces.into_iter().enumerate() {
        result.surface_dropped[k] = surface.dropped;
        let points = surface
            .points
            .into_iter()
            .map(|placed| placed.point)
            .collect();
        match k {
            0 => result.background_surface = points,
            _ => result.surface = points,
        }
    }
}

/// Reads a calibration file.
///
/// # Errors
/// A file that can't be read or is no calibration, with its path.
pub fn read_calibration(path: &Path) -> Result<RigCalibration, ProcessError> {
    let name = || path.display().to_string();
    let bytes = fs::read(path).map_err(|error| ProcessError::File {
        path: name(),
        reason: error.to_string(),
    })?;
    RigCalibration::from_json(&bytes).map_err(|source| ProcessError::Calibration {
        path: name(),
        source,
    })
}

/// Reads the colour selection of a scan, if it has one.
///
/// # Errors
/// A file that can't be read or is no selection, with its path.
pub fn load_selection(folder: &ScanFolder) -> Result<Option<ColourSelection>, ProcessError> {
    let path = folder.dir().join(SELECTION_FILE);
    let fail = |reason: String| ProcessError::File {
        path: path.display().to_string(),
        reason,
    };
    match fs::read(&path) {
        Ok(bytes) => serde_json::from_slice(&bytes)
            .map(Some)
            .map_err(|e| fail(e.to_string())),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(fail(error.to_string())),
    }
}
