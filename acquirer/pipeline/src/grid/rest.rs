//! What the patches left: crossings whose piece of the grid is too small for its colours alone.
//!
//! Takes the crossings without a label, linked along lines also where no cell closes, and the labelled ones beside
//! them; gives each connected piece the place in both codes that its colours, its epipolar lines and its labelled
//! neighbours together leave, with the same margin as a patch. A place that a labelled crossing already has is
//! taken, and given again only if all else contradicts. Needs the epipolar geometry, calibrated or told by the labels themselves; a piece that lies beside its
//! place along the epipolar lines and has its colours is placed wrongly, quietly.

use std::collections::BTreeSet;

use shared::pattern::Axis;

use super::{
    labels::{Decoder, Label},
    links::{Link, Patch, patches_of},
};

/// Numbers of a crossing's flat and steep line, in the picture's order of counting.
pub(super) type Numbers = (i32, i32);

/// Places in the code whose colours fit so much worse than the best are not looked at, nats: more than a margin.
const HOPELESS_NATS: f32 = 15.0;

/// Labels for crossings that have none. `known` has the numbers of those that have, `links` all links between
/// neighbours.
pub(super) fn label_rest(
    decoder: &Decoder<'_>,
    known: &[Option<Numbers>],
    links: &[Link],
) -> Vec<(usize, Label)> {
    let free = |node: usize| known[node].is_none();
    let among: Vec<Link> = links
        .iter()
        .copied()
        .filter(|link| free(link.a) && free(link.b))
        .collect();
    let rest = Rest {
        decoder,
        taken: known.iter().copied().flatten().collect(),
        beside: implied(known, links),
    };
    let (among, patches) = patches_of(among, known.len());
    let decoder = Decoder {
        links: &among,
        ..*decoder
    };
    let alone = (0..known.len())
        .filter(|&node| free(node) && !patches.iter().any(|p| p.nodes.contains(&node)))
        .map(Patch::single);
    let parts = patches.iter().flat_map(|patch| decoder.parts(patch));
    parts
        .chain(alone)
        .flat_map(|part| rest.label(&part))
        .collect()
}

/// For each crossing the numbers that its labelled neighbours give it.
fn implied(known: &[Option<Numbers>], links: &[Link]) -> Vec<Vec<Numbers>> {
    let mut implied = vec![Vec::new(); known.len()];
    for link in links {
        for (from, to, step) in [(link.a, link.b, 1), (link.b, link.a, -1)] {
            if let (Some((flat, steep)), None) = (known[from], known[to]) {
                implied[to].push(match link.along {
                    Axis::Row => (flat, steep + step),
                    Axis::Column => (flat + step, steep),
                });
            }
        }
    }
    implied
}

struct Rest<'a> {
    decoder: &'a Decoder<'a>,
    taken: BTreeSet<Numbers>,
    beside: Vec<Vec<Numbers>>,
}

