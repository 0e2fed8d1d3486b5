//! Red, green and blue light as pictures, also at coarser resolutions.
//!
//! A coarser picture holds the means of squares of pixels; it is made when first asked for, and kept: the
//! references of a scene are the same for every frame.

use std::{
    ops::{Index, Range},
    sync::OnceLock,
};

use rayon::prelude::*;

use super::{plane::Plane, region::Region};

/// Longest side of the squares that coarser pictures are made of, in camera pixels.
pub(super) const MOST_BIN: usize = 8;

/// One picture per channel, all of one size; `channels[0]` is red.
#[derive(Debug, Clone, Default)]
pub struct Channels {
    planes: [Plane; 3],
    /// With squares of 2, 3 .. [`MOST_BIN`] pixels a side.
    coarser: [OnceLock<Box<[Plane; 3]>>; MOST_BIN - 1],
}

impl Channels {
    /// The pictures of red, green and blue.
    #[must_use]
    pub fn new(planes: [Plane; 3]) -> Self {
        Self {
            planes,
            coarser: Default::default(),
        }
    }

    /// The means of squares of `bin` x `bin` pixels, 1 to [`MOST_BIN`]; what is left over at the right and lower
    /// border is left out.
    pub(super) fn coarse(&self, bin: usize) -> &[Plane; 3] {
        match bin.checked_sub(2) {
            None => &self.planes,
            Some(at) => self.coarser[at.min(MOST_BIN - 2)]
                .get_or_init(|| Box::new(self.planes.each_ref().map(|plane| binned(plane, bin)))),
        }
    }

    /// Dark pictures of the given width and height.
    pub(super) fn dark((width, height): (usize, usize)) -> Self {
        Self::new(std::array::from_fn(|_| Plane::filled(width, height, 0.0)))
    }

    /// Width and height.
    pub(super) fn size(&self) -> (usize, usize) {
        (self.planes[0].width(), self.planes[0].height())
    }

    /// Red, green and blue of a pixel, numbered row by row.
    #[inline]
    pub(super) fn at(&self, at: usize) -> [f32; 3] {
        self.planes.each_ref().map(|plane| plane.values()[at])
    }

    /// Lets some parts be written one after the other; the coarser pictures follow in the memory that they have.
    pub(super) fn write(
        &mut self,
        regions: &[Region],
        mut write: impl FnMut(&mut [Plane; 3], &Region),
    ) {
        for region in regions {
            write(&mut self.planes, region);
        }
        for (bin, coarser) in (2..).zip(&mut self.coarser) {
            let Some(coarser) = coarser.get_mut() else {
                continue;
            };
            for (plane, coarse) in self.planes.iter().zip(coarser.iter_mut()) {
                let (width, height) = (coarse.width(), coarse.height());
                for region in regions {
                    let columns = squares(&region.columns, bin, width);
                    for y in squares(&region.rows, bin, height) {
                        let row = &mut coarse.values_mut()[y * width..(y + 1) * width];
                        bin_row((plane, bin), (y, columns.start), &mut row[columns.clone()]);
                    }
                }
            }
        }
    }

    /// Takes some parts over from other pictures of the same size.
    pub(super) fn copy(&mut self, from: &Self, regions: &[Region]) {
        let width = self.planes[0].width();
        self.write(regions, |planes, region| {
            for (plane, from) in planes.iter_mut().zip(&from.planes) {
                for y in region.rows.clone() {
                    let row = y * width + region.columns.start..y * width + region.columns.end;
                    plane.values_mut()[row.clone()].copy_from_slice(&from.values()[row]);
                }
            }
        });
    }

    /// All three, to be written.
    pub(super) fn planes_mut(&mut self) -> &mut [Plane; 3] {
        self.coarser = Default::default();
        &mut self.planes
    }
}

impl Index<usize> for Channels {
    type Output = Plane;

    fn index(&self, channel: usize) -> &Plane {
        &self.planes[channel]
    }
}

fn binned(plane: &Plane, bin: usize) -> Plane {
    let (width, height) = (plane.width() / bin, plane.height() / bin);
    let mut out = Plane::filled(width, height, 0.0);
    let rows = out.values_mut().par_chunks_mut(width.max(1));
    rows.enumerate()
        .for_each(|(y, means)| bin_row((plane, bin), (y, 0), means));
    out
}

/// The squares of `bin` pixels a side, of `count`, that hold some pixels.
fn squares(pixels: &Range<usize>, bin: usize, count: usize) -> Range<usize> {
    (pixels.start / bin).min(count)..pixels.end.div_ceil(bin).min(count)
}

/// The means of neighbouring squares of the `y`-th row of squares, from the `first` one on.
fn bin_row((plane, bin): (&Plane, usize), (y, first): (usize, usize), means: &mut [f32]) {
    let share = 1.0 / (bin * bin) as f32;
    means.fill(0.0);
    for row in y * bin..(y + 1) * bin {
        let squares = plane.row(row)[first * bin..].chunks_exact(bin);
        for (mean, square) in means.iter_mut().zip(squares) {
            *mean += share * square.iter().sum::<f32>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarser_picture_holds_means_and_follows_what_is_written() {
        let mut plane = Plane::filled(5, 2, 1.0);
        plane.values_mut()[0] = 5.0;
        let mut channels = Channels::new([plane.clone(), plane.clone(), plane]);
        let coarse = &channels.coarse(2)[1];
        assert_eq!((coarse.width(), coarse.height()), (2, 1));
        assert_eq!(coarse.values(), [2.0, 1.0]);
        let region = Region {
            columns: 0..1,
            rows: 0..1,
        };
        channels.write(&[region], |planes, _| planes[1].values_mut()[0] = 1.0);
        assert_eq!(channels.coarse(2)[1].values(), [1.0, 1.0]);
        assert_eq!(channels.coarse(2)[0].values(), [2.0, 1.0]);
    }
}
