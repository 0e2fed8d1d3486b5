//! Where each picture row crosses the middle of a steep line.

use rayon::prelude::*;

use super::{LineSettings, half_kernel, smoothed_row};
use crate::pipeline::gain::GainImage;

/// A point of one picture row on the middle of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ridge {
    /// Position across the line, edge coordinates.
    pub across: f32,
    /// How sharply the gain bends there: -s^2 g'', about 0.46 on a full line.
    pub strength: f32,
    /// Strong enough to begin a track; a weaker one only continues one.
    pub strong: bool,
}

/// The derivative's standard deviation in line widths: half a width answers a line best, a little more
/// averages over the sensor's colour mosaic.
const SIGMA_PER_WIDTH: f64 = 0.65;
/// Strength of a line of gain 1 at that scale: (w/s) / sqrt(2 pi) x exp(-(w/s)^2 / 8).
const FULL_STRENGTH: f32 = 0.456;
/// Demosaicing and JPEG correlate neighbouring pixels: their noise survives smoothing about so many times
/// better than independent noise would.
const CORRELATED: f32 = 2.0;
/// A ridge that continues a track may have this share of the strength of one that begins it.
const WEAK_SHARE: f32 = 0.5;

/// The ridges of each picture row, sorted by position.
pub(super) fn find_ridges(
    image: &GainImage,
    shrink: f32,
    width_px: f64,
    settings: &LineSettings,
) -> Vec<Vec<Ridge>> {
    let (width, height) = (image.gain.width(), image.gain.height());
    if width < 3 {
        return vec![Vec::new(); height];
    }
    let smooth = settings.smooth_along_px.clamp(0.5, 5.0);
    let sigma = (SIGMA_PER_WIDTH * width_px).max(0.8);
    let pass = Pass {
        image,
        shrink,
        along: half_kernel(smooth, false),
        across: half_kernel(sigma, true),
        sigma: sigma as f32,
        noise: CORRELATED * settings.noise_sigma as f32 * kernel_norm(sigma, smooth),
        least: settings.share_of_full as f32 * FULL_STRENGTH,
    };
    let mut ridges: Vec<Vec<Ridge>> = (0..height)
        .into_par_iter()
        .map_init(Default::default, |buffers, y| pass.row(y, buffers))
        .collect();
    compare_with_neighbourhood(&mut ridges, width, settings);
    ridges
}

/// Standard deviation of the strength for independent noise of 1 per pixel.
fn kernel_norm(sigma: f64, smooth: f64) -> f32 {
    let root_pi = std::f64::consts::PI.sqrt();
    let across = (3.0 / (8.0 * root_pi * sigma)).sqrt();
    let along = (1.0 / (2.0 * root_pi * smooth)).sqrt();
    (across * along) as f32
}

struct Pass<'a> {
    image: &'a GainImage,
    shrink: f32,
    along: Vec<f32>,
    across: Vec<f32>,
    sigma: f32,
    noise: f32,
    least: f32,
}

impl Pass<'_> {
    fn row(&self, y: usize, (smooth, slope): &mut (Vec<f32>, Vec<f32>)) -> Vec<Ridge> {
        let width = self.image.gain.width();
        let pad = self.across.len();
        smoothed_row(&self.image.gain, y, &self.along, pad, smooth);
        slope.clear();
        slope.resize(width, 0.0);
        for (k, &weight) in self.across.iter().enumerate().skip(1) {
            let (left, right) = (
                &smooth[pad - k..pad - k + width],
                &smooth[pad + k..pad + k + width],
            );
            for ((v, &a), &b) in slope.iter_mut().zip(left).zip(right) {
                *v += weight * (b - a);
            }
        }
        let power = self.image.power.row(y);
        let mut found = Vec::new();
        for x in 0..width - 1 {
            let (before, after) = (slope[x], slope[x + 1]);
            if before > 0.0 && after <= 0.0 {
                let strength = self.sigma * self.sigma * (before - after);
                let p = 0.5 * (power[x] + power[x + 1]);
                let noise = self.noise * p.sqrt() / (p + self.shrink);
                if strength > WEAK_SHARE * self.least.max(noise) {
                    found.push(Ridge {
                        across: x as f32 + 0.5 + before / (before - after),
                        strength,
                        strong: strength > self.least.max(noise),
                    });
                }
            }
        }
        found
    }
}

/// Keeps ridges that are not faint beside the lines around them.
fn compare_with_neighbourhood(ridges: &mut [Vec<Ridge>], width: usize, settings: &LineSettings) {
    let side = settings.tile_px.clamp(8, 512);
    let columns = width.div_ceil(side);
    for band in ridges.chunks_mut(side) {
        let mut strengths = vec![Vec::new(); columns];
        for ridge in band.iter().flatten().filter(|ridge| ridge.strong) {
            strengths[(ridge.across as usize / side).min(columns - 1)].push(ridge.strength);
        }
        let typical: Vec<f32> = strengths
            .iter_mut()
            .map(|tile| {
                tile.sort_by(f32::total_cmp);
                tile.get(tile.len() * 3 / 4).copied().unwrap_or(0.0)
            })
            .collect();
        for row in band {
            row.retain_mut(|ridge| {
                let tile = (ridge.across as usize / side).min(columns - 1);
                let limit = settings.share_of_local as f32 * typical[tile];
                ridge.strong &= ridge.strength > limit;
                ridge.strength > WEAK_SHARE * limit
            });
        }
    }
}
