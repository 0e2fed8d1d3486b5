//! What is kept of a frame to recognise it by: mean light and a few samples, in horizontal bands.
//!
//! Takes a picture, gives a [`Look`] of some hundred numbers. The mean of a band tells patterns of different colour
//! apart to a thousandth of white; the samples, small blocks of pixels spread over the band, those that differ
//! in place only. Bands, because a rolling shutter exposes the rows one after the other: a torn frame shows one
//! pattern above and another one below. Values are light, 0 to 255, since light is what adds up in a mixture; bytes
//! are taken to follow the sRGB curve, and what other curves do to a mixture is allowed for.

use std::sync::LazyLock;

use image::RgbImage;
use serde::Serialize;

/// Bands of a frame, from the first row to the last.
pub const BANDS: usize = 8;
/// Sampled blocks of a band.
const BLOCKS: usize = 32;
/// Side of a sampled block in pixels.
const BLOCK_PX: u32 = 3;
/// Two looks differ when a mean differs by more than this many standard deviations of one.
const DIFFERS_SIGMA: f32 = 6.0;
/// A mean is outside of a range when it misses it by this many standard deviations, and by this share of the samples'
/// change: where some pixels brighten and others darken, a curve that is not sRGB's bends the mean by less than that.
const OUTSIDE_SIGMA: f32 = 8.0;
const BENT_SHARE: f32 = 0.1;
/// Share of either end from which a band counts as a mixture.
const MIXED_SHARE: f32 = 0.1;
/// Standard deviations that a share of foreign light must stay below what is allowed.
const EXCLUDED_SIGMA: f32 = 4.0;
/// Least noise assumed of a mean and of a sample: rounding to bytes hides what is below.
const LEAST_NOISE: LookNoise = LookNoise {
    mean: NoiseLaw {
        dark: 0.02,
        share: 0.0003,
        light: 0.0,
    },
    sample: NoiseLaw {
        dark: 0.1,
        share: 0.005,
        light: 0.0,
    },
    coarse: false,
};

/// Light of each byte, 0 to 255.
static LIGHT: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let value = byte as f32 / 255.0;
        let light = if value <= 0.04045 {
            value / 12.92
        } else {
            ((value + 0.055) / 1.055).powf(2.4)
        };
        255.0 * light
    })
});

/// One band of a frame, in light from 0 to 255.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// Mean red, green and blue.
    pub mean: [f32; 3],
    /// Red, green and blue of each sampled block.
    pub samples: Vec<f32>,
}

/// What is kept of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    bands: Vec<Band>,
}

/// Standard deviation of a value from frame to frame while nothing changes.
///
/// In squares it is the dark one's, plus what grows with the light (photons) up to the light it was measured at, and
/// with the light's square (flicker) beyond: never less than either alone would be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NoiseLaw {
    /// In the dark, in light from 0 to 255.
    pub dark: f32,
    /// What comes on top in `light`, as a share of it.
    pub share: f32,
    /// The bright light in which noise was measured, from 0 to 255.
    pub light: f32,
}

/// The noise of frames.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LookNoise {
    /// Of a band's mean.
    pub mean: NoiseLaw,
    /// Of a sample.
    pub sample: NoiseLaw,
    /// Taken for more than was measured: a little foreign light at the ends of a run could pass for noise.
    pub coarse: bool,
}

impl Look {
    /// What is kept of a picture of at least 8 rows; one with fewer is all alike in its bands.
    #[must_use]
    pub fn of(picture: &RgbImage) -> Self {
        let rows = |band: usize| (picture.height() as usize * band / BANDS) as u32;
        let bands = (0..BANDS).map(|band| Band::of(picture, rows(band), rows(band + 1)));
        Self {
            bands: bands.collect(),
        }
    }

    /// A look of these bands, for simulations that have no picture.
    #[must_use]
    pub fn from_bands(bands: Vec<Band>) -> Self {
        Self { bands }
    }

    /// The bands, from the first row to the last.
    #[must_use]
    pub fn bands(&self) -> &[Band] {
        &self.bands
    }

    /// Whether all of the picture has one value, as when black is cut off: such frames repeat byte by byte without
    /// being given twice.
    #[must_use]
    pub fn is_blank(&self) -> bool {
        let mut samples = self.bands.iter().flat_map(|band| &band.samples);
        let first = samples.next();
        samples.all(|sample| Some(sample) == first)
            && self
                .bands
                .windows(2)
                .all(|pair| pair[0].mean == pair[1].mean)
    }

