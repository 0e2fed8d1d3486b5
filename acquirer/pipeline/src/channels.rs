//! Red, green and blue light as pictures, also at coarser resolutions.
//!
//! A coarser picture holds the means of squares of pixels; it is made when first asked for, and kept: the
//! references of a scene are the same for every frame.

use std::{
    ops::{Index, IndexMut},
    sync::OnceLock,
};

use rayon::prelude::*;

use super::plane::Plane;

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

impl IndexMut<usize> for Channels {
    fn index_mut(&mut self, channel: usize) -> &mut Plane {
        &mut self.planes_mut()[channel]
    }
}

fn binned(plane: &Plane, bin: usize) -> Plane {
    let (width, height) = (plane.width() / bin, plane.height() / bin);
    let mut out = Plane::filled(width, height, 0.0);
    let share = 1.0 / (bin * bin) as f32;
    let rows = out.values_mut().par_chunks_mut(width.max(1));
    rows.enumerate().for_each(|(y, sums)| {
        for row in y * bin..(y + 1) * bin {
            let squares = plane.row(row).chunks_exact(bin);
            for (sum, square) in sums.iter_mut().zip(squares) {
                *sum += share * square.iter().sum::<f32>();
            }
        }
    });
    out
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
        channels[1].values_mut()[0] = 1.0;
        assert_eq!(channels.coarse(2)[1].values(), [1.0, 1.0]);
    }
}
