//! Where the picture's rows cross the middles of steep lines, and its columns those of flat ones.
//!
//! Both families are looked for in the picture as it lies in memory, strip by strip: averaged along the lines,
//! differentiated across them, and every fall through zero that is steep enough and stands alone is a ridge.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use shared::pattern::Axis;

use super::{
    LineSettings, Sampling,
    along::AlongKernel,
    boxes::{BLOCK, Boxes, box_sums, down_sums},
    limit::{RidgeLimit, strength_per_fall},
    ridge_rows::{Lattice, RidgeRows},
};
use crate::gain::GainImage;

/// A point on the middle of a line, in one sample along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ridge {
    /// Position across the line, camera pixels, edge coordinates.
    pub across: f32,
    /// How sharply the gain bends there: -s^2 g'', about 0.5 on a full line.
    pub strength: f32,
    /// Strong enough to begin a track; a weaker one only continues one.
    pub strong: bool,
}

/// A ridge that continues a track may have this share of the strength of one that begins it.
pub(super) const WEAK_SHARE: f32 = 0.5;

/// Where it must be dark beside a ridge, in line widths from its middle.
const BESIDE_WIDTHS: [f64; 2] = [1.0, 1.3];
/// Largest share of the ridge's own gain that counts as dark beside it.
const BESIDE_SHARE: f32 = 0.5;

/// Derivatives (down the picture) or samples (along steep lines) that one thread takes at a time.
const STRIP: usize = 48;

/// Most values in one of the processor's registers.
const MOST_LANES: usize = 16;

/// What one thread works with, kept between frames.
#[derive(Debug, Clone, Default)]
pub(super) struct Strip {
    smooth: Vec<f32>,
    sums: Vec<f32>,
    spare: Vec<f32>,
    slopes: [Vec<f32>; 2],
    falls: Vec<usize>,
    /// Ridges and their sample along the line.
    pub(super) found: Vec<(u32, Ridge)>,
}

/// Finds the ridges of one family: flat lines along x, steep ones along y.
pub(super) fn find_ridges(
    ridges: &mut RidgeRows,
    image: &GainImage,
    search: &Search<'_>,
    sampling: &Sampling,
) {
    let (width, height) = (image.gain.width(), image.gain.height());
    let (along, across) = match search.family {
        Axis::Row => (width / sampling.step, height),
        Axis::Column => (height / sampling.step, width),
    };
    let pass = Pass::new(image, search, sampling);
    let strips = match search.family {
        Axis::Row => (height + 1).div_ceil(STRIP),
        Axis::Column => along.div_ceil(STRIP),
    };
    ridges.strips.resize_with(strips, Strip::default);
    let strips = ridges.strips.par_iter_mut().enumerate();
    strips.for_each(|(k, strip)| {
        strip.found.clear();
        if width >= 3 && height >= 3 && along > 0 {
            Arch::new().dispatch(StripPass {
                pass: &pass,
                first: k * STRIP,
                strip,
            });
        }
    });
    let lattice = Lattice {
        along,
        across_px: across * sampling.bin,
        spacing_px: sampling.spacing_px(),
    };
    ridges.gather(lattice, search.settings);
}

/// What is looked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) family: Axis,
    /// Width of the lines across, in camera pixels.
    pub(super) width_px: f64,
    /// The gain image's pull towards 0.
    pub(super) shrink: f32,
    pub(super) settings: &'a LineSettings,
}

/// The pass over one strip.
struct StripPass<'a> {
    pass: &'a Pass<'a>,
    first: usize,
    strip: &'a mut Strip,
}

impl WithSimd for StripPass<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self.pass.family {
            Axis::Row => self.pass.flat(simd, self.first, self.strip),
            Axis::Column => self.pass.steep(simd, self.first, self.strip),
        }
    }
}

struct Pass<'a> {
    image: &'a GainImage,
    family: Axis,
    boxes: Boxes,
    along: AlongKernel,
    limit: RidgeLimit,
    /// Smallest fall of the raw derivative that may be a ridge.
    least_fall: f32,
    strength_per_fall: f32,
    /// Distances at which it must be dark beside a ridge, in the image's pixels.
    beside: [usize; 2],
}

