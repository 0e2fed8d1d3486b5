//! A flat wall painted in patches of colour, seen by a camera pixel for pixel: enough optics to make colours
//! fail (albedo, room light, crosstalk, soft lines, shot and read noise), and nothing else.

use std::sync::LazyLock;

use acquirer::pipeline::colour_choice::ColourTrial;
use image::RgbImage;
use shared::pattern::{Grid, NamedColour, Palette, Pattern, Raster, RasterSize};

/// The wall, its light and its camera. Light is linear, 1 is the camera's full scale.
pub(crate) struct PaintedWall {
    /// Size of the projector's raster and of the camera's picture.
    pub size: RasterSize,
    /// Share of light given back, per channel, by patches of 80 px in turn.
    pub paints: Vec<[f64; 3]>,
    /// Room light, per channel.
    pub room: [f64; 3],
    /// Light that a white projector adds on a white wall.
    pub projector: f64,
    /// Share of each projector channel that leaks into each of the other two camera channels.
    pub crosstalk: f64,
    /// Standard deviation without light, and variance per unit of light.
    pub noise: (f64, f64),
}

impl PaintedWall {
    pub(crate) fn grey() -> Self {
        Self {
            size: RasterSize {
                width: 320,
                height: 240,
            },
            paints: vec![[0.5; 3]],
            room: [0.04; 3],
            projector: 0.7,
            crosstalk: 0.1,
            noise: (0.002, 2e-4),
        }
    }

    pub(crate) fn coloured(saturation: f64, dim: f64) -> Self {
        let hues = [0.0, 0.45, 0.15, 0.7, 0.3, 0.9, 0.55];
        let paint = |hue: f64| {
            [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|c: f64| {
                let wave = 0.5 + 0.5 * (std::f64::consts::TAU * (hue - c)).cos();
                0.6 * (1.0 - saturation * (1.0 - wave))
            })
        };
        Self {
            paints: hues.into_iter().map(paint).collect(),
            projector: 0.7 * dim,
            room: [0.06, 0.05, 0.04],
            ..Self::grey()
        }
    }

    /// What the camera sees of a pattern; equal seeds give equal noise.
    pub(crate) fn shoot(&self, pattern: &Pattern, seed: u64) -> RgbImage {
        let raster = pattern.raster(self.size);
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        RgbImage::from_fn(self.size.width, self.size.height, |x, y| {
            let light = self.light(&raster, x, y);
            image::Rgb(light.map(|light| {
                let sigma = (self.noise.0.powi(2) + self.noise.1 * light).sqrt();
                encode(light + sigma * random.normal())
            }))
        })
    }

    fn light(&self, raster: &Raster, x: u32, y: u32) -> [f64; 3] {
        let drive = soft(raster, x, y);
        let patch = x / 80 + 3 * (y / 80);
        let paint = self.paints[patch as usize % self.paints.len()];
        let total: f64 = drive.iter().sum();
        std::array::from_fn(|c| {
            let own = drive[c] + self.crosstalk * (total - drive[c]);
            paint[c] * (self.room[c] + self.projector * own / (1.0 + 2.0 * self.crosstalk))
        })
    }

    /// Black and white twice, and the grid in each colour of the shipped palette.
    pub(crate) fn trial(&self, grid: &Grid) -> ColourTrial {
        let palette = Palette::default();
        let shot = |(k, entry): (usize, &NamedColour)| {
            let frame = self.shoot(&Pattern::Grid(grid.unary(entry.colour)), 100 + k as u64);
            (entry.clone(), frame)
        };
        ColourTrial {
            black: vec![
                self.shoot(&Pattern::BLACK, 1),
                self.shoot(&Pattern::BLACK, 2),
            ],
            white: vec![
                self.shoot(&Pattern::WHITE, 3),
                self.shoot(&Pattern::WHITE, 4),
            ],
            shots: palette.colours().iter().enumerate().map(shot).collect(),
        }
    }
}

/// Linear drive averaged over 3 x 3 pixels.
fn soft(raster: &Raster, x: u32, y: u32) -> [f64; 3] {
    let size = raster.size();
    let columns = x.saturating_sub(1)..(x + 2).min(size.width);
    let rows = y.saturating_sub(1)..(y + 2).min(size.height);
    let count = (columns.len() * rows.len()) as f64;
    let mut sum = [0.0; 3];
    for (px, py) in rows.flat_map(|py| columns.clone().map(move |px| (px, py))) {
        let drive = raster.pixel(px, py).0.map(decode);
        (0..3).for_each(|c| sum[c] += drive[c] / count);
    }
    sum
}

/// Linear light of an sRGB byte.
pub(crate) fn decode(byte: u8) -> f64 {
    static TABLE: LazyLock<[f64; 256]> = LazyLock::new(|| {
        std::array::from_fn(|byte| {
            let value = byte as f64 / 255.0;
            if value <= 0.04045 {
                value / 12.92
            } else {
                ((value + 0.055) / 1.055).powf(2.4)
            }
        })
    });
    TABLE[usize::from(byte)]
}

fn encode(light: f64) -> u8 {
    let light = light.clamp(0.0, 1.0);
    let value = if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * value).round() as u8
}

/// A small generator, so that the frames are the same everywhere.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Sum of twelve uniform numbers: close enough to normal.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}
