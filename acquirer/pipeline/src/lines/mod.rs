//! The middles of the grid's lines, to a fraction of a pixel, followed from picture row to picture row.
//!
//! Takes the gain image, gives tracks of two families: columns (steep in the picture) and rows (flat). One
//! directional pass per family: the gain is smoothed along the lines and differentiated across them with a
//! Gaussian as wide as half a line; the derivative falls through zero on the middle of a line, whatever
//! the blur, as long as the profile is symmetric (J. Canny 1986; C. Steger 1998 for the bias). Zero
//! crossings are linked into tracks by predicting along the local slope. Lines tilted by more than about
//! 45 degrees are found by the other family's pass; a texture of stripes that W does not explain is
//! followed as if it were a line, quietly.

mod join;
mod ridges;
mod scale;
mod tracks;

use serde::{Deserialize, Serialize};
use shared::pattern::Axis;

pub use ridges::Ridge;
use ridges::Ridges;
pub use tracks::Track;

use super::{
    convolve::{Pair, convolve, pad_ends},
    gain::GainImage,
    plane::Plane,
};

/// How lines are found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LineSettings {
    /// Narrowest line looked for, in camera pixels, 1.6 to 64: the derivative's Gaussian has half this width.
    pub narrowest_px: f64,
    /// Widest line looked for, in camera pixels, 2 to 64.
    pub widest_px: f64,
    /// Smoothing along the line, standard deviation in camera pixels, 0.5 to 5.
    pub smooth_along_px: f64,
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
            smooth_along_px: 1.0,
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

/// What finding lines keeps between frames.
#[derive(Debug, Default)]
pub struct LineBuffers {
    ridges: Ridges,
    scale: scale::ScaleBuffers,
}

/// Finds the lines of both families.
#[must_use]
pub fn find_lines(
    image: &GainImage,
    shrink: f64,
    settings: &LineSettings,
    buffers: &mut LineBuffers,
) -> Lines {
    let mut width = |family| scale::line_width(&image.gain, family, settings, &mut buffers.scale);
    let widths = [width(Axis::Row), width(Axis::Column)];
    let mut family = |family: Axis, width_px: f64, other_width_px: f64| {
        let ridges = &mut buffers.ridges;
        ridges.find(image, family, (shrink as f32, width_px), settings);
        let gap_px = settings.bridge_px + 1.5 * other_width_px;
        let pieces = tracks::follow(ridges, width_px, gap_px, settings);
        let disturbed_px = 0.5 * other_width_px + 2.0;
        Family {
            tracks: join::join(&pieces, gap_px, disturbed_px, settings.gate_px),
            width_px,
        }
    };
    Lines {
        columns: family(Axis::Column, widths[1], widths[0]),
        rows: family(Axis::Row, widths[0], widths[1]),
    }
}

/// A Gaussian, or its derivative, sampled out to three standard deviations: element k is at offset k from
/// the middle; the other half follows by symmetry.
fn half_kernel(sigma: f64, derivative: bool) -> Vec<f32> {
    let radius = (3.0 * sigma).ceil() as usize;
    let gauss = |k: usize| (-0.5 * (k as f64 / sigma).powi(2)).exp();
    let sum: f64 = gauss(0) + 2.0 * (1..=radius).map(gauss).sum::<f64>();
    (0..=radius)
        .map(|k| {
            let factor = if derivative {
                k as f64 / (sigma * sigma)
            } else {
                1.0
            };
            (factor * gauss(k) / sum) as f32
        })
        .collect()
}

/// The rows of a plane near `y`, smoothed along y into one row padded by `pad` border values.
#[inline(always)]
fn smoothed_row(plane: &Plane, y: usize, along: &[f32], pad: usize, out: &mut Vec<f32>) {
    let width = plane.width();
    out.resize(width + 2 * pad, 0.0);
    convolve(&mut out[pad..pad + width], along, Pair::Sum, |k| {
        (plane.row(y.saturating_sub(k)), plane.row(y + k))
    });
    pad_ends(out, pad);
}
