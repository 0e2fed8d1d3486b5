//! Where the picture's rows cross the middles of steep lines, and its columns those of flat ones.
//!
//! Both families are looked for in the picture as it lies in memory, strip by strip: averaged along the lines,
//! differentiated across them, and every fall through zero that is steep enough and stands alone is a ridge.

use pulp::NullaryFnOnce;
use rayon::prelude::*;
use shared::pattern::Axis;

use super::{
    LineSettings, Sampling,
    along::AlongKernel,
    boxes::{BLOCK, Boxes, DownSlopes, box_sums},
    limit::{RidgeLimit, strength_per_fall},
    ridge_rows::{Lattice, RidgeRows},
};
use crate::{
    gain::{GainImage, power_of},
    wide::wide,
};

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
const STRIP: usize = 64;

/// What one thread works with, kept between frames.
#[derive(Debug, Clone, Default)]
pub(super) struct Strip {
    smooth: Vec<f32>,
    sums: Vec<f32>,
    spare: Vec<f32>,
    slopes: DownSlopes,
    /// 1 where the derivative falls through zero.
    marks: Vec<u8>,
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
    let most = strips.max(ridges.strips.len()); // the other family may need more of them
    ridges.strips.resize_with(most, Strip::default);
    ridges.strips.iter_mut().for_each(|s| s.found.clear());
    let strips = ridges.strips[..strips].par_iter_mut().enumerate();
    strips.for_each(|(k, strip)| {
        if width >= 3 && height >= 3 && along > 0 {
            wide(StripPass {
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

impl NullaryFnOnce for StripPass<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        match self.pass.family {
            Axis::Row => self.pass.flat(self.first, self.strip),
            Axis::Column => self.pass.steep(self.first, self.strip),
        }
    }
}

struct Pass<'a> {
    image: &'a GainImage,
    family: Axis,
    boxes: Boxes,
    along: AlongKernel,
    limit: RidgeLimit,
    /// A ridge of this strength is strong whatever the noise there.
    enough: f32,
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
            enough: limit.always_enough(),
            least_fall: WEAK_SHARE * limit.least / strength_per_fall,
            strength_per_fall,
            beside: BESIDE_WIDTHS.map(|widths| (widths * width).round() as usize),
        }
    }

    /// Steep lines: averaged down the picture, differentiated along its rows.
    #[inline(always)]
    fn steep(&self, first: usize, strip: &mut Strip) {
        let (width, pad) = (self.image.gain.width(), self.boxes.pad());
        let Strip {
            smooth,
            sums,
            spare,
            marks,
            found,
            ..
        } = strip;
        let samples = self.image.gain.height() / self.along.step;
        for row in [&mut *smooth, &mut *sums, &mut *spare] {
            row.resize(width + 2 * pad, 0.0);
        }
        let slopes = width + 2 * pad - self.boxes.reach();
        marks.resize(slopes - 1, 0);
        for sample in first..(first + STRIP).min(samples) {
            let above = sample * self.along.step;
            let rows = |k: usize| self.image.gain.row((above + k).saturating_sub(1));
            self.along.sum_rows(rows, &mut smooth[pad..pad + width]);
            pad_ends(smooth, pad);
            box_sums(smooth, spare, self.boxes.side);
            box_sums(spare, sums, self.boxes.side);
            difference(&sums[self.boxes.side..], sums, &mut spare[..slopes]);
            let power = self.image.power.row(self.along.middle(sample));
            self.mark_falls((&spare[..slopes - 1], &spare[1..slopes]), marks);
            each_marked(marks, |at| {
                if self.stands_alone(at, width, |k| smooth[pad + k]) {
                    let across = self.position(at, spare[at], spare[at + 1]);
                    let power = || power_of(power[(across as usize).min(width - 1)]);
                    let ridge = self.ridge(across, spare[at] - spare[at + 1], power);
                    found.extend(ridge.map(|ridge| (sample as u32, ridge)));
                }
            });
        }
    }

    /// Flat lines: averaged along the picture's rows, differentiated down it, block of columns by block.
    #[inline(always)]
    fn flat(&self, first: usize, strip: &mut Strip) {
        let gain = &self.image.gain;
        let samples = gain.width() / self.along.step;
        let (pad, side, reach) = (self.boxes.pad(), self.boxes.side, self.boxes.reach());
        let rows = gain.height() + 2 * pad - reach - 1;
        let count = rows.saturating_sub(first).min(STRIP);
        // rows above and below those of the derivatives, for what lies beside a ridge and for the last step down
        let margin = (self.beside[1] + 1).saturating_sub(reach / 2).max(1);
        let rows = count + 1 + reach + 2 * margin;
        let Strip {
            smooth,
            slopes,
            marks,
            found,
            ..
        } = strip;
        smooth.resize(rows * BLOCK, 0.0);
        marks.resize(BLOCK, 0);
        for block in (0..samples).step_by(BLOCK) {
            let columns = BLOCK.min(samples - block);
            for (k, out) in smooth.chunks_exact_mut(BLOCK).enumerate() {
                let y = (first + k).saturating_sub(pad + margin);
                let out = &mut out[..columns];
                self.along.sum_along(gain.row(y), block, out);
            }
            slopes.begin(&smooth[margin * BLOCK..], side);
            for k in 0..count {
                slopes.go_down(&smooth[(margin + k) * BLOCK..], side);
                let (upper, lower) = slopes.before_and_after();
                self.mark_falls((upper, lower), marks);
                each_marked(&marks[..columns], |column| {
                    let at = |y: usize| smooth[(y + pad + margin - first) * BLOCK + column];
                    if self.stands_alone(first + k, gain.height(), at) {
                        let (before, after) = (upper[column], lower[column]);
                        let across = self.position(first + k, before, after);
                        let sample = block + column;
                        let power = || {
                            let last = gain.height() - 1;
                            let row = self.image.power.row((across as usize).min(last));
                            power_of(row[self.along.middle(sample)])
                        };
                        let ridge = self.ridge(across, before - after, power);
                        found.extend(ridge.map(|ridge| (sample as u32, ridge)));
                    }
                });
            }
        }
    }

    /// Marks where the derivative falls through zero, from `before` to `after`, steeply enough for a weak ridge.
    #[inline(always)]
    fn mark_falls(&self, (before, after): (&[f32], &[f32]), marks: &mut [u8]) {
        let least = self.least_fall;
        for ((mark, &before), &after) in marks.iter_mut().zip(before).zip(after) {
            let falls = (before > 0.0) & (after <= 0.0) & (before - after > least);
            *mark = u8::from(falls);
        }
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

    /// The ridge of a fall if it is strong enough for the `power` there, which seldom has to be looked at.
    #[inline(always)]
    fn ridge(&self, across: f32, fall: f32, power: impl Fn() -> f32) -> Option<Ridge> {
        let strength = self.strength_per_fall * fall;
        let (kept, strong) = if strength > self.enough {
            (true, true)
        } else {
            let power = power();
            let noise = self.limit.above_noise(power);
            let strong = strength > self.limit.strength(power);
            (strength > WEAK_SHARE * noise, strong)
        };
        kept.then_some(Ridge {
            across: across * self.image.bin as f32,
            strength,
            strong,
        })
    }
}

/// Hardly any pixel is on a ridge: looks at eight marks at once.
#[inline(always)]
fn each_marked(marks: &[u8], mut look_at: impl FnMut(usize)) {
    let (eights, rest) = marks.as_chunks::<8>();
    for (n, &eight) in eights.iter().enumerate() {
        let mut bits = u64::from_le_bytes(eight);
        while bits != 0 {
            look_at(8 * n + bits.trailing_zeros() as usize / 8);
            bits &= bits - 1; // a mark has one bit
        }
    }
    let marked = rest.iter().enumerate().filter(|(_, mark)| **mark != 0);
    marked.for_each(|(k, _)| look_at(8 * eights.len() + k));
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
