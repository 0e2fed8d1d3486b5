//! Lines through matching corners: which crossings are neighbours, and of which colours their lines are.
//!
//! Takes the crossings and the connected edges, gives for each crossing its neighbour to the right and below:
//! the one that the edge leaving this crossing's right (lower) vertices arrives at with its left (upper)
//! ones. Lines through UPPER_LEFT and LOWER_LEFT, or UPPER_RIGHT and LOWER_RIGHT, vertices make columns, and
//! accordingly for rows, so a stripe's two edges stay one line of the code (thesis, chapter 4.4.1). The
//! colour of a link is the commonest one of the pixels between its edges in the coded capture.

use std::collections::HashMap;

use shared::pattern::Corner;

use super::{
    corners::{Crossing, Edge, Vertex},
    edges::Side,
    threshold::ColourMap,
};

/// Part of a link's length, at either end, that is not asked for its colour: there the other line is near.
const MARGIN: f64 = 0.15;
/// Share of the pixels along a link that must have its colour.
const MAJORITY: f64 = 0.4;

/// How far the parts of a torn edge may run side by side, in pixels.
const OVERLAP_PX: i32 = 4;
/// How far aside a torn edge may go on, in pixels.
const STEP_PX: i32 = 2;

/// A line from one crossing to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Link {
    /// Number of the crossing it leads to.
    pub to: usize,
    /// Number of its colour; `None` where no colour has enough pixels.
    pub colour: Option<u8>,
}

/// The links of every crossing.
#[derive(Debug, Clone, Default)]
pub(crate) struct Links {
    /// To the next crossing on the same row.
    pub right: Vec<Option<Link>>,
    /// To the next crossing on the same column.
    pub down: Vec<Option<Link>>,
}

/// For each edge the one that goes on beyond a tear at its far end, if any.
pub(crate) struct Mended(Vec<Option<usize>>);

/// Joins edges of one side across tears of at most `tear` pixels. Ends that are vertices are no tears.
pub(crate) fn mend(edges: &[Edge], vertices: &[Vertex], tear: i32) -> Mended {
    let mut loose = vec![[true; 2]; edges.len()];
    for vertex in vertices {
        loose[vertex.column_edge][usize::from(!vertex.corner.is_lower())] = false;
        loose[vertex.row_edge][usize::from(!vertex.corner.is_right())] = false;
    }
    let mut starts: HashMap<(Side, [i32; 2]), usize> = HashMap::new();
    for (k, edge) in edges.iter().enumerate().filter(|(k, _)| loose[*k][0]) {
        starts.insert((edge.side, edge.end(false)), k);
    }
    let next = |(k, edge): (usize, &Edge)| {
        let [x, y] = edge.end(true);
        let along = usize::from(edge.side.is_of_column());
        // a tear may also be a step sideways where both parts lie side by side for a bit
        (-OVERLAP_PX..=tear)
            .filter(|_| loose[k][1])
            .find_map(|ahead| {
                (-STEP_PX..=STEP_PX).find_map(|aside| {
                    let at = if edge.side.is_of_column() {
                        [x + aside, y + ahead]
                    } else {
                        [x + ahead, y + aside]
                    };
                    let found = starts.get(&(edge.side, at)).copied();
                    found.filter(|&n| edges[n].end(true)[along] > edge.end(true)[along])
                })
            })
    };
    Mended(edges.iter().enumerate().map(next).collect())
}