impl<'a> Pass<'a> {
    fn new(image: &'a GainImage, search: &Search<'_>, sampling: &Sampling) -> Self {
        let width = search.width_px / sampling.bin as f64;
        let (boxes, step) = (Boxes::for_width(width), sampling.step);
        let along = AlongKernel { step };
        let limit = RidgeLimit::new(width, step, search.shrink, search.settings);
        let strength_per_fall = strength_per_fall(boxes, along);
        Self {
            image,
            family: search.family,
            boxes,
            along,
            limit,
            least_fall: WEAK_SHARE * limit.least / strength_per_fall,
            strength_per_fall,
            beside: BESIDE_WIDTHS.map(|widths| (widths * width).round() as usize),
        }
    }

    /// Steep lines: averaged down the picture, differentiated along its rows.
    #[inline(always)]
    fn steep<S: Simd>(&self, simd: S, first: usize, strip: &mut Strip) {
        let (width, pad) = (self.image.gain.width(), self.boxes.pad());
        let Strip {
            smooth,
            sums,
            spare,
            falls,
            found,
            ..
        } = strip;
        let samples = self.image.gain.height() / self.along.step;
        for row in [&mut *smooth, &mut *sums, &mut *spare] {
            row.resize(width + 2 * pad, 0.0);
        }
        let slopes = width + 2 * pad - self.boxes.reach();
        for sample in first..(first + STRIP).min(samples) {
            let above = sample * self.along.step;
            let rows = |k: usize| self.image.gain.row((above + k).saturating_sub(1));
            self.along.sum_rows(rows, &mut smooth[pad..pad + width]);
            pad_ends(smooth, pad);
            sums.copy_from_slice(smooth);
            box_sums(sums, spare, self.boxes.side);
            box_sums(sums, spare, self.boxes.side);
            difference(&sums[self.boxes.side..], sums, &mut spare[..slopes]);
            let power = self.image.power.row(self.along.middle(sample));
            self.falls(simd, (&spare[..slopes - 1], &spare[1..slopes]), falls);
            for &at in &*falls {
                if self.stands_alone(at, width, |k| smooth[pad + k]) {
                    let across = self.position(at, spare[at], spare[at + 1]);
                    let power = power[(across as usize).min(width - 1)];
                    let ridge = self.ridge(across, spare[at] - spare[at + 1], power);
                    found.extend(ridge.map(|ridge| (sample as u32, ridge)));
                }
            }
        }
    }

    /// Flat lines: averaged along the picture's rows, differentiated down it, block of columns by block.
    #[inline(always)]
    fn flat<S: Simd>(&self, simd: S, first: usize, strip: &mut Strip) {
        let gain = &self.image.gain;
        let samples = gain.width() / self.along.step;
        let (pad, side, reach) = (self.boxes.pad(), self.boxes.side, self.boxes.reach());
        let rows = gain.height() + 2 * pad - reach - 1;
        let count = rows.saturating_sub(first).min(STRIP);
        // rows above and below those of the derivatives, for what lies beside a ridge
        let margin = (self.beside[1] + 1).saturating_sub(reach / 2);
        let rows = count + 1 + reach + 2 * margin;
        let Strip {
            smooth,
            sums,
            spare: padded,
            slopes: [upper, lower],
            falls,
            found,
        } = strip;
        smooth.resize(rows * BLOCK, 0.0);
        sums.resize(rows * BLOCK, 0.0);
        upper.resize(BLOCK, 0.0);
        lower.resize(BLOCK, 0.0);
        for block in (0..samples).step_by(BLOCK) {
            let columns = BLOCK.min(samples - block);
            for (k, out) in smooth.chunks_exact_mut(BLOCK).enumerate() {
                let y = (first + k).saturating_sub(pad + margin);
                let out = &mut out[..columns];
                self.along.sum_along(gain.row(y), block, padded, out);
            }
            let inner = &mut sums[margin * BLOCK..];
            inner.copy_from_slice(&smooth[margin * BLOCK..]);
            down_sums(inner, side);
            down_sums(inner, side);
            let row = |k: usize| &inner[k * BLOCK..(k + 1) * BLOCK];
            difference(row(side), row(0), upper);
            for k in 0..count {
                difference(row(k + 1 + side), row(k + 1), lower);
                self.falls(simd, (&upper[..columns], &lower[..columns]), falls);
                for &column in &*falls {
                    let at = |y: usize| smooth[(y + pad + margin - first) * BLOCK + column];
                    if self.stands_alone(first + k, gain.height(), at) {
                        let (before, after) = (upper[column], lower[column]);
                        let across = self.position(first + k, before, after);
                        let sample = block + column;
                        let power = self.image.power.row(across as usize);
                        let power = power[self.along.middle(sample)];
                        let ridge = self.ridge(across, before - after, power);
                        found.extend(ridge.map(|ridge| (sample as u32, ridge)));
                    }
                }
                std::mem::swap(upper, lower);
            }
        }
    }

