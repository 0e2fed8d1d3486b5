//! The pictures of the examination: lines in one direction only, white on black.

use shared::{
    pattern::{Axis, Grid, MAX_LINES, PatternError, RasterSize, Rgb},
    protocol::View,
    sequence::Symbol,
};

/// Bars across an axis, as wide as the dark between them: enough for thousands of edge pixels.
const BARS: usize = 16;

/// Wide white bars, half of the picture's light.
pub(super) fn bars(axis: Axis, raster: RasterSize) -> Result<View, PatternError> {
    let width_px = raster.along(axis) / (2 * BARS as u32);
    lines(axis, BARS, width_px.max(1))
}

/// Distance from one bar to the next, in projector pixels.
pub(super) fn bar_distance_px(axis: Axis, raster: RasterSize) -> f64 {
    f64::from(raster.along(axis)) / BARS as f64
}

/// Lines that are `width_px` wide, as many as make half of the picture white, or as many as can be shown; gives how
/// much of the picture they cover too.
pub(super) fn fine_lines(
    axis: Axis,
    raster: RasterSize,
    width_px: u32,
) -> Result<(View, f64), PatternError> {
    let length = raster.along(axis);
    // the narrowest lines set the number, so that wider ones cover as much
    let narrowest = (length as usize / 2).clamp(1, MAX_LINES);
    let count = (narrowest / width_px.max(1) as usize).max(1);
    let share = count as f64 * f64::from(width_px) / f64::from(length.max(1));
    Ok((lines(axis, count, width_px)?, share))
}

/// White lines in one direction; the other direction has a single black one, which the field hides.
fn lines(axis: Axis, count: usize, width_px: u32) -> Result<View, PatternError> {
    let (across, along) = (vec![0; count], vec![1]);
    let (rows, columns, widths) = match axis {
        Axis::Row => (across, along, (width_px, 1)),
        Axis::Column => (along, across, (1, width_px)),
    };
    let symbols = |numbers: Vec<u8>| numbers.into_iter().map(Symbol).collect();
    let colours = [Rgb::WHITE, Rgb::BLACK];
    let grid = Grid::explicit(symbols(rows), symbols(columns), widths, &colours)?;
    Ok(View::Grid(grid))
}