    /// Mean light of all channels of all bands, 0 to 255.
    #[must_use]
    pub fn brightness(&self) -> f32 {
        let means = self.bands.iter().flat_map(|band| band.mean);
        means.sum::<f32>() / (3 * self.bands.len().max(1)) as f32
    }

    fn means(&self) -> Vec<f32> {
        self.bands.iter().flat_map(|band| band.mean).collect()
    }

    fn samples(&self) -> Vec<f32> {
        let samples = self.bands.iter().flat_map(|band| &band.samples);
        samples.copied().collect()
    }

    /// Whether nothing but noise lies between two frames, in any band.
    #[must_use]
    pub fn same(&self, other: &Self, noise: LookNoise) -> bool {
        let pairs = self.bands.iter().zip(&other.bands);
        pairs.into_iter().all(|(a, b)| a.same(b, noise))
    }

    /// Whether what lies between two frames that follow each other is little beside what lies around them, in every
    /// band: light of other patterns that may be in them, but not much of it.
    #[must_use]
    pub fn nearly_same(&self, next: &Self, around: (&Self, &Self), noise: LookNoise) -> bool {
        (0..self.bands.len()).all(|k| {
            let (own, next) = (&self.bands[k], &next.bands[k]);
            let little = |beside: &Band| {
                let (step, way) = (own.change(next), own.change(beside));
                let most = |values: [f32; 3]| values.into_iter().fold(0.0, f32::max);
                most(step) < MIXED_SHARE * most(way)
            };
            let (before, after) = (&around.0.bands[k], &around.1.bands[k]);
            own.same(next, noise) || (little(before) && little(after))
        })
    }

    /// Whether a mixture of two frames could look like this one: the mean of each band lies between theirs.
    ///
    /// Part of an exposure under the one light and part under the other gives means between the two, whatever the
    /// parts in each row.
    #[must_use]
    pub fn between(&self, a: &Self, b: &Self, noise: LookNoise) -> bool {
        let bands = self.bands.iter().zip(a.bands.iter().zip(&b.bands));
        bands
            .into_iter()
            .all(|(own, (a, b))| own.between(a, b, noise))
    }

    /// Whether some band looks like a mixture of two frames, with a tenth of either at least.
    #[must_use]
    pub fn partly_mixed(&self, a: &Self, b: &Self, noise: LookNoise) -> bool {
        let bands = self.bands.iter().zip(a.bands.iter().zip(&b.bands));
        bands.into_iter().any(|(own, (a, b))| {
            let share = own.share(a, b, 0.0);
            let mixed =
                share.is_some_and(|share| (MIXED_SHARE..1.0 - MIXED_SHARE).contains(&share));
            mixed && own.between(a, b, noise) && !own.same(a, noise) && !own.same(b, noise)
        })
    }

    /// The most of other looks' light that may be in this one, as a share of 1, in the band where it is most; with
    /// `own`, a look of the same thing that has none of the first one's.
    ///
    /// The light of each foreign look adds its share of the way to that look; the shares are fitted to all values of a
    /// band by their noise, and what counts is the first one's with four standard deviations on top. Bands
    /// in which nobody could see even all of it are left out.
    #[must_use]
    pub fn most_foreign(&self, own: &Self, foreign: &[&Self], noise: LookNoise) -> f32 {
        let bands = (0..self.bands.len()).filter_map(|k| {
            let foreign: Vec<&Band> = foreign.iter().map(|look| &look.bands[k]).collect();
            self.bands[k].most_foreign(&own.bands[k], &foreign, noise)
        });
        bands.fold(0.0, f32::max)
    }

    /// How far the light of each band has come from one look to another, 0 to 1 and a little beyond by noise; `None`
    /// where the two differ by less than `least_contrast` in every channel.
    #[must_use]
    pub fn share(&self, from: &Self, to: &Self, least_contrast: f32) -> Vec<Option<f32>> {
        let bands = self.bands.iter().zip(from.bands.iter().zip(&to.bands));
        bands
            .map(|(own, (from, to))| own.share(from, to, least_contrast))
            .collect()
    }
}

fn is_outside(value: f32, (a, b): (f32, f32), miss: f32) -> bool {
    value < a.min(b) - miss || value > a.max(b) + miss
}

