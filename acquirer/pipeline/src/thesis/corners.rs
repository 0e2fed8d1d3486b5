//! Corners: the four vertices of each crossing, at whole pixels (thesis, chapter 4.4.1).
//!
//! Takes the edge map, labels its connected edges, and finds where the end of a column's edge meets the end
//! of a row's: the lower end of a column's left edge meets the right end of a row's upper edge in an
//! UPPER_LEFT vertex, and so on. Corners of four kinds one stripe apart make up a crossing; where one of
//! the four is missing, the other three complete the parallelogram. A corner stands in the pixel where the
//! two edges' last stretches cross, so it is right to about a pixel; a torn edge makes corners of its own
//! only where another edge ends beside it.

use std::collections::HashMap;

use shared::pattern::Corner;

use super::edges::{EdgeMap, Side};

/// Shortest edge that counts, in pixels.
const SHORTEST_EDGE_PX: usize = 4;

/// A connected edge of one side of a stripe.
#[derive(Debug, Clone)]
pub(crate) struct Edge {
    /// Which side.
    pub side: Side,
    /// Its pixels (x, y): from top to bottom for a column's, from left to right for a row's.
    pub pixels: Vec<[i32; 2]>,
}

/// A vertex with the two edges that meet in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vertex {
    /// Which of the four.
    pub corner: Corner,
    /// The pixel.
    pub at: [i32; 2],
    /// Number of the column's edge.
    pub column_edge: usize,
    /// Number of the row's edge.
    pub row_edge: usize,
}

/// A crossing: its four pixels in the order of [`Corner::ALL`], and the vertices that were really seen.
#[derive(Debug, Clone)]
pub(crate) struct Crossing {
    /// The pixels.
    pub corners: [[i32; 2]; 4],
    /// The vertices found; one may be missing.
    pub seen: [Option<Vertex>; 4],
}

impl Crossing {
    /// The middle of the four pixels, in edge coordinates.
    pub(crate) fn centre(&self) -> [f64; 2] {
        [0, 1].map(|c| {
            self.corners
                .iter()
                .map(|p| f64::from(p[c]) + 0.5)
                .sum::<f64>()
                / 4.0
        })
    }
}

/// Labels the connected edges of the map.
pub(crate) fn label_edges(map: &EdgeMap) -> Vec<Edge> {
    let mut seen = vec![false; map.sides.len()];
    let mut edges = Vec::new();
    for start in 0..map.sides.len() {
        if let Some(side) = map.sides[start].filter(|_| !seen[start]) {
            let pixels = connected(map, side, start, &mut seen);
            if pixels.len() >= SHORTEST_EDGE_PX {
                edges.push(Edge { side, pixels });
            }
        }
    }
    edges
}

fn connected(map: &EdgeMap, side: Side, start: usize, seen: &mut [bool]) -> Vec<[i32; 2]> {
    let (width, height) = (map.width, map.sides.len() / map.width);
    let mut pixels = Vec::new();
    let mut open = vec![start];
    seen[start] = true;
    while let Some(at) = open.pop() {
        let (x, y) = (at % width, at / width);
        pixels.push([x as i32, y as i32]);
        for ny in y.saturating_sub(1)..(y + 2).min(height) {
            for nx in x.saturating_sub(1)..(x + 2).min(width) {
                let next = ny * width + nx;
                if !seen[next] && map.sides[next] == Some(side) {
                    seen[next] = true;
                    open.push(next);
                }
            }
        }
    }
    let along = usize::from(side.is_of_column());
    pixels.sort_unstable_by_key(|p| (p[along], p[1 - along]));
    pixels
}

/// Finds the vertices: ends of edges that meet within `reach` pixels.
pub(crate) fn find_vertices(edges: &[Edge], reach: i32) -> Vec<Vertex> {
    let mut row_ends: HashMap<(Side, bool, [i32; 2]), Vec<usize>> = HashMap::new();
    let cell = |[x, y]: [i32; 2]| [x.div_euclid(reach), y.div_euclid(reach)];
    for (k, edge) in edges
        .iter()
        .enumerate()
        .filter(|(_, e)| !e.side.is_of_column())
    {
        for last in [false, true] {
            let key = (edge.side, last, cell(edge.end(last)));
            row_ends.entry(key).or_default().push(k);
        }
    }
    let mut vertices = Vec::new();
    for (k, edge) in edges
        .iter()
        .enumerate()
        .filter(|(_, e)| e.side.is_of_column())
    {
        for lower_end in [false, true] {
            let end = edge.end(lower_end);
            // a column's edge reaches its row's upper side with its lower end
            let row_side = if lower_end { Side::Upper } else { Side::Lower };
            let right_end = edge.side == Side::Left;
            let near = neighbours(cell(end));
            let candidates = near
                .filter_map(|c| row_ends.get(&(row_side, right_end, c)))
                .flatten();
            let distance = |&&row: &&usize| {
                let other = edges[row].end(right_end);
                let (dx, dy) = ((other[0] - end[0]).abs(), (other[1] - end[1]).abs());
                (dx.max(dy), dx + dy, row)
            };
            let nearest = candidates.min_by_key(distance).copied();
            if let Some(row_edge) = nearest.filter(|row| distance(&row).0 <= reach) {
                let stretch = reach as usize;
                vertices.push(Vertex {
                    corner: corner_of(row_side, right_end),
                    at: [
                        edge.place(lower_end, stretch),
                        edges[row_edge].place(right_end, stretch),
                    ],
                    column_edge: k,
                    row_edge,
                });
            }
        }
    }
    vertices
}