impl Rest<'_> {
    fn label(&self, part: &Patch) -> Vec<(usize, Label)> {
        let Some((offsets, certainty)) = self.place(part) else {
            return Vec::new();
        };
        let label = |(node, place)| {
            let label = self.decoder.label_one(node, place, offsets, certainty);
            (node, label)
        };
        part.members().map(label).collect()
    }

    fn place(&self, part: &Patch) -> Option<([i32; 2], f64)> {
        let decoder = self.decoder;
        let places = Axis::BOTH.map(|family| {
            let lines = decoder.evidence(family, part.members());
            let mut places = decoder.places(family, part, &lines);
            let least = places.first().map_or(0.0, |fit| fit.nats) - HOPELESS_NATS;
            places.retain(|fit| fit.nats > least);
            (lines.lines(), places)
        });
        let [(flat_lines, flat), (steep_lines, steep)] = places;
        let window = decoder.window();
        let has_neighbour = part.nodes.iter().any(|&node| !self.beside[node].is_empty());
        // in a long code a few crossings find a place of their colours by chance
        if !has_neighbour && (part.nodes.len() <= window || flat_lines + steep_lines < 2 * window) {
            return None;
        }
        let nats = |[a, b]: [i32; 2], colours: f32| {
            colours - decoder.epipolar_cost(part, [a, b]) - self.neighbour_cost(part, [a, b])
        };
        let pairs = flat.iter().flat_map(|a| {
            steep
                .iter()
                .map(move |b| ([a.offset, b.offset], a.nats + b.nats))
        });
        decoder.clearly_best(
            part,
            pairs.map(|(offsets, colours)| (nats(offsets, colours), offsets)),
        )
    }

    /// What the labelled neighbours speak against these offsets, and places that are taken, in nats.
    fn neighbour_cost(&self, part: &Patch, [flat, steep]: [i32; 2]) -> f32 {
        let settings = self.decoder.settings;
        let cost = |(node, place): (usize, (i32, i32))| {
            let numbers = (place.0 + flat, place.1 + steep);
            let others = self.beside[node].iter().filter(|&&n| n != numbers).count();
            let taken = f64::from(u8::from(self.taken.contains(&numbers)));
            settings.cut_nats * others as f64 + 2.0 * settings.margin_nats * taken
        };
        part.members().map(cost).sum::<f64>() as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        colours::{Colours, Evidence},
        grid::{DecodeSettings, code::Orientation},
    };
    use shared::pattern::{Grid, MAX_COLOURS, Rgb};

    /// A column of crossings, the first in row 4, column 9, that look like what the code has there.
    struct Chain {
        colours: Colours,
        links: Vec<Link>,
        known: Vec<Option<Numbers>>,
    }

    fn grid() -> Grid {
        let colours: Vec<Rgb> = (0..4).map(|k| Rgb([k, 0, 0])).collect();
        Grid::coded(15, 15, 2, 2, &colours).unwrap()
    }

    fn chain(length: usize) -> Chain {
        let grid = grid();
        let evidence = |axis, line: usize| {
            let mut nats = [-8.0; MAX_COLOURS];
            nats[usize::from(grid.symbols(axis)[line].0)] = 0.0;
            Evidence {
                nats,
                ratio: [0.5; 3],
                signal: 20.0,
                clipped: 0.0,
            }
        };
        Chain {
            colours: Colours {
                rows: (0..length).map(|k| evidence(Axis::Row, 4 + k)).collect(),
                columns: (0..length).map(|_| evidence(Axis::Column, 9)).collect(),
                responses: Vec::new(),
            },
            links: (1..length)
                .map(|k| Link::new(k - 1, k, Axis::Column))
                .collect(),
            known: vec![None; length],
        }
    }

    /// Numbers that the chain gets when lines lie on their epipolar line where `near` says so.
    fn read(chain: &Chain, near: impl Fn(u16, u16) -> bool) -> Vec<Option<(u16, u16)>> {
        let grid = grid();
        let codes = Axis::BOTH.map(|family| Orientation::ALL[0].code(&grid, family));
        let distance = |_, flat, steep| Some(if near(flat, steep) { 0.1 } else { 4.0 });
        let decoder = Decoder {
            codes: codes.each_ref(),
            colours: &chain.colours,
            links: &[],
            settings: &DecodeSettings::default(),
            epipolar: Some(&distance),
            expected: None,
        };
        let mut numbers = vec![None; chain.known.len()];
        for (node, label) in label_rest(&decoder, &chain.known, &chain.links) {
            if let Label::Known { flat, steep, .. } = label {
                numbers[node] = Some((flat, steep));
            }
        }
        numbers
    }

    /// As if column 9 were seen where its light may come from, and every fifth column too.
    fn on_column_9(_: u16, steep: u16) -> bool {
        steep % 5 == 4
    }

    #[test]
    fn a_line_that_crosses_three_others_is_placed_by_colours_and_epipolar_lines() {
        let numbers = read(&chain(3), on_column_9);
        assert_eq!(numbers, [Some((4, 9)), Some((5, 9)), Some((6, 9))]);
    }

    #[test]
    fn a_line_that_many_columns_could_be_is_left_out() {
        assert_eq!(read(&chain(3), |_, _| true), [None; 3]);
        assert_eq!(read(&chain(3), |_, _| false), [None; 3]);
    }

    #[test]
    fn a_single_crossing_is_placed_beside_a_labelled_one_only() {
        let here = |flat, steep| (flat, steep) == (5, 9);
        let mut beside = chain(2);
        assert_eq!(read(&chain(1), here), [None]);
        beside.known[0] = Some((4, 9));
        assert_eq!(read(&beside, here), [None, Some((5, 9))]);
    }

    #[test]
    fn of_two_columns_that_fit_the_one_that_is_taken_is_left_out() {
        let grid = grid();
        let symbols = grid.symbols(Axis::Column);
        let like_9 = (0..15).find(|&k| k != 9 && symbols[k] == symbols[9]);
        let other = like_9.unwrap() as u16;
        let on_both = |_, steep| steep == 9 || steep == other;
        let mut chain = chain(4);
        chain.links.truncate(2);
        assert_eq!(read(&chain, on_both)[..3], [None; 3]);
        chain.known[3] = Some((5, other.into()));
        assert_eq!(read(&chain, on_both)[1], Some((5, 9)));
    }
}