/// Follows the edges from crossing to crossing.
pub(crate) fn link_crossings(crossings: &[Crossing], edges: &Mended, colours: &ColourMap) -> Links {
    use Corner::{LowerLeft, LowerRight, UpperLeft, UpperRight};
    let row_edge = |vertex: &Vertex| vertex.row_edge;
    let column_edge = |vertex: &Vertex| vertex.column_edge;
    let count = edges.0.len();
    let right = arrivals(crossings, count, [UpperLeft, LowerLeft], row_edge);
    let down = arrivals(crossings, count, [UpperLeft, UpperRight], column_edge);
    let follow = |from: usize,
                  leaves: [Corner; 2],
                  arrivals: &[Option<usize>],
                  edge: fn(&Vertex) -> usize| {
        let ends = leaves.map(|corner| {
            let vertex = crossings[from].seen[corner as usize]?;
            edges
                .arrival(edge(&vertex), arrivals)
                .filter(|&to| to != from)
        });
        // both edges must not lead to different crossings
        let to = match ends {
            [Some(a), Some(b)] => (a == b).then_some(a),
            [a, b] => a.or(b),
        }?;
        Some(Link {
            to,
            colour: colour_between(&crossings[from], &crossings[to], colours),
        })
    };
    let all = 0..crossings.len();
    Links {
        right: all
            .clone()
            .map(|k| follow(k, [UpperRight, LowerRight], &right, row_edge))
            .collect(),
        down: all
            .map(|k| follow(k, [LowerLeft, LowerRight], &down, column_edge))
            .collect(),
    }
}

impl Mended {
    /// The crossing that an edge arrives at, over its tears; an edge never goes on backwards, so this ends.
    fn arrival(&self, edge: usize, arrivals: &[Option<usize>]) -> Option<usize> {
        let mut edge = edge;
        loop {
            if arrivals[edge].is_some() {
                return arrivals[edge];
            }
            edge = self.0[edge]?;
        }
    }
}

/// For each edge the crossing that it arrives at with one of these vertices.
fn arrivals(
    crossings: &[Crossing],
    edges: usize,
    corners: [Corner; 2],
    edge: fn(&Vertex) -> usize,
) -> Vec<Option<usize>> {
    let mut arrivals = vec![None; edges];
    for (k, crossing) in crossings.iter().enumerate() {
        for vertex in corners
            .iter()
            .filter_map(|&corner| crossing.seen[corner as usize].as_ref())
        {
            arrivals[edge(vertex)] = Some(k);
        }
    }
    arrivals
}

fn colour_between(a: &Crossing, b: &Crossing, colours: &ColourMap) -> Option<u8> {
    let (from, to) = (a.centre(), b.centre());
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let steps = dx.abs().max(dy.abs()).ceil().max(1.0) as usize;
    let mut votes = [0_usize; 256];
    let mut asked = 0;
    for step in 0..=steps {
        let part = step as f64 / steps as f64;
        if !(MARGIN..=1.0 - MARGIN).contains(&part) {
            continue;
        }
        let (x, y) = (from[0] + part * dx, from[1] + part * dy);
        for side in [-1.0, 0.0, 1.0] {
            let (x, y) = if dx.abs() > dy.abs() {
                (x, y + side)
            } else {
                (x + side, y)
            };
            asked += 1;
            if let Some(class) = colours.at(x as usize, y as usize) {
                votes[usize::from(class)] += 1;
            }
        }
    }
    let (class, count) = votes
        .iter()
        .enumerate()
        .max_by_key(|(k, n)| (**n, usize::MAX - k))?;
    (*count as f64 > MAJORITY * f64::from(asked)).then_some(class as u8)
}

impl Links {
    /// Drops loose lines: those that are no side of a square of four linked crossings.
    pub(crate) fn keep_squares(&mut self) {
        let mut right = vec![false; self.right.len()];
        let mut down = vec![false; self.down.len()];
        for a in 0..self.right.len() {
            if let Some([b, c, _]) = self.square(a) {
                right[a] = true;
                down[a] = true;
                down[b] = true;
                right[c] = true;
            }
        }
        for (links, keep) in [(&mut self.right, right), (&mut self.down, down)] {
            for (link, keep) in links.iter_mut().zip(keep) {
                *link = link.filter(|_| keep);
            }
        }
    }

    /// The crossings right of, below, and diagonally below a crossing, when the four are linked in a square.
    fn square(&self, a: usize) -> Option<[usize; 3]> {
        let (b, c) = (self.right[a]?.to, self.down[a]?.to);
        let (d, also_d) = (self.down[b]?.to, self.right[c]?.to);
        (d == also_d).then_some([b, c, d])
    }
}
