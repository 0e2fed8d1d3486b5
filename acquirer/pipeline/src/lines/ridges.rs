//! Where each picture row crosses the middle of a steep line, and each picture column that of a flat one.
//!
//! Both families are looked for in the picture as it lies in memory, strip by strip: smoothed along the lines,
//! differentiated across them, and every fall through zero that is steep enough is a ridge.

use pulp::NullaryFnOnce;
use rayon::prelude::*;
use shared::pattern::Axis;

use super::{LineSettings, half_kernel, smoothed_row};
use crate::{
    convolve::{Pair, convolve, pad_ends, wide},
    gain::GainImage,
};

/// A point on the middle of a line, in one picture row or column.
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
const SIGMA_PER_WIDTH: f64 = 0.5;
/// Strength of a line of gain 1 at that scale: (w/s) / sqrt(2 pi) x exp(-(w/s)^2 / 8).
const FULL_STRENGTH: f32 = 0.456;
/// Demosaicing and JPEG correlate neighbouring pixels: their noise survives smoothing about so many times
/// better than independent noise would.
const CORRELATED: f32 = 2.0;
/// A ridge that continues a track may have this share of the strength of one that begins it.
const WEAK_SHARE: f32 = 0.5;

/// Where it must be dark beside a ridge, in line widths from its middle.
const BESIDE_WIDTHS: [f64; 2] = [1.0, 1.3];
/// Largest share of the ridge's own gain that counts as dark beside it.
const BESIDE_SHARE: f32 = 0.5;

/// Picture rows that one thread takes at a time.
const STRIP: usize = 32;

/// The ridges of one family, kept between frames: for each pixel along the lines those across, in order.
#[derive(Debug, Clone, Default)]
pub(super) struct Ridges {
    /// Where each pixel's ridges begin in `all`, and one past the last.
    starts: Vec<usize>,
    all: Vec<Ridge>,
    strips: Vec<Strip>,
    tiles: Vec<Vec<f32>>,
}

/// What one thread works with.
#[derive(Debug, Clone, Default)]
struct Strip {
    smooth: Vec<f32>,
    slopes: [Vec<f32>; 2],
    /// Ridges and their pixel along the line.
    found: Vec<(usize, Ridge)>,
}

impl Ridges {
    /// Pixels along the lines.
    pub(super) fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The ridges of one pixel along, sorted by position across.
    pub(super) fn row(&self, along: usize) -> &[Ridge] {
        &self.all[self.starts[along]..self.starts[along + 1]]
    }

    /// Finds the ridges of one family: flat lines along x, steep ones along y.
    pub(super) fn find(
        &mut self,
        image: &GainImage,
        family: Axis,
        (shrink, width_px): (f32, f64),
        settings: &LineSettings,
    ) {
        let (width, height) = (image.gain.width(), image.gain.height());
        let (along, across) = match family {
            Axis::Row => (width, height),
            Axis::Column => (height, width),
        };
        self.strips
            .resize_with(height.div_ceil(STRIP), Strip::default);
        let pass = Pass::new(image, shrink, width_px, settings);
        let strips = self.strips.par_iter_mut().enumerate();
        strips.for_each(|(k, strip)| {
            strip.found.clear();
            let rows = k * STRIP..((k + 1) * STRIP).min(height);
            if width >= 3 {
                wide(StripPass {
                    pass: &pass,
                    family,
                    rows,
                    strip,
                });
            }
        });
        self.gather(along);
        self.compare_with_neighbourhood(across, settings);
    }

    /// Sorts what the strips found by the pixel along; across it is in order already.
    fn gather(&mut self, along: usize) {
        self.starts.clear();
        self.starts.resize(along + 1, 0);
        let found = || self.strips.iter().flat_map(|strip| &strip.found);
        for &(at, _) in found() {
            self.starts[at + 1] += 1;
        }
        for at in 0..along {
            self.starts[at + 1] += self.starts[at];
        }
        self.all.clear();
        let blank = Ridge {
            across: 0.0,
            strength: 0.0,
            strong: false,
        };
        self.all.resize(self.starts[along], blank);
        for &(at, ridge) in found() {
            self.all[self.starts[at]] = ridge;
            self.starts[at] += 1; // now the end of its pixel, which is the start of the next
        }
        self.starts.copy_within(0..along, 1);
        if let Some(first) = self.starts.first_mut() {
            *first = 0;
        }
    }

