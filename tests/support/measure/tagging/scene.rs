//! The scene of a simulated rig: bands of surfaces, each with its own colour and texture, and the patterns' light on them.

use acquirer::session::tagging::{BANDS, Band, outstanding_order};
use shared::pattern::{Palette, Rgb};

use super::{CODED, random::Random};

/// Virtual pixels of a band; the first ones are its samples.
const PIXELS: usize = 48;
const SAMPLES: usize = 32;
/// Noise of a band's mean (flicker of the room's lamps, mostly) and of a sample, as a share of the light and as light
/// of 255 in the dark.
const MEAN_NOISE: (f64, f64) = (0.0005, 0.03);
const SAMPLE_NOISE: (f64, f64) = (0.02, 0.1);
/// By how much the camera's tone curve differs from the one that is assumed: the exponent of light.
const BENT: f64 = 1.1;

/// The surfaces, and the patterns' light on them.
pub(super) struct Scene {
    /// For each band and virtual pixel: the ambient light and the reflected share, per channel.
    surfaces: Vec<Vec<([f64; 3], [f64; 3])>>,
    /// For each pattern, band and pixel the projected light, linear.
    pub(super) patterns: Vec<Vec<Vec<[f64; 3]>>>,
    /// The unary grid of a recording.
    pub(super) white_unary: usize,
}

impl Scene {
    pub(super) fn new(random: &mut Random) -> Self {
        let palette = Palette::default();
        let colours: Vec<Rgb> = palette.colours().iter().map(|c| c.colour).collect();
        let unary = outstanding_order(&colours).into_iter().map(|k| colours[k]);
        let unary: Vec<Rgb> = unary.collect();
        let surfaces = (0..BANDS).map(|_| {
            let albedo: [f64; 3] = std::array::from_fn(|_| random.within(0.15, 0.8));
            let pixel = |random: &mut Random| {
                let texture = random.within(0.6, 1.0);
                (albedo.map(|a| 0.02 * a), albedo.map(|a| texture * a))
            };
            (0..PIXELS).map(|_| pixel(random)).collect()
        });
        let surfaces: Vec<Vec<_>> = surfaces.collect();
        // a fifth of the picture is lines, each in one of the four colours
        let lines: Vec<Vec<Option<usize>>> = (0..BANDS)
            .map(|_| {
                let pixel = |random: &mut Random| {
                    let line = (random.uniform() * 4.0) as usize;
                    (random.uniform() < 0.2).then_some(line)
                };
                (0..PIXELS).map(|_| pixel(random)).collect()
            })
            .collect();
        let coded = [0xff_0000, 0xff_ff00, 0xff_00ff, 0x00_ff00_u32];
        let coded = coded.map(|rgb| Rgb([(rgb >> 16) as u8, (rgb >> 8) as u8, rgb as u8]));
        let grid = |colour: &dyn Fn(usize) -> Rgb| -> Vec<Vec<[f64; 3]>> {
            let pixel = |line: &Option<usize>| line.map_or([0.0; 3], |line| linear(colour(line)));
            let bands = lines.iter().map(|band| band.iter().map(pixel).collect());
            bands.collect()
        };
        let all = |light: f64| vec![vec![[light; 3]; PIXELS]; BANDS];
        let mut patterns = vec![all(0.0), all(1.0), grid(&|line| coded[line])];
        let white = unary.iter().position(|&colour| colour == Rgb::WHITE);
        let white_unary = CODED + 1 + white.unwrap_or(0);
        patterns.extend(unary.into_iter().map(|colour| grid(&move |_| colour)));
        Self {
            surfaces,
            patterns,
            white_unary,
        }
    }

    /// What the camera makes of a band under these shares of the patterns.
    pub(super) fn band(&self, band: usize, shares: &[f64], random: &mut Random) -> Band {
        let lit: Vec<(usize, f64)> = (0..shares.len())
            .filter(|&k| shares[k] > 0.0)
            .map(|k| (k, shares[k]))
            .collect();
        let pixels = self.surfaces[band].iter().enumerate();
        let light: Vec<[f64; 3]> = pixels
            .map(|(pixel, (ambient, reflected))| {
                std::array::from_fn(|c| {
                    let light: f64 = lit
                        .iter()
                        .map(|&(k, share)| share * self.patterns[k][band][pixel][c])
                        .sum();
                    255.0
                        * (ambient[c] + 0.9 * reflected[c] * light)
                            .min(1.0)
                            .powf(BENT)
                })
            })
            .collect();
        let mut noisy = |light: f64, (share, dark): (f64, f64)| {
            (light + (share * light).hypot(dark) * random.normal()) as f32
        };
        Band {
            mean: std::array::from_fn(|c| {
                let sum: f64 = light.iter().map(|pixel| pixel[c]).sum();
                noisy(sum / PIXELS as f64, MEAN_NOISE)
            }),
            samples: light[..SAMPLES]
                .iter()
                .flatten()
                .map(|&light| noisy(light, SAMPLE_NOISE))
                .collect(),
        }
    }
}

/// Linear light of a colour's drive values.
fn linear(colour: Rgb) -> [f64; 3] {
    colour.0.map(|byte| (f64::from(byte) / 255.0).powf(2.2))
}
