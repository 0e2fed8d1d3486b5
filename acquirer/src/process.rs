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
    output::{EncodedPicture, OutputError, ResultPaths, write_results},
    pipeline::{
        Captures, PipelineError, PipelineSettings, Projected, StageReading,
        dense::{DenseLine, find_dense_lines},
        densify::{KnownPlaces, read_finer},
        read_stage_sparingly,
        response::{MeasuredResponse, NoMeasurement, ResponseSettings},
        result::ScanResult,
        shift::{
            epipolar::{self, Epipolar},
            find_shifts,
            lines::find_line_shifts,
        },
        surface::{Placed, Surface, SurfacePoint, difference::find_differences, read_surface},
    },
    scan::{FinerGrid, ScanError, ScanFolder, Shows, measure_scan_response},
    session::{Cancel, Progress, Report},
};

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
    /// The operator stopped it.
    #[error("the reading was stopped by the operator; no results were written")]
    Cancelled,
}

/// Steps of a reading; a scan without an object has fewer.
const STEPS: usize = 8;

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
    process_scan_until(folder, config, &Cancel::default(), &mut |_| ())
}

/// As [`process_scan`], told step by step, and stopped between two steps before anything is written.
///
/// # Errors
/// As [`process_scan`], and [`ProcessError::Cancelled`].
pub fn process_scan_until(
    folder: &ScanFolder,
    config: &Config,
    cancel: &Cancel,
    report: Report,
) -> Result<Processed, ProcessError> {
    let mut captures = folder.manifest().captures.iter();
    if !captures.any(|capture| capture.shows == Shows::Prmvs) {
        return Err(ProcessError::Empty(folder.dir().display().to_string()));
    }
    let what = format!("reading {}", folder.dir().display());
    let mut clock = Clock::start(what, cancel, report);
    clock.tell()?;
    let calibration = folder
        .calibration_path()
        .map(|path| read_calibration(&path));
    let calibration = calibration.transpose()?;
    let selection = folder.selection()?;
    let mut settings = config.pipeline;
    let response = measure_response(folder, &mut settings.response)?;
    clock.lap("measure response")?;
    let reader = StageReader {
        folder,
        projected: folder.projected(),
        calibration: calibration.as_ref(),
        settings: &settings,
    };
    let before = reader.read(Stage::Background, &mut clock)?;
    let after = reader.read(Stage::Object, &mut clock)?;
    let (mut result, pictures) = compare([before, after], &reader, config.shift.depth_per_px);
    result.response = response;
    clock.lap("compare")?;
    result.finer = read_finer_grids(&reader, &result)?;
    clock.lap("read finer grids")?;
    let paths = write_results(folder, &pictures, &result, selection.as_ref())?;
    clock.end("write results");
    Ok(Processed {
        result,
        paths,
        times: clock.times,
    })
}

/// Times one step after another, tells them, and stops between them.
struct Clock<'a> {
    what: String,
    cancel: &'a Cancel,
    report: Report<'a>,
    begun: Instant,
    times: Vec<StepTime>,
}

impl<'a> Clock<'a> {
    fn start(what: String, cancel: &'a Cancel, report: Report<'a>) -> Self {
        Self {
            what,
            cancel,
            report,
            begun: Instant::now(),
            times: Vec::new(),
        }
    }

    /// Ends a step, and all of them if the operator wants that.
    fn lap(&mut self, step: &'static str) -> Result<(), ProcessError> {
        self.end(step);
        self.tell()
    }

    fn end(&mut self, step: &'static str) {
        let ms = 1000.0 * self.begun.elapsed().as_secs_f64();
        self.times.push(StepTime { step, ms });
        self.begun = Instant::now();
    }

