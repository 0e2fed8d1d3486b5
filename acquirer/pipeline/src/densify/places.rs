//! Where on the projector the light of a camera position comes from, as far as decoded grids tell.
//!
//! Takes decoded crossings, whose place on the projector is known exactly; gives the place of any position in or beside a
//! cell of four neighbouring ones by bilinear interpolation, with how far it may be off. The spread is a share of the
//! pitch on a smooth surface, and grows with the irregularity of the cell's sides, which tells an edge in depth, and
//! with the distance beyond the cell.

use shared::{
    geometry::{CameraPixel, ProjectorPixel},
    pattern::{Axis, GridIndex},
};

use crate::{Projected, grid::DecodedGrid};

/// Share of the pitch by which a place inside a regular cell may be off (standard deviation): curvature, lens.
const SMOOTH_SHARE: f64 = 0.03;
/// How much a cell's side may differ from the next one on its line, as a logarithm, when there is no next one.
const UNKNOWN_IRREGULARITY: f64 = 0.1;
/// How far beyond its cell a position may lie, in cells.
const MOST_BEYOND: f64 = 0.6;
/// Share of the way beyond the cell by which the place may be off.
const BEYOND_SHARE: f64 = 0.25;

/// A place on the projector, known to some degree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownPlace {
    /// Where the light comes from.
    pub at: ProjectorPixel,
    /// By how much that may be off along either axis, standard deviation, projector px.
    pub spread_px: f64,
}

/// The cells of decoded grids.
#[derive(Debug, Clone, Default)]
pub struct KnownPlaces {
    cells: Vec<Cell>,
}

/// Four neighbouring crossings.
#[derive(Debug, Clone)]
struct Cell {
    /// Upper left, upper right, lower left, lower right in the pattern's order.
    seen: [CameraPixel; 4],
    /// Of the first and of the last.
    projected: [ProjectorPixel; 2],
    /// Largest irregularity of its sides.
    irregularity: f64,
    /// Bounds in the picture, as far beyond as the cell may tell: left, top, right, bottom.
    bounds: [f64; 4],
}

impl KnownPlaces {
    /// The cells that a grid was read in.
    #[must_use]
    pub fn of(grid: &DecodedGrid, projected: &Projected) -> Self {
        let cells = grid.crossings.iter();
        Self {
            cells: cells
                .filter_map(|crossing| Cell::at(crossing.index, grid, projected))
                .collect(),
        }
    }

    /// These and the other's cells.
    #[must_use]
    pub fn with(mut self, other: Self) -> Self {
        self.cells.extend(other.cells);
        self
    }

    /// The best known place of a camera position; `None` away from all cells.
    #[must_use]
    pub fn at(&self, seen: CameraPixel) -> Option<KnownPlace> {
        let places = self.cells.iter().filter_map(|cell| cell.place(seen));
        places.min_by(|a, b| a.spread_px.total_cmp(&b.spread_px))
    }
}

impl Cell {
    /// The cell to the lower right of a crossing, if all four are known.
    fn at(index: GridIndex, grid: &DecodedGrid, projected: &Projected) -> Option<Self> {
        let seen_at = |row: i32, column: i32| {
            let index = GridIndex {
                row: u16::try_from(i32::from(index.row) + row).ok()?,
                column: u16::try_from(i32::from(index.column) + column).ok()?,
            };
            grid.crossing(index).map(|crossing| crossing.centre)
        };
        let seen = [
            seen_at(0, 0)?,
            seen_at(0, 1)?,
            seen_at(1, 0)?,
            seen_at(1, 1)?,
        ];
        let gap = |a: (i32, i32), b: (i32, i32)| {
            let (a, b) = (seen_at(a.0, a.1)?, seen_at(b.0, b.1)?);
            Some((a.x - b.x).hypot(a.y - b.y))
        };
        // each side against the ones before and after it on the same line, the one it is more like
        let sides = [
            [[(0, 0), (0, 1)], [(0, -1), (0, 0)], [(0, 1), (0, 2)]],
            [[(1, 0), (1, 1)], [(1, -1), (1, 0)], [(1, 1), (1, 2)]],
            [[(0, 0), (1, 0)], [(-1, 0), (0, 0)], [(1, 0), (2, 0)]],
            [[(0, 1), (1, 1)], [(-1, 1), (0, 1)], [(1, 1), (2, 1)]],
        ];
        let irregularity = sides.map(|[own, before, after]| {
            let own = gap(own[0], own[1]);
            let ratios = [before, after].map(|[a, b]| Some((own? / gap(a, b)?).ln().abs()));
            let likest = ratios.into_iter().flatten().min_by(f64::total_cmp);
            likest.unwrap_or(UNKNOWN_IRREGULARITY)
        });
        Some(Self::new(seen, index, projected, irregularity))
    }

