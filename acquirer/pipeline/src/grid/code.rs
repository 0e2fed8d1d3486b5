//! The pattern's symbols as the picture shows them: which family of lines carries which code, in which
//! direction.

use bumpalo::{Bump, collections::Vec as BumpVec};
use shared::pattern::{Axis, Grid, MAX_COLOURS};

/// How the pattern stands in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Orientation {
    /// The picture's flat lines are the pattern's columns.
    pub(super) swapped: bool,
    /// The picture's flat lines count upwards.
    pub(super) flip_flat: bool,
    /// The picture's steep lines count to the left.
    pub(super) flip_steep: bool,
}

impl Orientation {
    /// All eight, the likeliest first: upright, turned by 180, 90 and 270 degrees, then seen in a mirror.
    pub(super) const ALL: [Self; 8] = [
        Self::new(false, false, false),
        Self::new(false, true, true),
        Self::new(true, true, false),
        Self::new(true, false, true),
        Self::new(false, false, true),
        Self::new(false, true, false),
        Self::new(true, false, false),
        Self::new(true, true, true),
    ];

    const fn new(swapped: bool, flip_flat: bool, flip_steep: bool) -> Self {
        Self {
            swapped,
            flip_flat,
            flip_steep,
        }
    }

    /// The pattern's lines that a family of the picture shows.
    pub(super) fn pattern_axis(self, family: Axis) -> Axis {
        match (family, self.swapped) {
            (Axis::Row, false) | (Axis::Column, true) => Axis::Row,
            (Axis::Column, false) | (Axis::Row, true) => Axis::Column,
        }
    }

    pub(super) fn flipped(self, family: Axis) -> bool {
        match family {
            Axis::Row => self.flip_flat,
            Axis::Column => self.flip_steep,
        }
    }

    /// The code of a family, in the picture's order of counting.
    pub(super) fn code(self, grid: &Grid, family: Axis) -> Code {
        let symbols = grid.symbols(self.pattern_axis(family));
        let mut symbols: Vec<u8> = symbols.iter().map(|symbol| symbol.0).collect();
        if self.flipped(family) {
            symbols.reverse();
        }
        Code::new(symbols)
    }
}

/// The symbols of one family, in order.
#[derive(Debug, Clone)]
pub(super) struct Code {
    pub(super) symbols: Vec<u8>,
    /// Lines that say which lines they are: the shortest length whose windows all differ.
    pub(super) window: usize,
}

/// Evidence of one patch for each of its lines: summed nats per colour, and how many crossings gave it.
#[derive(Debug, Clone)]
pub(super) struct LineEvidence<'a> {
    nats: BumpVec<'a, [f32; MAX_COLOURS]>,
    count: BumpVec<'a, u32>,
}

impl<'a> LineEvidence<'a> {
    /// None yet.
    pub(super) fn new(bump: &'a Bump) -> Self {
        Self {
            nats: BumpVec::new_in(bump),
            count: BumpVec::new_in(bump),
        }
    }

    /// Forgets everything, but keeps the memory.
    pub(super) fn clear(&mut self) {
        self.nats.clear();
        self.count.clear();
    }

    pub(super) fn add(&mut self, line: usize, nats: &[f32; MAX_COLOURS]) {
        if self.count.len() <= line {
            self.nats.resize(line + 1, [0.0; MAX_COLOURS]);
            self.count.resize(line + 1, 0);
        }
        let pairs = self.nats[line].iter_mut().zip(nats);
        pairs.for_each(|(sum, value)| *sum += value);
        self.count[line] += 1;
    }

    /// Lines with any evidence.
    pub(super) fn lines(&self) -> usize {
        self.count.iter().filter(|&&count| count > 0).count()
    }
}

/// What a patch's lines say about its place in the code.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    /// Line number of the patch's line 0.
    pub(super) offset: i32,
    /// Log-likelihood.
    pub(super) nats: f32,
}

/// The likeliest first.
pub(super) fn sort_fits(fits: &mut [Fit]) {
    fits.sort_unstable_by(|a, b| b.nats.total_cmp(&a.nats).then(a.offset.cmp(&b.offset)));
}