    /// Notes where the derivative falls through zero, from `before` to `after`, steeply enough for a weak ridge.
    #[inline(always)]
    fn falls<S: Simd>(&self, simd: S, (before, after): (&[f32], &[f32]), falls: &mut Vec<usize>) {
        let least = simd.splat_f32s(self.least_fall);
        let (zero, one) = (simd.splat_f32s(0.0), simd.splat_f32s(1.0));
        let (befores, rest) = S::as_simd_f32s(before);
        let (afters, _) = S::as_simd_f32s(after);
        let lanes = S::F32_LANES;
        falls.clear();
        for (n, (&before, &after)) in befores.iter().zip(afters).enumerate() {
            let steep = simd.greater_than_f32s(simd.sub_f32s(before, after), least);
            let rises = simd.greater_than_f32s(before, zero);
            let sinks = simd.less_than_or_equal_f32s(after, zero);
            let ridges = simd.and_m32s(rises, simd.and_m32s(sinks, steep));
            let marks = simd.select_f32s(ridges, one, zero);
            // hardly any pixel is on a ridge
            if simd.reduce_max_f32s(marks) > 0.0 {
                let mut marked = [0.0; MOST_LANES];
                simd.partial_store_f32s(&mut marked[..lanes], marks);
                let on = (0..lanes).filter(|&lane| marked[lane] > 0.0);
                falls.extend(on.map(|lane| n * lanes + lane));
            }
        }
        let is_fall = |&k: &usize| {
            let (before, after) = (before[k], after[k]);
            before > 0.0 && after <= 0.0 && before - after > self.least_fall
        };
        falls.extend((before.len() - rest.len()..before.len()).filter(is_fall));
    }

    /// Position of a fall across, in the image's pixels, edge coordinates.
    #[inline(always)]
    fn position(&self, at: usize, before: f32, after: f32) -> f32 {
        let first = at as f32 + self.boxes.middle() - self.boxes.pad() as f32;
        first + before / (before - after)
    }

    /// Whether it is dark on both sides of the ridge at a fall. Where another line crosses or comes near, one side
    /// is bright, and the ridge is drawn towards it.
    #[inline(always)]
    fn stands_alone(&self, at: usize, length: usize, gain: impl Fn(usize) -> f32) -> bool {
        // boxes of even length put it between two pixels, of odd length on one
        let (low, high) = (
            at.min(length - 1),
            (at + 1 - self.boxes.side % 2).min(length - 1),
        );
        let limit = BESIDE_SHARE * gain(low).max(gain(high));
        self.beside.iter().all(|&way| {
            let before = low.checked_sub(way).is_none_or(|k| gain(k) < limit);
            let after = high + way >= length || gain(high + way) < limit;
            before && after
        })
    }

    #[inline(always)]
    fn ridge(&self, across: f32, fall: f32, power: f32) -> Option<Ridge> {
        let strength = self.strength_per_fall * fall;
        let noise = self.limit.above_noise(power);
        (strength > WEAK_SHARE * noise).then(|| Ridge {
            across: across * self.image.bin as f32,
            strength,
            strong: strength > self.limit.strength(power),
        })
    }
}

/// What the first row has more than the second, as far as `out` reaches.
#[inline(always)]
fn difference(more: &[f32], less: &[f32], out: &mut [f32]) {
    let pairs = out.iter_mut().zip(more.iter().zip(less));
    pairs.for_each(|(out, (more, less))| *out = more - less);
}

/// Fills what lies before and behind the middle of a padded row with the middle's ends.
#[inline(always)]
fn pad_ends(row: &mut [f32], pad: usize) {
    let end = row.len() - pad;
    let (first, last) = (row[pad], row[end - 1]);
    row[..pad].fill(first);
    row[end..].fill(last);
}
