//! Reads the finer grids of a scan, coarse before fine, each beside what the coarser ones gave.

use shared::stage::Stage;

use crate::{
    pipeline::{
        Method, PipelineSettings, Projected, StageReading,
        densify::KnownPlaces,
        result::{FinerScan, ScanResult},
    },
    process::{ProcessError, StageReader, compare},
};

/// The finer grids of the scan whose base grid was read; none with the thesis's method, which decodes a grid by itself.
///
/// # Errors
/// What is wrong with the folder or its pictures.
pub(crate) fn read_finer_grids(
    reader: &StageReader<'_>,
    base: &ScanResult,
) -> Result<Vec<FinerScan>, ProcessError> {
    if reader.settings.method != Method::Likelihood {
        return Ok(Vec::new());
    }
    let settings = PipelineSettings {
        pictures: false, // those of the base grid show the method
        ..*reader.settings
    };
    let mut known = Stage::BOTH.map(|stage| places(base.stage(stage), &reader.projected));
    let mut scans = Vec::new();
    for grid in reader.folder.finer()? {
        let finer = StageReader {
            projected: reader.folder.projected_finer(&grid),
            settings: &settings,
            ..*reader
        };
        let read = |stage, known: &KnownPlaces| finer.read_finer(&grid, stage, known.clone());
        let before = read(Stage::Background, &known[0])?;
        let after = read(Stage::Object, &known[1])?;
        let (result, _) = compare([before, after], &finer, base.depth_per_px);
        for (known, stage) in known.iter_mut().zip(Stage::BOTH) {
            let more = places(result.stage(stage), &finer.projected);
            *known = std::mem::take(known).with(more);
        }
        scans.push(FinerScan {
            pattern: grid.pattern,
            result,
        });
    }
    Ok(scans)
}

fn places(reading: Option<&StageReading>, projected: &Projected) -> KnownPlaces {
    let grid = reading.map(|reading| KnownPlaces::of(&reading.grid, projected));
    grid.unwrap_or_default()
}
