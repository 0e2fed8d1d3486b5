//! The light that leaves the projector for a picture: drive values to linear light, black level, blur.
//!
//! Takes a raster of bytes, gives linear light as a function of position on the raster (px, edge coordinates).
//! Each pixel is a square of even light, smeared by the lens (a Gaussian) and, where the three colours do not
//! converge, displaced per colour. Everything is symmetric about the pixel, so edges stay where they are.

use std::sync::Arc;

use nalgebra::Vector4;
use rayon::prelude::*;

use super::scene::ProjectorTable;
use crate::{
    geometry::ProjectorPixel,
    pattern::{Raster, RasterSize},
};

/// Dark texels around the raster, so that sampling beside it needs no question.
const MARGIN: usize = 2;

/// What a projector picture gives, light per place; cheap to clone.
#[derive(Debug, Clone)]
pub struct ProjectedLight {
    /// Red, green, blue and nothing, row by row, with the margin; 1 is full white.
    texels: Arc<Vec<[f32; 4]>>,
    /// Texels in a row.
    columns: usize,
}

/// A position on the raster, worked out for [`ProjectedLight::at`].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Place {
    /// The upper left one of the four texels around the position.
    texel: u32,
    /// How far the position is towards the right and the lower ones, in 65536ths.
    part: [u16; 2],
}

impl Place {
    /// The place of a position (px) on a projector's raster, or at its nearest border.
    pub(super) fn new(size: RasterSize, at: ProjectorPixel) -> Self {
        let split = |v: f64, length: u32| {
            let texel =
                (v + MARGIN as f64 - 0.5).clamp(0.0, f64::from(length) + 2.0 * MARGIN as f64 - 2.0);
            (texel as u32, (texel.fract() * 65536.0) as u16)
        };
        let ((left, u), (top, v)) = (split(at.x, size.width), split(at.y, size.height));
        Self {
            texel: top * (size.width + 2 * MARGIN as u32) + left,
            part: [u, v],
        }
    }
}

impl ProjectedLight {
    /// The light of a picture on a projector.
    pub(super) fn new(projector: &ProjectorTable, picture: &Raster) -> Self {
        let native = RasterSize {
            width: projector.width,
            height: projector.height,
        };
        let columns = native.width as usize + 2 * MARGIN;
        let lit = lit_texels(projector, picture);
        let texels = if picture.size() == native {
            lit
        } else {
            stretch(&lit, picture.size(), native)
        };
        let blur = |axis: usize| {
            kernel(
                projector.blur_px,
                projector.convergence_px.map(|shift| shift[axis]),
            )
        };
        let along = smear(&texels, columns, &blur(0), Direction::Along);
        let across = smear(&along, columns, &blur(1), Direction::Across);
        Self {
            texels: Arc::new(across),
            columns,
        }
    }

    /// Whether it is a clone of another one.
    pub(super) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.texels, &other.texels)
    }

    /// The light at a place: red, green, blue and nothing, 1 is full white; the mean of four texels by nearness.
    #[inline]
    pub(super) fn at(&self, place: Place) -> Vector4<f32> {
        let [u, v] = place.part.map(|part| f32::from(part) * (1.0 / 65536.0));
        let upper = place.texel as usize;
        let lower = upper + self.columns;
        let (Some([a, b]), Some([c, d])) = (self.pair(upper), self.pair(lower)) else {
            return Vector4::zeros();
        };
        let mix =
            |a: &[f32; 4], b: &[f32; 4]| Vector4::from(*a) * (1.0 - u) + Vector4::from(*b) * u;
        mix(a, b) * (1.0 - v) + mix(c, d) * v
    }

    #[inline]
    fn pair(&self, first: usize) -> Option<&[[f32; 4]; 2]> {
        self.texels.get(first..)?.first_chunk()
    }
}

/// The light of each pixel of a picture, with the margin.
fn lit_texels(projector: &ProjectorTable, picture: &Raster) -> Vec<[f32; 4]> {
    let width = picture.size().width as usize;
    let columns = width + 2 * MARGIN;
    let curve = drive_curve(projector);
    let mut texels = vec![[0.0; 4]; columns * (picture.size().height as usize + 2 * MARGIN)];
    let lines = texels.par_chunks_mut(columns).skip(MARGIN);
    lines
        .zip(picture.bytes().par_chunks(3 * width.max(1)))
        .for_each(|(texels, bytes)| {
            for (texel, drive) in texels[MARGIN..].iter_mut().zip(bytes.chunks_exact(3)) {
                let [r, g, b] = [0, 1, 2].map(|channel| curve[drive[channel] as usize]);
                *texel = [r, g, b, 0.0];
            }
        });
    texels
}

