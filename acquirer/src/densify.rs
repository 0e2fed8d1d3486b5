//! Reads the finer grids of a scan, coarse before fine, each beside what the coarser ones gave.

use shared::{geometry::RigCalibration, stage::Stage};

use crate::{
    pipeline::{
        Captures, Method, PipelineSettings, Projected, StageReading,
        densify::{KnownPlaces, read_finer},
        result::{FinerScan, ScanResult},
    },
    process::{ProcessError, find_shape},
    scan::{FinerGrid, ScanFolder},
};

/// The finer grids of the scan whose base grid was read; none with the thesis's method, which decodes a grid by itself.
///
/// # Errors
/// What is wrong with the folder or its pictures.
pub(crate) fn read_finer_grids(
    folder: &ScanFolder,
    base: &ScanResult,
    calibration: Option<&RigCalibration>,
    settings: &PipelineSettings,
) -> Result<Vec<FinerScan>, ProcessError> {
    if settings.method != Method::Likelihood {
        return Ok(Vec::new());
    }
    let settings = PipelineSettings {
        pictures: false, // those of the base grid show the method
        ..*settings
    };
    let places = |reading: Option<&StageReading>, projected: &Projected| {
        let grid = reading.map(|reading| KnownPlaces::of(&reading.grid, projected));
        grid.unwrap_or_default()
    };
    let mut known = Stage::BOTH.map(|stage| places(base.stage(stage), &folder.projected()));
    let mut scans = Vec::new();
    for grid in folder.finer()? {
        let projected = folder.projected_finer(&grid);
        let mut result = ScanResult {
            method: settings.method,
            depth_per_px: base.depth_per_px,
            ..ScanResult::default()
        };
        let mut captures = [Captures::default(), Captures::default()];
        for (k, stage) in Stage::BOTH.into_iter().enumerate() {
            let (seen, reading) = Stages {
                folder,
                grid: &grid,
                projected: &projected,
            }
            .read(stage, calibration, &settings, known[k].clone())?;
            known[k] = std::mem::take(&mut known[k]).with(places(reading.as_ref(), &projected));
            captures[k] = seen;
            match stage {
                Stage::Background => result.background = reading,
                Stage::Object => result.object = reading,
            }
        }
        find_shape(
            &mut result,
            [&captures[0], &captures[1]],
            &projected,
            calibration,
        );
        let [_, object] = captures;
        scans.push(FinerScan {
            pattern: grid.pattern,
            result,
            seen: object.unary.into_iter().chain(object.prmvs).next(),
        });
    }
    Ok(scans)
}

struct Stages<'a> {
    folder: &'a ScanFolder,
    grid: &'a FinerGrid,
    projected: &'a Projected,
}

impl Stages<'_> {
    /// The first captures of a stage, and what was read; nothing where the grid was not recorded.
    fn read(
        &self,
        stage: Stage,
        calibration: Option<&RigCalibration>,
        settings: &PipelineSettings,
        known: KnownPlaces,
    ) -> Result<(Captures, Option<StageReading>), ProcessError> {
        let mut captures = self.folder.finer_captures(self.grid, stage)?;
        if captures.prmvs.is_empty() {
            return Ok((captures, None));
        }
        let reading = read_finer(&captures, self.projected, calibration, settings, known)
            .map_err(|source| ProcessError::Pipeline { stage, source })?;
        captures.keep_first();
        Ok((captures, Some(reading)))
    }
}
