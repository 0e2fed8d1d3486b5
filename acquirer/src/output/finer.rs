//! The results of finer grids: `DIR/results/finer-N/` beside those of the base grid, and their figures.
//!
//! Each folder holds `vertices.csv`, `lines.csv` and `shifts.csv` in the form of the base grid's, and with a
//! calibration `points.csv`. Folders of an earlier run that this one does not make are removed.

use std::{fs, path::Path};

use serde::Serialize;
use shared::{pattern::Axis, stage::Stage};

use super::{
    OutputError, make_dir,
    shift_table::{ShiftRow, write_shift_table},
    summary::StageFigures,
    tables,
};
use crate::{
    pipeline::{
        result::{FinerScan, ScanResult},
        surface::SurfacePoint,
    },
    scan::{FINER_PREFIX, finer_folders, write_whole},
};

/// What was read from one finer grid.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FinerFigures {
    /// Rows and columns of the grid.
    pub lines: [usize; 2],
    /// Width of its rows and columns, projector px.
    pub width_px: [u32; 2],
    /// What was read before the object was put in, if that was recorded.
    pub background: Option<StageFigures>,
    /// What was read with the object, if that was recorded.
    pub object: Option<StageFigures>,
    /// Points of the object's surface that this grid adds.
    pub points: usize,
}

impl FinerFigures {
    pub(super) fn of(scan: &FinerScan) -> Self {
        let coded = &scan.pattern.coded;
        let lines = Axis::BOTH.map(|axis| coded.lines(axis));
        let figures = |stage: Stage| {
            let along = &scan.result.lines[usize::from(stage == Stage::Object)];
            let reading = scan.result.stage(stage)?;
            Some(StageFigures::of(reading, along, lines[0] * lines[1]))
        };
        Self {
            lines,
            width_px: Axis::BOTH.map(|axis| coded.width_px(axis)),
            background: figures(Stage::Background),
            object: figures(Stage::Object),
            points: tables::finite_points(&scan.result.surface).count(),
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

/// A finer grid's name in files: `finer-` and the larger number of its lines.
pub(super) fn name(scan: &FinerScan) -> String {
    format!("{FINER_PREFIX}{}", scan.most_lines())
}

/// Writes the tables of all finer grids, and removes those of earlier runs.
pub(super) fn write_finer(
    dir: &Path,
    result: &ScanResult,
    calibrated: bool,
) -> Result<(), OutputError> {
    remove_folders(dir)?;
    for scan in &result.finer {
        let folder = dir.join(name(scan));
        make_dir(&folder)?;
        let file = |name: &str| folder.join(name);
        let found = &scan.result;
        write_whole(
            &file("vertices.csv"),
            tables::vertex_table(found).as_bytes(),
        )?;
        write_whole(&file("lines.csv"), tables::line_table(found).as_bytes())?;
        let rows: Vec<ShiftRow> = found.shifts.iter().map(ShiftRow::from).collect();
        write_shift_table(&file("shifts.csv"), &rows)?;
        if calibrated {
            write_whole(
                &file("points.csv"),
                tables::point_table(&found.surface).as_bytes(),
            )?;
        }
    }
    Ok(())
}

/// The points of a stage's surface by the grid that they were read from: its larger number of lines.
pub(super) fn clouds(
    result: &ScanResult,
    base_lines: usize,
    stage: Stage,
) -> Vec<(usize, &[SurfacePoint])> {
    let base = std::iter::once((base_lines, surface(result, stage)));
    let finer = result.finer.iter();
    base.chain(finer.map(|scan| (scan.most_lines(), surface(&scan.result, stage))))
        .collect()
}

fn surface(result: &ScanResult, stage: Stage) -> &[SurfacePoint] {
    match stage {
        Stage::Background => &result.background_surface,
        Stage::Object => &result.surface,
    }
}

fn remove_folders(dir: &Path) -> Result<(), OutputError> {
    for path in finer_folders(dir)? {
        fs::remove_dir_all(&path).map_err(|source| OutputError::Outdated { path, source })?;
    }
    Ok(())
}