    fn new(
        seen: [CameraPixel; 4],
        index: GridIndex,
        projected: &Projected,
        irregularity: [f64; 4],
    ) -> Self {
        let coded = &projected.pattern.coded;
        let line = |axis, k: u16| {
            coded
                .line(axis, usize::from(k), projected.raster)
                .centre_px()
        };
        let projector = |step: u16| {
            let (x, y) = (index.column + step, index.row + step);
            ProjectorPixel::new(line(Axis::Column, x), line(Axis::Row, y))
        };
        let (xs, ys) = (seen.map(|p| p.x), seen.map(|p| p.y));
        let [left, right] = range(xs);
        let [top, bottom] = range(ys);
        let reach = MOST_BEYOND * (right - left).max(bottom - top);
        Self {
            seen,
            projected: [projector(0), projector(1)],
            irregularity: irregularity.into_iter().fold(0.0, f64::max),
            bounds: [left - reach, top - reach, right + reach, bottom + reach],
        }
    }

    fn place(&self, seen: CameraPixel) -> Option<KnownPlace> {
        let [left, top, right, bottom] = self.bounds;
        if !(left..=right).contains(&seen.x) || !(top..=bottom).contains(&seen.y) {
            return None;
        }
        let [u, v] = self.inside(seen)?;
        let beyond = |t: f64| (t - 1.0).max(-t).max(0.0);
        let beyond = beyond(u).max(beyond(v));
        let [from, to] = self.projected;
        let pitch_px = (to.x - from.x).max(to.y - from.y);
        let share = SMOOTH_SHARE + self.irregularity + BEYOND_SHARE * beyond;
        (beyond <= MOST_BEYOND).then(|| KnownPlace {
            at: ProjectorPixel::new(from.x + u * (to.x - from.x), from.y + v * (to.y - from.y)),
            spread_px: share * pitch_px,
        })
    }

    /// Where in the cell a position lies, 0 to 1 along columns' and rows' direction (inverse bilinear, by Newton).
    fn inside(&self, seen: CameraPixel) -> Option<[f64; 2]> {
        const ROUNDS: usize = 6;
        let [a, b, c, d] = self.seen.map(|p| [p.x, p.y]);
        let (mut u, mut v) = (0.5, 0.5);
        for _ in 0..ROUNDS {
            let at = |k: usize| {
                (1.0 - v) * ((1.0 - u) * a[k] + u * b[k]) + v * ((1.0 - u) * c[k] + u * d[k])
            };
            let along = |k: usize| (1.0 - v) * (b[k] - a[k]) + v * (d[k] - c[k]);
            let down = |k: usize| (1.0 - u) * (c[k] - a[k]) + u * (d[k] - b[k]);
            let (x, y) = (seen.x - at(0), seen.y - at(1));
            let area = along(0) * down(1) - along(1) * down(0);
            if area.abs() < 1e-6 {
                return None;
            }
            u += (x * down(1) - y * down(0)) / area;
            v += (y * along(0) - x * along(1)) / area;
        }
        (u.is_finite() && v.is_finite()).then_some([u, v])
    }
}

fn range(values: [f64; 4]) -> [f64; 2] {
    [
        values.into_iter().fold(f64::INFINITY, f64::min),
        values.into_iter().fold(f64::NEG_INFINITY, f64::max),
    ]
}
