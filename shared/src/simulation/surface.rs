//! What a surface looks like: a colour or a pattern of colours, and how glossy it is.
//!
//! Patterns fill space, in the solid's own frame (mm), and the surface cuts through them; so they need no
//! unfolding and fit every shape. The picture alone lies flat on the solid's x and y.

use image::RgbImage;
use nalgebra::Vector3;

use super::random::Random;
use super::tone::linear_from_srgb;
use crate::pattern::Rgb;

/// Octaves of the noise, each twice as fine as the one before and 0.6 as strong.
const NOISE_OCTAVES: u32 = 4;

/// A surface.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    /// Albedo of the surface's own colour.
    pub(super) base: [f32; 3],
    /// What is painted on it.
    pub(super) paint: Paint,
    /// Share of light that is mirrored in a lobe, 0 to 1.
    pub(super) gloss: f64,
    /// How narrow that lobe is (Blinn's exponent).
    pub(super) gloss_exponent: f64,
}

/// A pattern on a surface.
#[derive(Debug, Clone)]
pub(super) enum Paint {
    /// Nothing: the surface's own colour.
    Plain,
    /// Cubes of two colours in turn.
    Checker { other: [f32; 3], size_mm: f64 },
    /// Layers of two colours in turn across a direction of unit length.
    Stripes {
        other: [f32; 3],
        width_mm: f64,
        across: Vector3<f64>,
    },
    /// Irregular cells, with a seam in the surface's own colour.
    Patches {
        colours: Vec<[f32; 3]>,
        size_mm: f64,
        seam_mm: f64,
    },
    /// A cloudy mixture of two colours.
    Noise { other: [f32; 3], size_mm: f64 },
    /// An image, `width_mm` wide.
    Picture { image: RgbImage, width_mm: f64 },
}

/// The albedo that a colour of a scene file stands for.
pub(super) fn albedo_of(colour: Rgb) -> [f32; 3] {
    colour.0.map(linear_from_srgb)
}

impl Surface {
    /// The albedo at a place in the solid's frame, 0 to 1 each for red, green and blue.
    pub(super) fn albedo(&self, at: &Vector3<f64>) -> [f32; 3] {
        match &self.paint {
            Paint::Plain => self.base,
            Paint::Checker { other, size_mm } => {
                let cell = at.map(|v| (v / size_mm).floor());
                self.either(other, cell.sum().rem_euclid(2.0) >= 1.0)
            }
            Paint::Stripes {
                other,
                width_mm,
                across,
            } => {
                let layer = (at.dot(across) / width_mm).floor();
                self.either(other, layer.rem_euclid(2.0) >= 1.0)
            }
            Paint::Patches {
                colours,
                size_mm,
                seam_mm,
            } => self.patch(colours, &(at / *size_mm), seam_mm / size_mm),
            Paint::Noise { other, size_mm } => {
                let share = cloud(&(at / *size_mm)) as f32;
                [0, 1, 2].map(|c| self.base[c] + share * (other[c] - self.base[c]))
            }
            Paint::Picture { image, width_mm } => pixel(image, *width_mm, at).unwrap_or(self.base),
        }
    }

    fn either(&self, other: &[f32; 3], is_other: bool) -> [f32; 3] {
        if is_other { *other } else { self.base }
    }

    /// The cell whose seed is nearest, or the seam where two are equally near (Worley, 1996); in cells.
    fn patch(&self, colours: &[[f32; 3]], at: &Vector3<f64>, seam: f64) -> [f32; 3] {
        let random = Random::new(11);
        let home = at.map(f64::floor);
        let (mut first, mut second, mut nearest) = (f64::INFINITY, f64::INFINITY, 0);
        for k in 0..27_u32 {
            let step = [k % 3, k / 3 % 3, k / 9].map(|s| f64::from(s) - 1.0);
            let cell = home + Vector3::from(step);
            let id = cell_id(&cell);
            let place = [0, 1, 2].map(|axis| random.part(axis).uniform(id));
            let distance = (cell + Vector3::from(place) - at).norm();
            if distance < first {
                (second, first, nearest) = (first, distance, id);
            } else if distance < second {
                second = distance;
            }
        }
        if second - first < seam {
            return self.base;
        }
        let count = colours.len().max(1) as u64;
        let index = (random.part(3).bits(nearest) % count) as usize;
        colours.get(index).copied().unwrap_or(self.base)
    }
}

/// A number of its own for every cell of space.
fn cell_id(cell: &Vector3<f64>) -> u64 {
    let [x, y, z] = [cell.x, cell.y, cell.z].map(|v| v as i64 as u64);
    Random::new(x).part(y).part(z).bits(0)
}

/// Smooth noise of mean about 1/2 that varies over a length of 1; from 0 to 1.
fn cloud(at: &Vector3<f64>) -> f64 {
    let (mut sum, mut weights, mut weight) = (0.0, 0.0, 1.0);
    for octave in 0..NOISE_OCTAVES {
        let scale = f64::from(1_u32 << octave);
        sum += weight * lattice(&(at * scale), u64::from(octave));
        weights += weight;
        weight *= 0.6;
    }
    ((sum / weights - 0.5) * 2.2 + 0.5).clamp(0.0, 1.0)
}

fn lattice(at: &Vector3<f64>, octave: u64) -> f64 {
    let random = Random::new(octave);
    let home = at.map(f64::floor);
    let part = (at - home).map(|v| v * v * (3.0 - 2.0 * v));
    (0..8_u32)
        .map(|k| {
            let step = Vector3::new(k & 1, k >> 1 & 1, k >> 2).map(f64::from);
            let share = step.zip_map(&part, |s, p| if s > 0.5 { p } else { 1.0 - p });
            share.product() * random.uniform(cell_id(&(home + step)))
        })
        .sum()
}

/// The pixel of a picture centred on x = y = 0; `None` beside it.
fn pixel(image: &RgbImage, width_mm: f64, at: &Vector3<f64>) -> Option<[f32; 3]> {
    let scale = f64::from(image.width()) / width_mm;
    let x = (at.x * scale + f64::from(image.width()) / 2.0).floor();
    let y = (at.y * scale + f64::from(image.height()) / 2.0).floor();
    if x < 0.0 || y < 0.0 {
        return None;
    }
    image
        .get_pixel_checked(x as u32, y as u32)
        .map(|p| p.0.map(linear_from_srgb))
}
