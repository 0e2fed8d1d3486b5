//! The four vertices of a labelled crossing.
//!
//! Takes the crossing's middle, the directions of its two lines, its linked neighbours and the pattern;
//! gives the places of the lines' edges. The scale (camera px per projector px) along each line is the
//! derivative of the parabola through the neighbours, whose distance in the pattern is known; the edges lie
//! half a known width beside the middle. Blur moves neither middles nor distances, so nothing is biased
//! outward. At a fold of the surface the two sides' scales are mixed quietly.

use nalgebra::Vector2;
use shared::{
    geometry::CameraPixel,
    pattern::{Axis, Corner, Grid, LineSpan, RasterSize},
};

use super::{code::Orientation, links::Link};
use crate::crossings::{Crossing, Crossings};

/// A neighbour, and how many lines further it lies: more than one where lines between were not seen.
type Neighbour = (usize, i16);

/// Neighbours of each crossing along both lines: (before, after).
#[derive(Debug)]
pub(super) struct Neighbours {
    along_rows: Vec<[Option<Neighbour>; 2]>,
    along_columns: Vec<[Option<Neighbour>; 2]>,
}

impl Neighbours {
    /// The neighbours that these links join, so many lines apart.
    pub(super) fn new<'a>(crossings: usize, links: impl Iterator<Item = (&'a Link, i16)>) -> Self {
        let mut found = Self {
            along_rows: vec![[None; 2]; crossings],
            along_columns: vec![[None; 2]; crossings],
        };
        for (link, step) in links {
            let along = match link.along {
                Axis::Row => &mut found.along_rows,
                Axis::Column => &mut found.along_columns,
            };
            along[link.a][1] = Some((link.b, step));
            along[link.b][0] = Some((link.a, step));
        }
        found
    }

    /// Whether a crossing has a neighbour on both of its lines.
    pub(super) fn on_both_lines(&self, node: usize) -> bool {
        Axis::BOTH
            .map(|axis| self.along(axis)[node])
            .iter()
            .all(|n| *n != [None; 2])
    }

    fn along(&self, axis: Axis) -> &[[Option<Neighbour>; 2]] {
        match axis {
            Axis::Row => &self.along_rows,
            Axis::Column => &self.along_columns,
        }
    }
}

/// The pattern as it stands in the picture.
pub(super) struct Placement<'a> {
    pub(super) grid: &'a Grid,
    pub(super) raster: RasterSize,
    pub(super) orientation: Orientation,
    /// Typical gap between crossings along flat and along steep lines, camera px.
    pub(super) gaps_px: [f64; 2],
}

impl Placement<'_> {
    /// The pattern's number of a line counted in the picture's order.
    pub(super) fn pattern_number(&self, family: Axis, number: u16) -> u16 {
        if !self.orientation.flipped(family) {
            return number;
        }
        let lines = self.grid.lines(self.orientation.pattern_axis(family));
        (lines as u16).saturating_sub(1 + number)
    }

    /// From line to line in the picture's order of counting, projector px.
    fn pitch(&self, family: Axis) -> f64 {
        let axis = self.orientation.pattern_axis(family);
        let pitch = self.grid.pitch_px(axis, self.raster);
        if self.orientation.flipped(family) {
            -pitch
        } else {
            pitch
        }
    }

    /// From one line to the line `step` further; beyond the last one the pattern's spacing goes on.
    fn way(&self, family: Axis, number: u16, step: i16) -> f64 {
        let lines = self.grid.lines(self.orientation.pattern_axis(family));
        let next = number.checked_add_signed(step);
        match next.filter(|&next| usize::from(next) < lines) {
            Some(next) => {
                self.span(family, next).centre_px() - self.span(family, number).centre_px()
            }
            None => self.pitch(family) * f64::from(step),
        }
    }

    fn span(&self, family: Axis, number: u16) -> LineSpan {
        let axis = self.orientation.pattern_axis(family);
        let k = self.pattern_number(family, number);
        self.grid.line(axis, usize::from(k), self.raster)
    }
}

