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

    /// The cell whose seed is nearest (Worley, 1996), or the seam along its border to the second nearest; in cells.
    fn patch(&self, colours: &[[f32; 3]], at: &Vector3<f64>, seam: f64) -> [f32; 3] {
        let random = Random::new(11);
        let home = at.map(f64::floor);
        let seeds = (0..27_u32).map(|k| {
            let step = [k % 3, k / 3 % 3, k / 9].map(|s| f64::from(s) - 1.0);
            let cell = home + Vector3::from(step);
            let id = cell_id(&cell);
            let place = [0, 1, 2].map(|axis| random.part(axis).uniform(id));
            (cell + Vector3::from(place) - at, id)
        });
        let (mut first, mut second) = ((Vector3::repeat(9.0), 0), (Vector3::repeat(9.0), 0));
        for seed in seeds {
            let distance2 = seed.0.norm_squared();
            if distance2 < first.0.norm_squared() {
                (second, first) = (first, seed);
            } else if distance2 < second.0.norm_squared() {
                second = seed;
            }
        }
        let apart = (second.0 - first.0).norm();
        let to_border = (second.0.norm_squared() - first.0.norm_squared()) / (2.0 * apart);
        if to_border < seam / 2.0 {
            return self.base;
        }
        let count = colours.len().max(1) as u64;
        let index = (random.part(3).bits(first.1) % count) as usize;
        colours.get(index).copied().unwrap_or(self.base)
    }
}

/// A number for every cell of space, its own within a million cells of the middle.
fn cell_id(cell: &Vector3<f64>) -> u64 {
    let [x, y, z] = [cell.x, cell.y, cell.z].map(|v| v as i64 as u64);
    x.wrapping_add(y << 21).wrapping_add(z << 42)
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

#[cfg(test)]
mod tests {
    use super::*;

    const DARK: [f32; 3] = [0.1; 3];
    const LIGHT: [f32; 3] = [0.8; 3];

    fn painted(paint: Paint) -> Surface {
        Surface {
            base: DARK,
            paint,
            gloss: 0.0,
            gloss_exponent: 30.0,
        }
    }

    fn places() -> impl Iterator<Item = Vector3<f64>> {
        (0..40 * 40)
            .map(|k| Vector3::new(f64::from(k % 40) - 20.0, f64::from(k / 40) - 20.0, -0.01))
    }

    #[test]
    fn checkers_and_stripes_change_at_their_borders_and_take_half_each() {
        let checker = painted(Paint::Checker {
            other: LIGHT,
            size_mm: 10.0,
        });
        let at = |x, y| checker.albedo(&Vector3::new(x, y, -0.01));
        assert_ne!(at(9.9, 5.0), at(10.1, 5.0));
        assert_ne!(at(5.0, -0.1), at(5.0, 0.1));
        assert_eq!(at(5.0, 5.0), at(15.0, 15.0));
        let across = Vector3::y();
        let stripes = painted(Paint::Stripes {
            other: LIGHT,
            width_mm: 10.0,
            across,
        });
        let light = places().filter(|p| stripes.albedo(p) == LIGHT).count();
        assert_eq!(light, 800);
    }

    #[test]
    fn patches_show_every_colour_of_their_list_and_a_seam() {
        let colours = vec![[0.8, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 0.8]];
        let patches = painted(Paint::Patches {
            colours: colours.clone(),
            size_mm: 8.0,
            seam_mm: 1.0,
        });
        let share = |colour: [f32; 3]| {
            places().filter(|p| patches.albedo(p) == colour).count() as f64 / 1600.0
        };
        assert!(colours.iter().all(|colour| share(*colour) > 0.1));
        assert!((0.03..0.4).contains(&share(DARK)), "seam {}", share(DARK));
    }

    #[test]
    fn noise_stays_between_its_two_colours_and_is_smooth() {
        let noise = painted(Paint::Noise {
            other: LIGHT,
            size_mm: 12.0,
        });
        let level = |p: &Vector3<f64>| noise.albedo(p)[0];
        let mean = places().map(|p| level(&p)).sum::<f32>() / 1600.0;
        assert!((0.3..0.6).contains(&mean), "mean {mean}");
        for p in places() {
            assert!((0.1..=0.8).contains(&level(&p)));
            assert!((level(&p) - level(&(p + Vector3::x() * 0.05))).abs() < 0.05);
        }
    }

    #[test]
    fn a_picture_lies_centred_on_the_solid_and_ends_at_its_border() {
        let image = RgbImage::from_fn(4, 2, |x, y| {
            image::Rgb([if x == 0 && y == 0 { 255 } else { 0 }; 3])
        });
        let poster = painted(Paint::Picture {
            image,
            width_mm: 40.0,
        });
        let at = |x, y| poster.albedo(&Vector3::new(x, y, 0.0))[0];
        assert_eq!(at(-15.0, -5.0), 1.0, "the upper left pixel covers 10 mm");
        assert_eq!(at(-5.0, -5.0), 0.0);
        assert_eq!(at(-15.0, 5.0), 0.0);
        assert_eq!(
            at(-25.0, -5.0),
            0.1,
            "beside the picture is the surface's own colour"
        );
        assert_eq!(at(5.0, 15.0), 0.1);
    }
}
