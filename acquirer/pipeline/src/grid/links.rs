//! Which crossings are neighbours, and their integer places within connected patches.
//!
//! Takes the crossings in their order along the lines; gives links between neighbours and, for each
//! connected patch, (row, column) offsets. A link is kept when its length fits its line's other gaps and
//! when it is a side of a closed 2 x 2 cell. Offsets come from a weighted union-find over the links, most
//! regular first; a link that contradicts the others is cut. Two surfaces whose lines happen to continue
//! each other are linked quietly: the colours must tell (see `labels`).

use std::collections::BTreeMap;

use shared::pattern::Axis;

use super::{DecodeSettings, labels::Label};
use crate::crossings::Crossings;

/// Two neighbouring crossings; `b` follows `a` along a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Link {
    pub(super) a: usize,
    pub(super) b: usize,
    /// Direction of the line they share: along a row the column changes, along a column the row.
    pub(super) along: Axis,
    /// How far its length is from its neighbours', 0 for equal.
    irregularity: f64,
}

impl Link {
    /// A link between crossings as far apart as their neighbours.
    #[cfg(test)]
    pub(super) fn new(a: usize, b: usize, along: Axis) -> Self {
        Self {
            a,
            b,
            along,
            irregularity: 0.0,
        }
    }

    /// How many lines apart the labels of both crossings are, if they share the link's line and follow each other on it.
    pub(super) fn step(&self, labels: &BTreeMap<usize, Label>) -> Option<i16> {
        let numbers = |node| match labels.get(&node) {
            Some(&Label::Known { flat, steep, .. }) => Some(match self.along {
                Axis::Row => (flat, steep),
                Axis::Column => (steep, flat),
            }),
            _ => None,
        };
        let ((shared_a, a), (shared_b, b)) = (numbers(self.a)?, numbers(self.b)?);
        (shared_a == shared_b && b > a).then(|| (b - a) as i16)
    }
}

/// Crossings with integer places.
#[derive(Debug, Clone)]
pub(super) struct Patch {
    /// The crossings.
    pub(super) nodes: Vec<usize>,
    /// Their (row, column) offsets, from 0.
    pub(super) places: Vec<(i32, i32)>,
}

/// The links that close cells and do not contradict each other, and the patches they make.
pub(super) fn find_patches(links: &[Link], crossings: usize) -> (Vec<Link>, Vec<Patch>) {
    patches_of(cells_only(links, crossings), crossings)
}

/// The links that do not contradict each other, most regular first, and the patches they make.
pub(super) fn patches_of(mut links: Vec<Link>, crossings: usize) -> (Vec<Link>, Vec<Patch>) {
    links.sort_by(|p, q| {
        let order = p.irregularity.total_cmp(&q.irregularity);
        order.then((p.a, p.b).cmp(&(q.a, q.b)))
    });
    let mut places = Places::new(crossings);
    links.retain(|link| {
        let step = match link.along {
            Axis::Row => (0, 1),
            Axis::Column => (1, 0),
        };
        places.join(link.a, link.b, step)
    });
    let patches = places.patches(&links);
    (links, patches)
}

/// Links between neighbours whose distance fits their line's other gaps.
pub(super) fn regular_links(crossings: &Crossings, settings: &DecodeSettings) -> Vec<Link> {
    const AROUND: usize = 3; // gaps on either side that a gap is compared with
    let mut links = Vec::new();
    for along in Axis::BOTH {
        let typical = crossings.gap_px(along);
        for track in crossings.on(along) {
            let place = |k: usize| crossings.all[k].along(along);
            let gaps: Vec<f64> = track
                .windows(2)
                .map(|p| place(p[1]) - place(p[0]))
                .collect();
            for (at, pair) in track.windows(2).enumerate() {
                let near = &gaps[at.saturating_sub(AROUND)..(at + AROUND + 1).min(gaps.len())];
                let expected = if near.len() > AROUND {
                    middle(near)
                } else {
                    typical
                };
                let ratio = gaps[at] / expected;
                let seen = crossings.all[pair[0]].arms(along).seen[1]
                    && crossings.all[pair[1]].arms(along).seen[0];
                if seen && settings.shortest_gap < ratio && ratio < settings.longest_gap {
                    links.push(Link {
                        a: pair[0],
                        b: pair[1],
                        along,
                        irregularity: ratio.ln().abs(),
                    });
                }
            }
        }
    }
    links
}