/// The vertices in the order of [`Corner::ALL`]; with the picture's typical scale along a line on which the crossing
/// has no neighbour.
pub(super) fn find_vertices(
    node: usize,
    (flat, steep): (u16, u16),
    crossings: &Crossings,
    neighbours: &Neighbours,
    placement: &Placement<'_>,
) -> [CameraPixel; 4] {
    let crossing = &crossings.all[node];
    let per_px = |family: Axis, number: u16| {
        let along = match family {
            Axis::Row => Axis::Column,
            Axis::Column => Axis::Row,
        };
        let from_neighbours = scale(node, along, crossings, neighbours, |step| {
            placement.way(family, number, step)
        });
        from_neighbours.unwrap_or_else(|| {
            let gap_px = placement.gaps_px[usize::from(along == Axis::Column)];
            tangent(crossing, along) * (gap_px / placement.pitch(family))
        })
    };
    let (across_flat, across_steep) = (per_px(Axis::Row, flat), per_px(Axis::Column, steep));
    let (flat_span, steep_span) = (
        placement.span(Axis::Row, flat),
        placement.span(Axis::Column, steep),
    );
    let edge = |span: LineSpan, family: Axis, corner: Corner| {
        let high = match placement.orientation.pattern_axis(family) {
            Axis::Row => corner.is_lower(),
            Axis::Column => corner.is_right(),
        };
        (if high { span.high_px() } else { span.low_px() }) - span.centre_px()
    };
    let centre = Vector2::new(crossing.centre.x, crossing.centre.y);
    Corner::ALL.map(|corner| {
        let place = centre
            + across_flat * edge(flat_span, Axis::Row, corner)
            + across_steep * edge(steep_span, Axis::Column, corner);
        CameraPixel::new(place.x, place.y)
    })
}

/// Camera px per projector px along a line of direction `along`, as a vector; `distance(step)` is the way
/// on the projector to the crossing `step` further.
fn scale(
    node: usize,
    along: Axis,
    crossings: &Crossings,
    neighbours: &Neighbours,
    distance: impl Fn(i16) -> f64,
) -> Option<Vector2<f64>> {
    let at = |k: usize| Vector2::new(crossings.all[k].centre.x, crossings.all[k].centre.y);
    let here = at(node);
    let chain = neighbours.along(along);
    // way on the projector and in the picture to the crossing `step` further
    let way = |k: usize, step: i16| (distance(step), at(k) - here);
    let [before, after] = chain[node];
    let slope = match (before, after) {
        (Some((b, m)), Some((a, n))) => parabola_slope(way(b, -m), way(a, n)),
        (None, Some((a, n))) => match chain[a][1] {
            Some((second, more)) => parabola_slope(way(a, n), way(second, n + more)),
            None => quotient(way(a, n)),
        },
        (Some((b, m)), None) => match chain[b][0] {
            Some((second, more)) => parabola_slope(way(b, -m), way(second, -m - more)),
            None => quotient(way(b, -m)),
        },
        (None, None) => return None,
    };
    let tangent = tangent(&crossings.all[node], along);
    let length = slope.dot(&tangent);
    (length.is_finite() && length != 0.0).then(|| tangent * length)
}

fn quotient((way, moved): (f64, Vector2<f64>)) -> Vector2<f64> {
    moved / way
}

/// Slope at 0 of the parabola through 0 and two points.
fn parabola_slope((p, at_p): (f64, Vector2<f64>), (q, at_q): (f64, Vector2<f64>)) -> Vector2<f64> {
    (at_p * (q / p) - at_q * (p / q)) / (q - p)
}

fn tangent(crossing: &Crossing, along: Axis) -> Vector2<f64> {
    let slope = crossing.arms(along).slope;
    match along {
        Axis::Row => Vector2::new(1.0, slope),
        Axis::Column => Vector2::new(slope, 1.0),
    }
    .normalize()
}