    /// Keeps ridges that are not faint beside the lines around them.
    fn compare_with_neighbourhood(&mut self, across: usize, settings: &LineSettings) {
        let side = settings.tile_px.clamp(8, 512);
        let columns = across.div_ceil(side).max(1);
        let tile = |ridge: &Ridge| (ridge.across as usize / side).min(columns - 1);
        let share = settings.share_of_local as f32;
        self.tiles.resize_with(columns, Vec::new);
        let mut kept = 0;
        for band in (0..self.len()).step_by(side) {
            let rows = band..(band + side).min(self.len());
            let range = self.starts[rows.start]..self.starts[rows.end];
            self.tiles.iter_mut().for_each(Vec::clear);
            for ridge in self.all[range].iter().filter(|ridge| ridge.strong) {
                self.tiles[tile(ridge)].push(ridge.strength);
            }
            for strengths in &mut self.tiles {
                upper_quartile_first(strengths);
            }
            for row in rows {
                let range = self.starts[row]..self.starts[row + 1];
                self.starts[row] = kept;
                for at in range {
                    let mut ridge = self.all[at];
                    let limit = share * self.tiles[tile(&ridge)].first().unwrap_or(&0.0);
                    ridge.strong &= ridge.strength > limit;
                    if ridge.strength > WEAK_SHARE * limit {
                        self.all[kept] = ridge;
                        kept += 1;
                    }
                }
            }
        }
        if let Some(last) = self.starts.last_mut() {
            *last = kept;
        }
    }
}

/// Puts the upper quartile of some values in the first place.
fn upper_quartile_first(values: &mut [f32]) {
    let at = values.len() * 3 / 4;
    if at < values.len() {
        values.select_nth_unstable_by(at, f32::total_cmp);
        values.swap(0, at);
    }
}

/// Standard deviation of the strength for independent noise of 1 per pixel.
fn kernel_norm(sigma: f64, smooth: f64) -> f32 {
    let root_pi = std::f64::consts::PI.sqrt();
    let across = (3.0 / (8.0 * root_pi * sigma)).sqrt();
    let along = (1.0 / (2.0 * root_pi * smooth)).sqrt();
    (across * along) as f32
}

/// The pass over one strip.
struct StripPass<'a> {
    pass: &'a Pass<'a>,
    family: Axis,
    rows: std::ops::Range<usize>,
    strip: &'a mut Strip,
}

impl NullaryFnOnce for StripPass<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        match self.family {
            Axis::Row => self.pass.flat(self.rows, self.strip),
            Axis::Column => self.pass.steep(self.rows, self.strip),
        }
    }
}

struct Pass<'a> {
    image: &'a GainImage,
    shrink: f32,
    along: Vec<f32>,
    across: Vec<f32>,
    sigma: f32,
    noise: f32,
    least: f32,
    /// Distances at which it must be dark beside a ridge, in pixels.
    beside: [usize; 2],
}

impl<'a> Pass<'a> {
    fn new(image: &'a GainImage, shrink: f32, width_px: f64, settings: &LineSettings) -> Self {
        let smooth = settings.smooth_along_px.clamp(0.5, 5.0);
        let sigma = (SIGMA_PER_WIDTH * width_px).max(0.8);
        Self {
            image,
            shrink,
            along: half_kernel(smooth, false),
            across: half_kernel(sigma, true),
            sigma: sigma as f32,
            noise: CORRELATED * settings.noise_sigma as f32 * kernel_norm(sigma, smooth),
            least: settings.share_of_full as f32 * FULL_STRENGTH,
            beside: BESIDE_WIDTHS.map(|widths| (widths * width_px).round() as usize),
        }
    }

    /// Steep lines: smoothed down the picture, differentiated along its rows.
    #[inline(always)]
    fn steep(&self, rows: std::ops::Range<usize>, strip: &mut Strip) {
        let (width, pad) = (self.image.gain.width(), self.across.len());
        let Strip {
            smooth,
            slopes: [slope, _],
            found,
        } = strip;
        for y in rows {
            smoothed_row(&self.image.gain, y, &self.along, pad, smooth);
            slope.resize(width, 0.0);
            convolve(slope, &self.across, Pair::Difference, |k| {
                (&smooth[pad - k..], &smooth[pad + k..])
            });
            let (gain, power) = (self.image.gain.row(y), self.image.power.row(y));
            self.falls(&slope[..width - 1], &slope[1..], |x, before, after| {
                let p = 0.5 * (power[x] + power[x + 1]);
                if self.stands_alone(x, width, |at| gain[at]) {
                    let at = x as f32 + 0.5;
                    found.extend(self.ridge(at, before, after, p).map(|ridge| (y, ridge)));
                }
            });
        }
    }