impl Band {
    fn of(picture: &RgbImage, first: u32, end: u32) -> Self {
        let stride = picture.width() as usize * 3;
        let bytes = &picture.as_raw()[first as usize * stride..end as usize * stride];
        let mut counts = [[0_u32; 256]; 3];
        for pixel in bytes.chunks_exact(3) {
            for (counts, &byte) in counts.iter_mut().zip(pixel) {
                counts[usize::from(byte)] += 1;
            }
        }
        let pixels = (bytes.len() / 3).max(1) as f64;
        let mean = counts.map(|counts| {
            let products = counts.iter().zip(LIGHT.iter());
            let sum: f64 = products
                .map(|(&n, &light)| f64::from(n) * f64::from(light))
                .sum();
            (sum / pixels) as f32
        });
        Self {
            mean,
            samples: (0..BLOCKS)
                .flat_map(|block| block_mean(picture, first, end, block))
                .collect(),
        }
    }

    /// How far the means have come from one band to another, see [`Look::share`].
    fn share(&self, from: &Self, to: &Self, least_contrast: f32) -> Option<f32> {
        let way: [f32; 3] = std::array::from_fn(|c| to.mean[c] - from.mean[c]);
        let length: f32 = way.iter().map(|step| step * step).sum();
        let done: f32 = (0..3).map(|c| (self.mean[c] - from.mean[c]) * way[c]).sum();
        let contrast = way.iter().fold(0.0, |most: f32, step| most.max(step.abs()));
        (contrast > least_contrast).then(|| done / length)
    }

    /// Whether the means lie between those of two others in every channel.
    fn between(&self, a: &Self, b: &Self, noise: LookNoise) -> bool {
        let change = a.change(b);
        (0..3).all(|c| {
            let own = self.mean[c];
            let miss = OUTSIDE_SIGMA * noise.mean.at(own) + BENT_SHARE * change[c];
            !is_outside(own, (a.mean[c], b.mean[c]), miss)
        })
    }

    /// Mean size of the samples' change to another band, per channel.
    fn change(&self, other: &Self) -> [f32; 3] {
        let pairs = self
            .samples
            .chunks_exact(3)
            .zip(other.samples.chunks_exact(3));
        let mut sums = [0.0; 3];
        for (a, b) in pairs {
            sums = std::array::from_fn(|c| sums[c] + (a[c] - b[c]).abs());
        }
        sums.map(|sum| sum * 3.0 / self.samples.len().max(1) as f32)
    }

    /// See [`Look::most_foreign`], which has one look or two.
    fn most_foreign(&self, own: &Self, foreign: &[&Self], noise: LookNoise) -> Option<f32> {
        let mut sums = Normal::default();
        let values = |band: &Self, k: usize| match k.checked_sub(3) {
            None => (band.mean[k], noise.mean),
            Some(k) => (band.samples[k], noise.sample),
        };
        for k in 0..3 + self.samples.len().min(own.samples.len()) {
            let ((value, law), (own, _)) = (values(self, k), values(own, k));
            let variance = law.at(value).powi(2) + law.at(own).powi(2);
            let ways = [0, 1].map(|f| foreign.get(f).map_or(0.0, |band| values(band, k).0 - own));
            sums.add(value - own, ways, variance);
        }
        sums.first_at_most()
    }

    fn same(&self, other: &Self, noise: LookNoise) -> bool {
        let means = self.mean.iter().zip(&other.mean);
        let mut differences = means.map(|(&a, &b)| (a - b).abs() / noise.mean.at(a.max(b)));
        if differences.any(|difference| difference > DIFFERS_SIGMA) {
            return false;
        }
        let samples = self.samples.iter().zip(&other.samples);
        let squares: f32 = samples
            .map(|(&a, &b)| ((a - b) / noise.sample.at(a.max(b))).powi(2))
            .sum();
        let count = self.samples.len() as f32;
        // the squares of differences of two values are 2 each; their sum spreads by sqrt(2 n) of them
        squares <= 2.0 * count * (1.0 + DIFFERS_SIGMA * (2.0 / count.max(1.0)).sqrt())
    }
}

/// Sums of a weighted least-squares fit of a difference by two ways, each gone by a share.
#[derive(Default)]
struct Normal {
    ways: [f64; 2],
    both: f64,
    difference: [f64; 2],
}

impl Normal {
    fn add(&mut self, difference: f32, ways: [f32; 2], variance: f32) {
        let weight = 1.0 / f64::from(variance);
        let (difference, [a, b]) = (f64::from(difference), ways.map(f64::from));
        self.ways = [self.ways[0] + a * a * weight, self.ways[1] + b * b * weight];
        self.both += a * b * weight;
        self.difference[0] += difference * a * weight;
        self.difference[1] += difference * b * weight;
    }