impl Code {
    fn new(symbols: Vec<u8>) -> Self {
        let distinct = |m: usize| {
            let mut windows: Vec<&[u8]> = symbols.windows(m).collect();
            windows.sort_unstable();
            windows.windows(2).all(|pair| pair[0] != pair[1])
        };
        let window = (1..symbols.len())
            .find(|&m| distinct(m))
            .unwrap_or(symbols.len());
        Self { symbols, window }
    }

    /// Every place of the lines in the code, likeliest first. Lines beyond the code's ends cost
    /// `outside_nats` for each crossing on them.
    pub(super) fn places<'a>(
        &self,
        lines: &LineEvidence<'_>,
        outside_nats: f32,
        bump: &'a Bump,
    ) -> BumpVec<'a, Fit> {
        let (count, total) = (lines.count.len() as i32, self.symbols.len() as i32);
        let places = (1 - count..total).map(|offset| Fit {
            offset,
            nats: self.fit(lines, offset, outside_nats),
        });
        let mut fits = BumpVec::from_iter_in(places, bump);
        sort_fits(&mut fits);
        fits
    }

    /// The likeliest place, and its lead over the second in nats; `None` for a code without symbols.
    pub(super) fn best_place(
        &self,
        lines: &LineEvidence<'_>,
        outside_nats: f32,
    ) -> Option<(i32, f32)> {
        let (count, total) = (lines.count.len() as i32, self.symbols.len() as i32);
        let mut best: Option<(i32, f32)> = None;
        let mut second = f32::MIN;
        for offset in 1 - count..total {
            let nats = self.fit(lines, offset, outside_nats);
            match best {
                Some((_, most)) if nats <= most => second = second.max(nats),
                _ => {
                    second = best.map_or(second, |(_, most)| most);
                    best = Some((offset, nats));
                }
            }
        }
        best.map(|(offset, nats)| (offset, nats - second))
    }

    fn fit(&self, lines: &LineEvidence<'_>, offset: i32, outside_nats: f32) -> f32 {
        let mut sum = 0.0;
        for (line, (nats, &count)) in lines.nats.iter().zip(&lines.count).enumerate() {
            sum += match self.symbol(line as i32 + offset) {
                Some(symbol) => nats[usize::from(symbol)],
                None => -outside_nats * count as f32,
            };
        }
        sum
    }

    pub(super) fn symbol(&self, line: i32) -> Option<u8> {
        let line = usize::try_from(line).ok()?;
        self.symbols.get(line).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::pattern::Rgb;

    fn grid(lines: usize, colours: usize) -> Grid {
        let colours: Vec<Rgb> = (0..colours).map(|k| Rgb([k as u8, 0, 0])).collect();
        Grid::coded(lines, lines, 2, 2, &colours).unwrap()
    }

    #[test]
    fn the_window_is_the_order_of_the_sequence() {
        for (lines, colours, window) in
            [(15, 4, 2), (63, 4, 3), (255, 4, 4), (15, 2, 4), (255, 2, 8)]
        {
            let code = Orientation::ALL[0].code(&grid(lines, colours), Axis::Row);
            assert_eq!(code.window, window, "{lines} lines, {colours} colours");
        }
    }

    #[test]
    fn a_piece_of_the_code_is_found_where_it_stands_also_with_one_wrong_colour() {
        let code = Orientation::ALL[0].code(&grid(63, 4), Axis::Column);
        let bump = Bump::new();
        let mut lines = LineEvidence::new(&bump);
        for line in 0..9 {
            let seen = if line == 4 {
                3 - code.symbols[24]
            } else {
                code.symbols[20 + line]
            };
            let mut nats = [-8.0; MAX_COLOURS];
            nats[usize::from(seen)] = 0.0;
            lines.add(line, &nats);
        }
        let places = code.places(&lines, 10.0, &bump);
        assert_eq!(places[0].offset, 20);
        assert!(places[0].nats - places[1].nats > 9.2);
    }
}
