//! The surface between the crossings: nodes, and the cells between them that may be filled.
//!
//! Takes shift rows, surface points or differences, gives a mesh with one node per crossing (the mean of its vertices) and a
//! cell wherever four neighbouring crossings were read and no step between them is a cut. A step is a cut when it
//! is too steep for a surface that both devices see, or steep and a large part of the whole depth range
//! ([`CutRule`]). A cut that is lower than that is bridged quietly; a very steep side stays open.

use std::collections::BTreeMap;

use shared::pattern::GridIndex;

use crate::{
    output::{colour_map::spread, shift_table::ShiftRow},
    pipeline::{
        grid::DecodedGrid,
        surface::{SurfacePoint, difference::Difference},
    },
};

/// The share of nodes on either side of the depth range that may be outliers.
const OUTLIERS: f64 = 0.01;
/// How far beyond the range without outliers a node may lie, as a share of that range.
const REACH: f64 = 0.5;

/// How far beyond the crossings a single measurement may lie, as a share of their extent.
const DOT_REACH: f64 = 0.1;

/// One crossing on the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Position in the units of the data (px, px, relative depth; or mm).
    pub position: [f64; 3],
    /// What the step rule looks at: the shift in px, or the distance in mm.
    step_value: f64,
    /// Where the camera's picture shows it, in pixels.
    pub seen_at: Option<[f64; 2]>,
}

/// A single measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// Position in the units of the data.
    pub position: [f64; 3],
    /// Whether it is a vertex of a crossing, not a point along a line.
    pub is_vertex: bool,
    /// The surface's colour there, where the data have it.
    pub colour: Option<[u8; 3]>,
}

/// When a step from one crossing to the next is a cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutRule {
    /// A step over the way across the line of sight that is always a cut.
    pub steepest: f64,
    /// A step over that way which is never a cut.
    pub gentle: f64,
    /// Between the two: the share of the whole depth range from which on a step is a cut, 0 to 1.
    pub share_of_range: f64,
}

impl CutRule {
    /// For positions in mm: 66 degrees is steeper than lines can be followed, 35 is not.
    pub const MILLIMETRES: Self = Self {
        steepest: 2.2,
        gentle: 0.7,
        share_of_range: 0.25,
    };
    /// For shifts in px: a disparity gradient of 1 is the limit of P. Burt and B. Julesz, "A disparity gradient
    /// limit for binocular fusion", 1980; one of 0.1 is an ordinary slope.
    pub const SHIFTS: Self = Self {
        steepest: 1.0,
        gentle: 0.1,
        share_of_range: 0.25,
    };

    fn is_cut(self, a: &Node, b: &Node, range: f64) -> bool {
        let step = (a.step_value - b.step_value).abs();
        let way = (a.position[0] - b.position[0]).hypot(a.position[1] - b.position[1]);
        step > self.steepest * way
            || (step > self.gentle * way && step > self.share_of_range * range)
    }
}

/// Nodes and the cells between them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// The crossings, sorted by index.
    pub nodes: Vec<Node>,
    /// Row and column of each node.
    pub indices: Vec<GridIndex>,
    /// Four nodes each: upper left, upper right, lower right, lower left.
    pub cells: Vec<[usize; 4]>,
    /// All measurements, outliers left out.
    pub dots: Vec<Dot>,
}

impl Mesh {
    /// A mesh from shifts: x and y in camera px, depth without unit.
    #[must_use]
    pub fn from_shifts(rows: &[ShiftRow]) -> Self {
        let samples = rows.iter().map(|row| {
            let node = Node {
                position: [row.x_px, row.y_px, row.depth],
                step_value: row.shift_px,
                seen_at: Some([row.x_px, row.y_px]),
            };
            (row.index, node)
        });
        let dots = rows.iter().map(|row| Dot {
            position: [row.x_px, row.y_px, row.depth],
            is_vertex: true,
            colour: None,
        });
        Self::new(samples, dots, CutRule::SHIFTS)
    }

    /// A mesh from the vertices among surface points, in mm; `grid` tells where the camera saw them.
    #[must_use]
    pub fn from_surface(points: &[SurfacePoint], grid: &DecodedGrid) -> Self {
        let samples = points.iter().filter_map(|point| {
            let position = point.position_mm;
            sample(point, position, grid)
        });
        let dots = points.iter().map(|point| Dot {
            position: point.position_mm,
            is_vertex: point.corner.is_some(),
            colour: Some(point.colour),
        });
        Self::new(samples, dots, CutRule::MILLIMETRES)
    }