    /// The first share at most; `None` when even a whole one would not be seen.
    fn first_at_most(&self) -> Option<f32> {
        if self.ways[0] < f64::from(DIFFERS_SIGMA).powi(2) {
            return None;
        }
        // what the first way has of its own, beside the second one
        let seen = self.ways[1] >= f64::from(DIFFERS_SIGMA).powi(2);
        let along = if seen { self.both / self.ways[1] } else { 0.0 };
        let own = self.ways[0] - along * self.both;
        let share = (self.difference[0] - along * self.difference[1]) / own;
        let most = share.max(0.0) + f64::from(EXCLUDED_SIGMA) / own.sqrt();
        // two ways that are one tell nothing
        Some(if own > 0.0 {
            most as f32
        } else {
            f32::INFINITY
        })
    }
}

/// Mean light of a block whose place is spread evenly over the band by the golden ratio's plane relative.
fn block_mean(picture: &RgbImage, first: u32, end: u32, block: usize) -> [f32; 3] {
    const ACROSS: f64 = 0.754_877_666_246_692_8;
    const DOWN: f64 = 0.569_840_290_998_053_3;
    let place = |step: f64, length: u32| {
        let share = ((block as f64 + 0.5) * step).fract();
        (share * f64::from(length.saturating_sub(BLOCK_PX))) as u32
    };
    let (left, top) = (
        place(ACROSS, picture.width()),
        first + place(DOWN, end - first),
    );
    let (mut sums, mut count) = ([0.0; 3], 0_u32);
    for y in top..(top + BLOCK_PX).min(picture.height()) {
        for x in left..(left + BLOCK_PX).min(picture.width()) {
            let pixel = picture.get_pixel(x, y).0;
            sums = std::array::from_fn(|c| sums[c] + LIGHT[usize::from(pixel[c])]);
            count += 1;
        }
    }
    sums.map(|sum: f32| sum / count.max(1) as f32)
}

impl NoiseLaw {
    /// Standard deviation at a value.
    fn at(self, light: f32) -> f32 {
        let light = light.max(0.0);
        self.dark
            .hypot(self.share * (light * light.max(self.light)).sqrt())
    }

    /// The law through the noise at two brightnesses, given as noise and root mean square of the light.
    fn through(dark: (f32, f32), bright: (f32, f32), least: Self) -> Self {
        let growth = bright.0 * bright.0 - dark.0 * dark.0;
        let light = bright.1 * bright.1 - dark.1 * dark.1;
        let share = (growth / light.max(1.0)).max(0.0).sqrt();
        Self {
            dark: dark.0.max(least.dark),
            share: share.max(least.share),
            light: bright.1,
        }
    }

    fn times(self, factor: f32) -> Self {
        Self {
            dark: factor * self.dark,
            share: factor * self.share,
            light: self.light,
        }
    }
}

impl LookNoise {
    /// The noise that repeated frames of two things show, a dark and a bright one: the median over neighbours, so that
    /// a change among them does no harm. Without repeats the least there is.
    #[must_use]
    pub fn of(dark: &[Look], bright: &[Look]) -> Self {
        let law = |values: fn(&Look) -> Vec<f32>, least| {
            let [dark, bright] = [dark, bright].map(|looks| noise_and_light(looks, values));
            NoiseLaw::through(dark, bright, least)
        };
        Self {
            mean: law(Look::means, LEAST_NOISE.mean),
            sample: law(Look::samples, LEAST_NOISE.sample),
            coarse: false,
        }
    }

    /// The noise of a camera that has more of it than repeats of black and white showed, in pictures full of edges:
    /// half as much again for each time but the first that frames of a still picture were not recognised.
    #[must_use]
    pub fn after_failures(self, failures: usize) -> Self {
        let coarser = failures.saturating_sub(1);
        let factor = 1.0 + 0.5 * coarser as f32;
        Self {
            mean: self.mean.times(factor),
            sample: self.sample.times(factor),
            coarse: coarser > 0,
        }
    }
}

/// Standard deviation of values from frame to frame, and the root mean square of the values.
fn noise_and_light(looks: &[Look], values: fn(&Look) -> Vec<f32>) -> (f32, f32) {
    let root_mean_square = |values: &[f32]| {
        let squares: f32 = values.iter().map(|value| value * value).sum();
        (squares / values.len().max(1) as f32).sqrt()
    };
    let pairs = looks.windows(2).map(|pair| {
        let (a, b) = (values(&pair[0]), values(&pair[1]));
        let differences: Vec<f32> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        root_mean_square(&differences) / std::f32::consts::SQRT_2
    });
    let light = looks
        .last()
        .map_or(0.0, |look| root_mean_square(&values(look)));
    (median(pairs.collect()), light)
}

fn median(mut values: Vec<f32>) -> f32 {
    values.sort_by(f32::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