    /// Flat lines: differentiated down the picture, smoothed along its rows.
    #[inline(always)]
    fn flat(&self, rows: std::ops::Range<usize>, strip: &mut Strip) {
        let gain = &self.image.gain;
        let last = gain.height() - 1;
        let Strip {
            smooth,
            slopes: [upper, lower],
            found,
        } = strip;
        self.slope_down(rows.start, smooth, upper);
        for y in rows.start..rows.end.min(last) {
            self.slope_down(y + 1, smooth, lower);
            let power = (self.image.power.row(y), self.image.power.row(y + 1));
            self.falls(upper, lower, |x, before, after| {
                let p = 0.5 * (power.0[x] + power.1[x]);
                if self.stands_alone(y, last + 1, |at| gain.row(at)[x]) {
                    let at = y as f32 + 0.5;
                    found.extend(self.ridge(at, before, after, p).map(|ridge| (x, ridge)));
                }
            });
            std::mem::swap(upper, lower);
        }
    }

    #[inline(always)]
    fn slope_down(&self, y: usize, raw: &mut Vec<f32>, slope: &mut Vec<f32>) {
        let gain = &self.image.gain;
        let (width, pad) = (gain.width(), self.along.len());
        raw.resize(width + 2 * pad, 0.0);
        convolve(
            &mut raw[pad..pad + width],
            &self.across,
            Pair::Difference,
            |k| (gain.row(y.saturating_sub(k)), gain.row(y + k)),
        );
        pad_ends(raw, pad);
        slope.resize(width, 0.0);
        convolve(slope, &self.along, Pair::Sum, |k| {
            (&raw[pad - k..], &raw[pad + k..])
        });
    }

    /// Calls `at` where the slope falls through zero from `before` to `after` steeply enough for a weak ridge.
    #[inline(always)]
    fn falls(&self, before: &[f32], after: &[f32], mut at: impl FnMut(usize, f32, f32)) {
        const TOGETHER: usize = 16; // pixels that are looked at in one go: hardly any has a ridge
        let fall = WEAK_SHARE * self.least / (self.sigma * self.sigma);
        let is_ridge = |b: f32, a: f32| (b > 0.0) & (a <= 0.0) & (b - a > fall);
        let blocks = before.chunks(TOGETHER).zip(after.chunks(TOGETHER));
        for (block, (b, a)) in blocks.enumerate() {
            let any = b
                .iter()
                .zip(a)
                .fold(false, |any, (&b, &a)| any | is_ridge(b, a));
            if any {
                for (k, (&b, &a)) in b.iter().zip(a).enumerate() {
                    if is_ridge(b, a) {
                        at(block * TOGETHER + k, b, a);
                    }
                }
            }
        }
    }

    /// Whether it is dark on both sides of a ridge between pixels `at` and `at + 1`. Where another line
    /// crosses or comes near, one side is bright, and the ridge is drawn towards it.
    #[inline(always)]
    fn stands_alone(&self, at: usize, length: usize, gain: impl Fn(usize) -> f32) -> bool {
        let middle = gain(at).max(gain(at + 1));
        let limit = BESIDE_SHARE * middle;
        self.beside.iter().all(|&way| {
            let before = at.checked_sub(way).is_none_or(|at| gain(at) < limit);
            let after = at + 1 + way >= length || gain(at + 1 + way) < limit;
            before && after
        })
    }

    fn ridge(&self, at: f32, before: f32, after: f32, power: f32) -> Option<Ridge> {
        let strength = self.sigma * self.sigma * (before - after);
        let noise = self.noise * power.sqrt() / (power + self.shrink);
        (strength > WEAK_SHARE * noise).then(|| Ridge {
            across: at + before / (before - after),
            strength,
            strong: strength > self.least.max(noise),
        })
    }
}