fn corner_of(row_side: Side, left_of_column: bool) -> Corner {
    match (row_side, left_of_column) {
        (Side::Upper, true) => Corner::UpperLeft,
        (Side::Upper, false) => Corner::UpperRight,
        (_, false) => Corner::LowerRight,
        (_, true) => Corner::LowerLeft,
    }
}

impl Edge {
    /// The first or the last pixel.
    pub(crate) fn end(&self, last: bool) -> [i32; 2] {
        let at = if last { self.pixels.len() - 1 } else { 0 };
        self.pixels[at]
    }

    /// The x of a column's edge, the y of a row's: the median over the last stretch before an end.
    fn place(&self, last: bool, stretch: usize) -> i32 {
        let stretch = stretch.clamp(1, self.pixels.len());
        let range = if last {
            self.pixels.len() - stretch..self.pixels.len()
        } else {
            0..stretch
        };
        let across = usize::from(!self.side.is_of_column());
        let mut places: Vec<i32> = self.pixels[range].iter().map(|p| p[across]).collect();
        places.sort_unstable();
        places[places.len() / 2]
    }
}

/// A cell and the eight around it.
fn neighbours([x, y]: [i32; 2]) -> impl Iterator<Item = [i32; 2]> {
    (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| [x + dx, y + dy]))
}

/// Puts vertices one stripe apart together. `reach` is the largest width of a stripe in pixels.
pub(crate) fn find_crossings(vertices: &[Vertex], reach: i32) -> Vec<Crossing> {
    let cell = |[x, y]: [i32; 2]| [x.div_euclid(reach), y.div_euclid(reach)];
    let mut by_cell: HashMap<(Corner, [i32; 2]), Vec<usize>> = HashMap::new();
    for (k, vertex) in vertices.iter().enumerate() {
        by_cell
            .entry((vertex.corner, cell(vertex.at)))
            .or_default()
            .push(k);
    }
    let nearest = |from: usize, corner: Corner| {
        let at = vertices[from].at;
        let sign = |upper_or_left: bool| if upper_or_left { -1 } else { 1 };
        let own = vertices[from].corner;
        let [to_right, to_lower] = [corner.is_right(), corner.is_lower()].map(|b| sign(!b));
        let candidates = neighbours(cell(at))
            .filter_map(|c| by_cell.get(&(corner, c)))
            .flatten();
        candidates
            .copied()
            .filter_map(|k| {
                let (dx, dy) = (vertices[k].at[0] - at[0], vertices[k].at[1] - at[1]);
                let fits = |step: i32, differs: bool, towards: i32| {
                    if differs {
                        step * towards > 0 && step.abs() <= reach
                    } else {
                        step.abs() <= reach / 2
                    }
                };
                let fits = fits(dx, own.is_right() != corner.is_right(), to_right)
                    && fits(dy, own.is_lower() != corner.is_lower(), to_lower);
                fits.then_some((dx.abs() + dy.abs(), k))
            })
            .min()
            .map(|(_, k)| k)
    };
    let mut used = vec![false; vertices.len()];
    let mut crossings = Vec::new();
    // whole crossings first, then those that lack a vertex
    for wanted in [4, 3] {
        for from in 0..vertices.len() {
            if used[from] {
                continue;
            }
            let seen = Corner::ALL.map(|corner| {
                let found = if corner == vertices[from].corner {
                    Some(from)
                } else {
                    nearest(from, corner)
                };
                found.filter(|&k| !used[k])
            });
            if seen.iter().flatten().count() == wanted {
                seen.iter().flatten().for_each(|&k| used[k] = true);
                crossings.push(Crossing::new(seen.map(|k| k.map(|k| vertices[k]))));
            }
        }
    }
    crossings
}

impl Crossing {
    /// Of at least three vertices.
    fn new(seen: [Option<Vertex>; 4]) -> Self {
        let at = |k: usize| seen[k % 4].map_or([0; 2], |vertex| vertex.at);
        let complete = |k: usize| {
            let (before, after, opposite) = (at(k + 3), at(k + 1), at(k + 2));
            [0, 1].map(|c| before[c] + after[c] - opposite[c])
        };
        let corner = |k: usize| seen[k].map_or_else(|| complete(k), |vertex| vertex.at);
        Self {
            corners: [0, 1, 2, 3].map(corner),
            seen,
        }
    }
}
