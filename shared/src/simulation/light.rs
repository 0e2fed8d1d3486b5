//! The light that leaves the projector for a picture: drive values to linear light, black level, blur.
//!
//! Takes a raster of bytes, gives linear light as a function of position on the raster (px, edge coordinates).
//! Each pixel is a square of even light, smeared by the lens (a Gaussian) and, where the three colours do not
//! converge, displaced per colour. Everything is symmetric about the pixel, so edges stay where they are.

use std::sync::Arc;

use nalgebra::{Vector2, Vector4};
use rayon::prelude::*;

use super::scene::ProjectorTable;
use crate::pattern::Raster;

/// Dark texels around the raster, so that sampling beside it needs no question.
const MARGIN: usize = 2;

/// What a projector picture gives, light per place; cheap to clone.
#[derive(Debug, Clone)]
pub struct ProjectedLight {
    /// Red, green, blue and nothing, row by row, with the margin; 1 is full white.
    texels: Arc<Vec<[f32; 4]>>,
    /// Columns and rows with the margin.
    columns: usize,
    rows: usize,
    /// Texels per projector pixel.
    scale: [f32; 2],
}

impl ProjectedLight {
    /// The light of a picture on a projector.
    pub(super) fn new(projector: &ProjectorTable, picture: &Raster) -> Self {
        let size = picture.size();
        let (width, height) = (size.width as usize, size.height as usize);
        let (columns, rows) = (width + 2 * MARGIN, height + 2 * MARGIN);
        let scale = Vector2::new(
            f64::from(size.width) / f64::from(projector.width),
            f64::from(size.height) / f64::from(projector.height),
        );
        let curve = drive_curve(projector);
        let mut texels = vec![[0.0; 4]; columns * rows];
        let lines = texels
            .par_chunks_mut(columns)
            .skip(MARGIN)
            .zip(picture.bytes().par_chunks(3 * width.max(1)));
        lines.for_each(|(texels, bytes)| {
            for (texel, drive) in texels[MARGIN..].iter_mut().zip(bytes.chunks_exact(3)) {
                *texel = [
                    curve[drive[0] as usize],
                    curve[drive[1] as usize],
                    curve[drive[2] as usize],
                    0.0,
                ];
            }
        });
        let kernels = |axis: usize| {
            let sigma = projector.blur_px * scale[axis];
            projector
                .convergence_px
                .map(|shift| kernel(sigma, shift[axis] * scale[axis]))
        };
        let along = smear(&texels, columns, &kernels(0), Direction::Along);
        let across = smear(&along, columns, &kernels(1), Direction::Across);
        let scale = [scale.x as f32, scale.y as f32];
        Self {
            texels: Arc::new(across),
            columns,
            rows,
            scale,
        }
    }

    /// The light at a position on the raster, px; red, green, blue, 1 is full white.
    #[inline]
    pub(super) fn at(&self, x: f32, y: f32) -> Vector4<f32> {
        let offset = MARGIN as f32 - 0.5;
        let x = (x * self.scale[0] + offset).clamp(0.0, (self.columns - 2) as f32);
        let y = (y * self.scale[1] + offset).clamp(0.0, (self.rows - 2) as f32);
        let (left, top) = (x as usize, y as usize);
        let (u, v) = (x - left as f32, y - top as f32);
        let upper = top * self.columns + left;
        let lower = upper + self.columns;
        let texel = |k: usize| Vector4::from(self.texels[k]);
        let above = texel(upper) * (1.0 - u) + texel(upper + 1) * u;
        let below = texel(lower) * (1.0 - u) + texel(lower + 1) * u;
        above * (1.0 - v) + below * v
    }
}

/// The light of each drive value, 0 to 1: the black level, and above it a power of the drive.
fn drive_curve(projector: &ProjectorTable) -> [f32; 256] {
    let black = projector.black_level;
    std::array::from_fn(|drive| {
        let share = (drive as f64 / 255.0).powf(projector.gamma);
        (black + (1.0 - black) * share) as f32
    })
}

/// A blur of one colour along one axis: weights for the texels from `first` on.
struct Kernel {
    first: i64,
    weights: Vec<f32>,
}

/// A Gaussian of deviation `sigma`, displaced by `shift`, both in texels; its mean is exactly the shift.
fn kernel(sigma: f64, shift: f64) -> Kernel {
    let reach = (3.0 * sigma).ceil() as i64;
    let bell = |k: i64| {
        if k == 0 {
            1.0
        } else {
            (-0.5 * (k as f64 / sigma).powi(2)).exp()
        }
    };
    let sum: f64 = (-reach..=reach).map(bell).sum();
    let whole = shift.floor();
    let part = shift - whole;
    let inside = |k: i64| if k.abs() <= reach { bell(k) / sum } else { 0.0 };
    // the light comes from where the displacement took it away
    let weights: Vec<f32> = (-reach - 1..=reach)
        .map(|k| (inside(k) * (1.0 - part) + inside(k + 1) * part) as f32)
        .collect();
    Kernel {
        first: -reach - 1 - whole as i64,
        weights,
    }
}

#[derive(Clone, Copy)]
enum Direction {
    Along,
    Across,
}

fn smear(
    texels: &[[f32; 4]],
    columns: usize,
    kernels: &[Kernel; 3],
    along: Direction,
) -> Vec<[f32; 4]> {
    let rows = texels.len() / columns.max(1);
    let mut out = vec![[0.0; 4]; texels.len()];
    out.par_chunks_mut(columns.max(1))
        .enumerate()
        .for_each(|(y, line)| {
            for (channel, kernel) in kernels.iter().enumerate() {
                for (offset, weight) in (kernel.first..)
                    .zip(&kernel.weights)
                    .filter(|(_, w)| **w > 0.0)
                {
                    let (source_row, shift) = match along {
                        Direction::Along => (y as i64, offset),
                        Direction::Across => (y as i64 + offset, 0),
                    };
                    if !(0..rows as i64).contains(&source_row) {
                        continue;
                    }
                    let source = &texels[source_row as usize * columns..][..columns];
                    add(line, source, (channel, *weight), shift);
                }
            }
        });
    out
}

/// Adds one channel of a source line, displaced by `shift` texels, with a weight.
fn add(line: &mut [[f32; 4]], source: &[[f32; 4]], (channel, weight): (usize, f32), shift: i64) {
    let skip_line = usize::try_from(-shift).unwrap_or(0).min(line.len());
    let skip_source = usize::try_from(shift).unwrap_or(0).min(source.len());
    for (to, from) in line[skip_line..].iter_mut().zip(&source[skip_source..]) {
        to[channel] += weight * from[channel];
    }
}