    fn tell(&mut self) -> Result<(), ProcessError> {
        (self.report)(Progress {
            what: self.what.clone(),
            done: self.times.len().min(STEPS),
            of: STEPS,
        });
        match self.cancel.is_cancelled() {
            true => Err(ProcessError::Cancelled),
            false => Ok(()),
        }
    }
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

/// What was measured in one stage. Its captures are on the disk, and its pictures are encoded: they would fill the
/// memory that reading the other stage needs.
#[derive(Default)]
pub(crate) struct StageProducts {
    reading: Option<StageReading>,
    lines: Vec<DenseLine>,
    surface: Surface,
    pictures: Vec<EncodedPicture>,
}

/// Reads one stage after the other.
pub(crate) struct StageReader<'a> {
    pub(crate) folder: &'a ScanFolder,
    pub(crate) projected: Projected,
    pub(crate) calibration: Option<&'a RigCalibration>,
    pub(crate) settings: &'a PipelineSettings,
}

impl StageReader<'_> {
    fn read(&self, stage: Stage, clock: &mut Clock<'_>) -> Result<StageProducts, ProcessError> {
        let [loading, reading] = match stage {
            Stage::Background => ["load background", "read background"],
            Stage::Object => ["load object", "read object"],
        };
        let mut captures = self.folder.captures(stage)?;
        clock.lap(loading)?;
        if captures.prmvs.is_empty() {
            return Ok(StageProducts::default());
        }
        let products = self.products(stage, &mut captures, None)?;
        clock.lap(reading)?;
        Ok(products)
    }

    /// Reads a finer grid, the reader's own, beside what is known of the places on the projector.
    pub(crate) fn read_finer(
        &self,
        grid: &FinerGrid,
        stage: Stage,
        known: KnownPlaces,
    ) -> Result<StageProducts, ProcessError> {
        let mut captures = self.folder.finer_captures(grid, stage)?;
        if captures.prmvs.is_empty() {
            return Ok(StageProducts::default());
        }
        self.products(stage, &mut captures, Some(known))
    }

    fn products(
        &self,
        stage: Stage,
        captures: &mut Captures,
        known: Option<KnownPlaces>,
    ) -> Result<StageProducts, ProcessError> {
        let (projected, calibration, settings) = (&self.projected, self.calibration, self.settings);
        let read = match known {
            None => read_stage_sparingly(captures, projected, calibration, settings),
            Some(known) => read_finer(captures, projected, calibration, settings, known),
        };
        let mut reading = read.map_err(|source| ProcessError::Pipeline { stage, source })?;
        let pictures = std::mem::take(&mut reading.pictures);
        let lines = find_dense_lines(&reading.grid);
        let surface = self.calibration.map(|rig| {
            let seen = (&reading, &lines[..]);
            read_surface(seen, captures, &self.projected, rig)
        });
        Ok(StageProducts {
            lines,
            surface: surface.unwrap_or_default(),
            pictures: EncodedPicture::of_stage(stage, pictures)?,
            reading: Some(reading),
        })
    }
}

/// Shifts, and with a calibration the difference of the surfaces, of both stages.
pub(crate) fn compare(
    [before, after]: [StageProducts; 2],
    reader: &StageReader,
    depth_per_px: f64,
) -> (ScanResult, [Vec<EncodedPicture>; 2]) {
    let mut result = ScanResult {
        method: reader.settings.method,
        depth_per_px,
        settings: serde_json::to_value(reader.settings).unwrap_or_default(),
        differences: find_differences(&before.surface.points, &after.surface.points),
        background: before.reading,
        object: after.reading,
        lines: [before.lines, after.lines],
        surface_dropped: [before.surface.dropped, after.surface.dropped],
        background_surface: points(before.surface.points),
        surface: points(after.surface.points),
        ..ScanResult::default()
    };
    if let (Some(before), Some(after)) = (&result.background, &result.object) {
        result.shifts = find_shifts(&before.grid, &after.grid, result.depth_per_px);
        let directions = reader
            .calibration
            .map(Epipolar::Rig)
            .or_else(|| epipolar::from_shifts(&result.shifts));
        let lines = [&result.lines[0][..], &result.lines[1]];
        result.line_shifts =
            find_line_shifts(lines, &result.shifts, directions, result.depth_per_px);
    }
    (result, [before.pictures, after.pictures])
}

fn points(placed: Vec<Placed>) -> Vec<SurfacePoint> {
    placed.into_iter().map(|placed| placed.point).collect()
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
