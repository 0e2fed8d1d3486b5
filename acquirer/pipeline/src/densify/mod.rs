//! A coarse grid first, finer ones where it reads.
//!
//! Takes the captures of a finer grid and what coarser grids of the same stage gave; gives its reading. The coarse
//! crossings tell where on the projector the light of a place near them comes from, to a fraction of their pitch
//! (`places`); in the decoder that is evidence beside the colours, so that a patch of the fine grid too small for a
//! window of its code gets its place, and one that contradicts the coarse grid is dropped. Where nothing coarse was
//! read the fine grid must stand for itself. A coarse label that is wrong makes fine ones beside it wrong quietly.

mod places;

use shared::{
    geometry::RigCalibration,
    pattern::{Axis, GridSettings, PatternError, RasterSize},
};

use super::{Captures, PipelineError, PipelineSettings, Projected, StageReading, stage_reader};

pub use places::{KnownPlace, KnownPlaces};

/// Widest line as a share of the pitch: dark must be left between fine lines.
const WIDEST_SHARE: f64 = 0.35;

/// The grid with so many rows and columns, no fewer than the base grid has, in its colours; its lines are as wide as
/// the base grid's, or narrower where they would fill the pitch.
///
/// # Errors
/// A line count other than 15, 31, 63, 127 or 255.
pub fn finer_pattern(
    base: &GridSettings,
    lines: usize,
    raster: RasterSize,
) -> Result<GridSettings, PatternError> {
    let [rows, columns] = Axis::BOTH.map(|axis| lines.max(base.coded.lines(axis)));
    let finer = base.with_lines(rows, columns)?;
    let [row_px, column_px] = Axis::BOTH.map(|axis| {
        let widest = WIDEST_SHARE * finer.coded.pitch_px(axis, raster);
        base.coded.width_px(axis).min(widest as u32).max(1)
    });
    finer.with_widths(row_px, column_px)
}

/// Reads a finer grid in the captures of one stage: black and white of the stage, coded and unary of the grid. Of black
/// and of white only the first capture stays.
///
/// # Errors
/// As [`super::read_stage`].
pub fn read_finer(
    captures: &mut Captures,
    projected: &Projected,
    calibration: Option<&RigCalibration>,
    settings: &PipelineSettings,
    known: KnownPlaces,
) -> Result<StageReading, PipelineError> {
    let mut reader = stage_reader(captures, projected, calibration, settings)?;
    captures.black.truncate(1);
    captures.white.truncate(1);
    reader.expect_places(known);
    reader.read_grids(&captures.prmvs, &captures.unary)?;
    Ok(reader.into_reading())
}
