//! The middles of the grid's lines, to a fraction of a pixel, followed from picture row to picture row.
//!
//! Takes the gain image, gives tracks of two families: columns (steep in the picture) and rows (flat). One
//! directional pass per family: the gain is averaged along the lines and differentiated across them with a
//! spline as wide as a line; the derivative falls through zero on the middle of a line, whatever
//! the blur, as long as the profile is symmetric (J. Canny 1986; C. Steger 1998 for the bias). Zero
//! crossings are linked into tracks by predicting along the local slope. Lines tilted by more than about
//! 45 degrees are found by the other family's pass; a texture of stripes that W does not explain is
//! followed as if it were a line, quietly.

mod along;
mod boxes;
mod join;
mod limit;
mod ridge_rows;
mod ridges;
mod scale;
mod tracks;

use serde::{Deserialize, Serialize};
use shared::pattern::Axis;

pub(crate) use limit::{FULL_STRENGTH, RidgeLimit};
pub use ridges::Ridge;
pub use tracks::Track;

use super::{
    gain::{GainFilter, GainImage},
    line_light::LineLight,
    spare::Spare,
};
use join::{JoinBuffers, Reach, join};
use ridge_rows::RidgeRows;
use ridges::{Search, find_ridges};
use tracks::Followed;

/// How lines are found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LineSettings {
    /// Narrowest line looked for, in camera pixels, 1.6 to 64.
    pub narrowest_px: f64,
    /// Widest line looked for, in camera pixels, 2 to 64.
    pub widest_px: f64,
    /// Largest step from sample to sample along the lines, in pixels of the gain image, 1 to 4: 2 saves a third of
    /// the time and gives half as many points.
    pub step_px: usize,
    /// Side of the largest squares of camera pixels that are averaged where lines are wide, 1 to 8.
    pub coarsest_px: usize,
    /// A ridge must rise above the noise by this many standard deviations, 1 to 20.
    pub noise_sigma: f64,
    /// A ridge must have this share of the strength of the lines around it, 0 to 1.
    pub share_of_local: f64,
    /// A ridge must have this share of a full line's strength in the gain image, 0 to 1.
    pub share_of_full: f64,
    /// Largest sideways miss of the predicted position in the next picture row, in camera pixels, 0.5 to 5.
    pub gate_px: f64,
    /// Longest gap that is bridged outside of crossings, in camera pixels, 0 to 50.
    pub bridge_px: f64,
    /// Side of the tiles of local strength, in camera pixels, 8 to 512.
    pub tile_px: usize,
}

impl Default for LineSettings {
    fn default() -> Self {
        Self {
            narrowest_px: 1.6,
            widest_px: 24.0,
            step_px: 1,
            coarsest_px: 4,
            noise_sigma: 5.0,
            share_of_local: 0.3,
            share_of_full: 0.12,
            gate_px: 1.5,
            bridge_px: 6.0,
            tile_px: 64,
        }
    }
}

/// The lines of both families.
#[derive(Debug, Clone, Default)]
pub struct Lines {
    /// Steep lines: across is x, along is y.
    pub columns: Family,
    /// Flat lines: across is y, along is x.
    pub rows: Family,
}

impl Lines {
    /// The family of one direction.
    #[must_use]
    pub fn family(&self, axis: Axis) -> &Family {
        match axis {
            Axis::Row => &self.rows,
            Axis::Column => &self.columns,
        }
    }
}

/// The lines of one direction.
#[derive(Debug, Clone, Default)]
pub struct Family {
    /// The tracks in the order of their first point (along, then across).
    pub tracks: Vec<Track>,
    /// Typical width of a line across its direction, in camera pixels, as the scale search sees it.
    pub width_px: f64,
}

/// How the picture is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampling {
    /// Side of the squares of camera pixels that the gain image is made of.
    pub bin: usize,
    /// From sample to sample along the lines, in pixels of the gain image.
    pub step: usize,
}

impl Sampling {
    /// From sample to sample along the lines, in camera pixels.
    #[must_use]
    pub fn spacing_px(self) -> usize {
        self.bin * self.step
    }
}

/// How wide the lines are, and the sampling that suits them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineScale {
    /// Typical widths of rows and columns across their direction, in camera pixels.
    pub widths_px: [f64; 2],
    /// How finely the picture must be looked at.
    pub sampling: Sampling,
}

/// What finding lines keeps between frames.
#[derive(Debug, Default)]
pub struct LineBuffers {
    ridges: RidgeRows,
    scale: scale::ScaleBuffers,
    followed: Followed,
    join: JoinBuffers,
    /// Of steep and of flat lines.
    spare: [Spare<Track>; 2],
}

/// Finds out how wide the lines are. `pitch_widths` are the pattern's pitches of rows and columns in widths of
/// their lines: dense grids must be looked at finely.
pub fn find_scale(
    light: (&LineLight<'_>, &GainFilter),
    pitch_widths: [f64; 2],
    settings: &LineSettings,
    buffers: &mut LineBuffers,
) -> LineScale {
    scale::find_scale(light, pitch_widths, settings, &mut buffers.scale)
}

/// Finds the lines of both families in a gain image of the scale's resolution; `shrink` is its pull towards 0.
pub fn find_lines(
    (image, shrink): (&GainImage, f64),
    scale: &LineScale,
    settings: &LineSettings,
    (buffers, lines): (&mut LineBuffers, &mut Lines),
) {
    let LineBuffers {
        ridges,
        followed,
        join: join_buffers,
        spare: [spare_columns, spare_rows],
        ..
    } = buffers;
    let [row_px, column_px] = scale.widths_px;
    let columns = (&mut lines.columns, spare_columns);
    let rows = (&mut lines.rows, spare_rows);
    for (family, (found, spare), [width_px, other_width_px]) in [
        (Axis::Column, columns, [column_px, row_px]),
        (Axis::Row, rows, [row_px, column_px]),
    ] {
        let search = Search {
            family,
            width_px,
            shrink: shrink as f32,
            settings,
        };
        find_ridges(ridges, image, &search, &scale.sampling);
        let spacing_px = scale.sampling.spacing_px() as f64;
        let reach = Reach {
            gap_px: settings.bridge_px + 1.5 * other_width_px,
            disturbed_px: 0.5 * other_width_px + 2.0,
            gate_px: settings.gate_px.clamp(0.5, 5.0),
        };
        followed.follow(ridges, spacing_px, width_px, &reach);
        found.width_px = width_px;
        join(followed, &reach, join_buffers, (&mut found.tracks, spare));
    }
}