    /// A mesh from the vertices among differences: x and y as the surface's, the third is the height over the
    /// background, all in mm. It is cut where the surface is.
    #[must_use]
    pub fn from_differences(differences: &[Difference], grid: &DecodedGrid) -> Self {
        let samples = differences.iter().filter_map(|difference| {
            let [x, y, _] = difference.point.position_mm;
            sample(&difference.point, [x, y, difference.height_mm], grid)
        });
        Self::new(samples, std::iter::empty(), CutRule::MILLIMETRES)
    }

    fn new(
        samples: impl Iterator<Item = (GridIndex, Node)>,
        dots: impl Iterator<Item = Dot>,
        rule: CutRule,
    ) -> Self {
        let mut groups: BTreeMap<GridIndex, Vec<Node>> = BTreeMap::new();
        for (index, node) in samples {
            if node.position.iter().all(|v| v.is_finite()) && node.step_value.is_finite() {
                groups.entry(index).or_default().push(node);
            }
        }
        let mut means: BTreeMap<_, _> = groups.iter().map(|(k, nodes)| (*k, mean(nodes))).collect();
        let range = spread(means.values().map(|n| n.step_value), OUTLIERS);
        let [low, high] = range.unwrap_or([0.0, 0.0]);
        let reach = REACH * (high - low);
        means.retain(|_, n| (low - reach..=high + reach).contains(&n.step_value));

        let hull = [0, 1, 2].map(|k| spread(means.values().map(|n| n.position[k]), 0.0));
        let near = |dot: &Dot| {
            dot.position.iter().zip(hull).all(|(&v, hull)| {
                hull.is_some_and(|[low, high]| {
                    let reach = DOT_REACH * (high - low);
                    (low - reach..=high + reach).contains(&v)
                })
            })
        };
        let indices: Vec<_> = means.keys().copied().collect();
        let nodes: Vec<_> = means.into_values().collect();
        let cells = cells(&indices, &nodes, |a, b| rule.is_cut(a, b, high - low));
        Self {
            nodes,
            indices,
            cells,
            dots: dots.filter(near).collect(),
        }
    }
}

/// The cells whose four crossings exist and whose sides and diagonals are no cuts.
fn cells(
    indices: &[GridIndex],
    nodes: &[Node],
    is_cut: impl Fn(&Node, &Node) -> bool,
) -> Vec<[usize; 4]> {
    let at = |row, column| indices.binary_search(&GridIndex { row, column }).ok();
    let whole = |index: &GridIndex| {
        let (next_row, next_column) = (index.row.checked_add(1)?, index.column.checked_add(1)?);
        let cell = [
            at(index.row, index.column)?,
            at(index.row, next_column)?,
            at(next_row, next_column)?,
            at(next_row, index.column)?,
        ];
        let cut = (0..4).any(|k| is_cut(&nodes[cell[k]], &nodes[cell[(k + 1) % 4]]));
        (!cut).then_some(cell)
    };
    indices.iter().filter_map(whole).collect()
}

/// A vertex of a crossing in mm; the step rule looks at its distance.
fn sample(
    point: &SurfacePoint,
    position: [f64; 3],
    grid: &DecodedGrid,
) -> Option<(GridIndex, Node)> {
    point.corner?;
    let index = GridIndex {
        row: point.row?,
        column: point.column?,
    };
    let node = Node {
        position,
        step_value: point.position_mm[2],
        seen_at: grid.crossing(index).map(|c| [c.centre.x, c.centre.y]),
    };
    Some((index, node))
}

fn mean(nodes: &[Node]) -> Node {
    let share = 1.0 / nodes.len() as f64;
    let sum = |value: &dyn Fn(&Node) -> f64| share * nodes.iter().map(value).sum::<f64>();
    let seen: Option<Vec<[f64; 2]>> = nodes.iter().map(|n| n.seen_at).collect();
    Node {
        position: [0, 1, 2].map(|axis| sum(&|n| n.position[axis])),
        step_value: sum(&|n| n.step_value),
        seen_at: seen
            .map(|places| [0, 1].map(|k| share * places.iter().map(|p| p[k]).sum::<f64>())),
    }
}