/// The links whose labels are those of neighbours, or of crossings with missed lines between them, and how many lines
/// apart these are. A link over missed lines must be as long as so many others: more is an edge in depth.
pub(super) fn neighbouring_links<'a>(
    links: &'a [Link],
    labels: &BTreeMap<usize, Label>,
    crossings: &Crossings,
    settings: &DecodeSettings,
) -> Vec<(&'a Link, i16)> {
    let with_step = |link: &'a Link| Some((link, link.step(labels)?));
    let mut found: Vec<_> = links.iter().filter_map(with_step).collect();
    if found.iter().all(|(_, step)| *step == 1) {
        return found;
    }
    let gap_px = |(link, step): &(&Link, i16)| {
        let [a, b] = [link.a, link.b].map(|node| crossings.all[node].along(link.along));
        (b - a) / f64::from(*step)
    };
    let typical_px = Axis::BOTH.map(|along| {
        let along = found.iter().filter(|(link, _)| link.along == along);
        let gaps: Vec<f64> = along.map(gap_px).collect();
        if gaps.is_empty() { 0.0 } else { middle(&gaps) }
    });
    found.retain(|link| {
        let ratio = gap_px(link) / typical_px[usize::from(link.0.along == Axis::Column)];
        link.1 == 1 || (settings.shortest_gap..settings.longest_gap).contains(&ratio)
    });
    found
}

fn middle(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// Keeps links that are a side of a closed cell.
fn cells_only(links: &[Link], crossings: usize) -> Vec<Link> {
    let mut right = vec![None; crossings];
    let mut below = vec![None; crossings];
    for link in links {
        match link.along {
            Axis::Row => right[link.a] = Some(link.b),
            Axis::Column => below[link.a] = Some(link.b),
        }
    }
    let mut in_cell = (vec![false; crossings], vec![false; crossings]);
    for corner in 0..crossings {
        let (Some(r), Some(b)) = (right[corner], below[corner]) else {
            continue;
        };
        if let (Some(across), Some(down)) = (right[b], below[r])
            && across == down
        {
            (in_cell.0[corner], in_cell.0[b]) = (true, true);
            (in_cell.1[corner], in_cell.1[r]) = (true, true);
        }
    }
    let closes = |link: &Link| match link.along {
        Axis::Row => in_cell.0[link.a],
        Axis::Column => in_cell.1[link.a],
    };
    links.iter().copied().filter(closes).collect()
}

/// Weighted union-find: each crossing's place relative to its parent's.
struct Places {
    parent: Vec<usize>,
    from_parent: Vec<(i32, i32)>,
    size: Vec<usize>,
}

impl Places {
    fn new(crossings: usize) -> Self {
        Self {
            parent: (0..crossings).collect(),
            from_parent: vec![(0, 0); crossings],
            size: vec![1; crossings],
        }
    }

    fn root(&self, mut node: usize) -> (usize, (i32, i32)) {
        let mut place = (0, 0);
        while self.parent[node] != node {
            let step = self.from_parent[node];
            place = (place.0 + step.0, place.1 + step.1);
            node = self.parent[node];
        }
        (node, place)
    }

    /// Joins b at a + step; false when that contradicts what is known.
    fn join(&mut self, a: usize, b: usize, step: (i32, i32)) -> bool {
        let ((ra, pa), (rb, pb)) = (self.root(a), self.root(b));
        let of_b = (pa.0 + step.0 - pb.0, pa.1 + step.1 - pb.1); // place of b's root from a's root
        if ra == rb {
            return of_b == (0, 0);
        }
        let (child, parent, place) = if self.size[ra] < self.size[rb] {
            (ra, rb, (-of_b.0, -of_b.1))
        } else {
            (rb, ra, of_b)
        };
        self.parent[child] = parent;
        self.from_parent[child] = place;
        self.size[parent] += self.size[child];
        true
    }

    /// The patches of two or more crossings, largest first.
    fn patches(&self, links: &[Link]) -> Vec<Patch> {
        let crossings = self.parent.len();
        let mut linked = vec![false; crossings];
        for link in links {
            (linked[link.a], linked[link.b]) = (true, true);
        }
        let mut of_root = vec![None; crossings];
        let mut patches: Vec<Patch> = Vec::new();
        for node in (0..crossings).filter(|&node| linked[node]) {
            let (root, place) = self.root(node);
            let at = *of_root[root].get_or_insert_with(|| {
                patches.push(Patch {
                    nodes: Vec::new(),
                    places: Vec::new(),
                });
                patches.len() - 1
            });
            patches[at].nodes.push(node);
            patches[at].places.push(place);
        }
        for patch in &mut patches {
            patch.start_at_zero();
        }
        patches.sort_by_key(|patch| (std::cmp::Reverse(patch.nodes.len()), patch.nodes[0]));
        patches
    }
}

impl Patch {
    /// A crossing by itself.
    pub(super) fn single(node: usize) -> Self {
        Self {
            nodes: vec![node],
            places: vec![(0, 0)],
        }
    }

    /// The crossings with their places.
    pub(super) fn members(&self) -> impl Iterator<Item = (usize, (i32, i32))> + '_ {
        self.nodes.iter().copied().zip(self.places.iter().copied())
    }

    /// Shifts the places so that the smallest row and column are 0.
    pub(super) fn start_at_zero(&mut self) {
        let low = self.places.iter().fold((i32::MAX, i32::MAX), |low, p| {
            (low.0.min(p.0), low.1.min(p.1))
        });
        for place in &mut self.places {
            *place = (place.0 - low.0, place.1 - low.1);
        }
    }
}