/// The texels of a picture of one size on a raster of another: each gets the mean of what it covers.
fn stretch(texels: &[[f32; 4]], from: RasterSize, to: RasterSize) -> Vec<[f32; 4]> {
    let columns = from.width as usize + 2 * MARGIN;
    let (x_shares, y_shares) = (shares(from.width, to.width), shares(from.height, to.height));
    let wide = to.width as usize + 2 * MARGIN;
    let mut out = vec![[0.0; 4]; wide * (to.height as usize + 2 * MARGIN)];
    let lines = out
        .par_chunks_mut(wide)
        .skip(MARGIN)
        .zip(y_shares.par_iter());
    lines.for_each(|(line, rows)| {
        for (texel, columns_covered) in line[MARGIN..].iter_mut().zip(&x_shares) {
            let mut sum = Vector4::zeros();
            for (row, height) in rows {
                for (column, width) in columns_covered {
                    let source = texels[(row + MARGIN) * columns + column + MARGIN];
                    sum += Vector4::from(source) * (height * width);
                }
            }
            *texel = sum.into();
        }
    });
    out
}

/// For each of `to` pixels: which of `from` pixels over the same length it covers, and their shares of it.
fn shares(from: u32, to: u32) -> Vec<Vec<(usize, f32)>> {
    let step = f64::from(from) / f64::from(to.max(1));
    let covered = |k: u32| {
        let (low, high) = (f64::from(k) * step, f64::from(k + 1) * step);
        let last = (high.ceil() as u32).min(from);
        (low as u32..last)
            .map(|pixel| {
                let overlap = high.min(f64::from(pixel) + 1.0) - low.max(f64::from(pixel));
                (pixel as usize, (overlap / step) as f32)
            })
            .collect()
    };
    (0..to).map(covered).collect()
}

/// The light of each drive value, 0 to 1: the black level, and above it a power of the drive.
fn drive_curve(projector: &ProjectorTable) -> [f32; 256] {
    let black = projector.black_level;
    std::array::from_fn(|drive| {
        let share = (drive as f64 / 255.0).powf(projector.gamma);
        (black + (1.0 - black) * share) as f32
    })
}

/// A blur along one axis: how much of each colour comes from so many texels further on.
type Kernel = Vec<(i64, Vector4<f32>)>;

/// A Gaussian of deviation `sigma` texels, displaced per colour by `shifts` texels; the mean of what each colour
/// gets is displaced by exactly that.
fn kernel(sigma: f64, shifts: [f64; 3]) -> Kernel {
    let reach = (3.0 * sigma).ceil() as i64;
    let bell = |k: i64| {
        if k == 0 {
            1.0
        } else {
            (-0.5 * (k as f64 / sigma).powi(2)).exp()
        }
    };
    let sum: f64 = (-reach..=reach).map(bell).sum();
    let weight = |k: i64| if k.abs() <= reach { bell(k) / sum } else { 0.0 };
    let weights = |offset: i64| {
        let [r, g, b] = shifts.map(|shift| {
            // light that is displaced by `shift` comes from as far before
            let whole = shift.floor();
            let part = shift - whole;
            let at = offset + whole as i64;
            (weight(at) * (1.0 - part) + weight(at + 1) * part) as f32
        });
        Vector4::new(r, g, b, 0.0)
    };
    let furthest = reach + 1 + shifts.iter().fold(0.0, |m: f64, s| m.max(s.abs())).ceil() as i64;
    let all = (-furthest..=furthest).map(|offset| (offset, weights(offset)));
    all.filter(|(_, weights)| weights.max() > 0.0).collect()
}

#[derive(Clone, Copy)]
enum Direction {
    Along,
    Across,
}

fn smear(
    texels: &[[f32; 4]],
    columns: usize,
    kernel: &Kernel,
    direction: Direction,
) -> Vec<[f32; 4]> {
    let rows = texels.len() / columns;
    let mut out = vec![[0.0; 4]; texels.len()];
    out.par_chunks_mut(columns)
        .enumerate()
        .for_each(|(y, line)| {
            for (offset, weights) in kernel {
                let (source_row, shift) = match direction {
                    Direction::Along => (Some(y), *offset),
                    Direction::Across => (y.checked_add_signed(*offset as isize), 0),
                };
                if let Some(source_row) = source_row.filter(|row| *row < rows) {
                    add(
                        line,
                        &texels[source_row * columns..][..columns],
                        weights,
                        shift,
                    );
                }
            }
        });
    out
}

/// Adds a source line, displaced by `shift` texels, with a weight per colour.
fn add(line: &mut [[f32; 4]], source: &[[f32; 4]], weights: &Vector4<f32>, shift: i64) {
    let skip_line = usize::try_from(-shift).unwrap_or(0).min(line.len());
    let skip_source = usize::try_from(shift).unwrap_or(0).min(source.len());
    for (to, from) in line[skip_line..].iter_mut().zip(&source[skip_source..]) {
        for (to, (from, weight)) in to.iter_mut().zip(from.iter().zip(weights.iter())) {
            *to += weight * from;
        }
    }
}
