//! The surface as a picture: shaded, from any side, with axes and a colour bar.
//!
//! Takes the shift table (camera px and relative depth, as in the thesis's figures 5.7 and 5.9) or the points of
//! a calibrated scan (mm, true to scale), gives a picture. Cells of the grid are filled where the mesh has them
//! (see [`mesh`]); edges sharper than `CREASE_COSINE` stay sharp, flatter ones are shaded smoothly.

mod axes;

pub mod mesh;

mod raster;

mod view;

use image::{Rgb as Pixel, RgbImage};

use self::{
    axes::Axes,
    mesh::{Mesh, Node},
    raster::{Corner, draw_over},
    view::Projection,
};
pub use view::Viewpoint;

use super::{colour_map::Scale, drawing::Drawing, figure::Figure, shift_table::ShiftRow};
use crate::pipeline::{grid::DecodedGrid, surface::SurfacePoint};

/// Width and height of the picture, in px.
const SIZE_PX: [u32; 2] = [1200, 900];
/// The part of it for the box: left, top, width, height.
const FRAME_PX: [f64; 4] = [165.0, 30.0, 790.0, 790.0];
/// The part of it for the colour bar: left, top, width, height.
const BAR_PX: [f64; 4] = [965.0, 160.0, 230.0, 520.0];
/// Radius of a measured vertex, and of a point along a line, in px.
const DOT_PX: [f64; 2] = [1.7, 1.0];
/// Dots take at most this share of the way to the next crossing, so that fine grids are not covered by them.
const DOT_SHARE: f64 = 0.08;
/// Cosine of the angle between two cells from which on their common edge is shown as an edge: 30 degrees.
const CREASE_COSINE: f64 = 0.87;
/// A relief's depth range is drawn as long as this share of its larger side.
const RELIEF_SHARE: f64 = 0.4;

/// What colours the surface.
#[derive(Debug, Clone, Copy)]
pub enum Colouring<'a> {
    /// Its depth.
    Depth,
    /// What the camera sees there.
    Picture(&'a RgbImage),
}

/// Draws the relief that a shift table holds: x and y in camera px, height is the relative depth.
#[must_use]
pub fn draw_relief(rows: &[ShiftRow], from: Viewpoint, colouring: Colouring<'_>) -> Figure {
    let mesh = Mesh::from_shifts(rows);
    let mut axes = axes(&mesh, ["x / px", "y / px", "relative depth"]);
    let [x, y, depth] = &mut axes.0;
    let side = (x.high - x.low).max(y.high - y.low);
    depth.factor = -RELIEF_SHARE * side / (depth.high - depth.low);
    let scale = scale(&mesh, "relative depth");
    draw(&mesh, (&axes, from), (&scale, colouring))
}

/// Draws the surface that the vertices of a calibrated scan span, in mm, true to scale.
#[must_use]
pub fn draw_surface(
    points: &[SurfacePoint],
    grid: &DecodedGrid,
    from: Viewpoint,
    colouring: Colouring<'_>,
) -> Figure {
    let mesh = Mesh::from_surface(points, grid);
    let axes = axes(&mesh, ["x / mm", "y / mm", "z / mm"]);
    let scale = scale(&mesh, "z / mm").turned();
    draw(&mesh, (&axes, from), (&scale, colouring))
}

fn axes(mesh: &Mesh, names: [&'static str; 3]) -> Axes {
    let positions: Vec<_> = mesh.dots.iter().map(|dot| dot.position).collect();
    Axes::around(&positions, names)
}

fn scale(mesh: &Mesh, name: &str) -> Scale {
    Scale::covering(mesh.nodes.iter().map(|node| node.position[2]), 0.0, name)
}

fn draw(
    mesh: &Mesh,
    (axes, from): (&Axes, Viewpoint),
    (scale, colouring): (&Scale, Colouring<'_>),
) -> Figure {
    let [width, height] = SIZE_PX;
    let projection = Projection::fitting(axes, from, FRAME_PX);
    let mut picture = RgbImage::from_pixel(width, height, Pixel([255; 3]));
    let new_drawing = || Drawing::new(f64::from(width), f64::from(height));
    let mut walls = new_drawing();
    axes.draw_walls(&projection, &mut walls);
    walls.paint(&mut picture, 1.0);

    let colour = |value: [f64; 2]| match colouring {
        Colouring::Depth => scale.colour(value[0]),
        Colouring::Picture(seen) => pixel_at(seen, value),
    };
    let cells = cell_corners(mesh, &projection, colouring);
    let [vertex_px, line_px] = DOT_PX;
    let most = DOT_SHARE * spacing_px(mesh, &projection);
    draw_over(&mut picture, |samples| {
        for corners in &cells {
            samples.cell(corners, &colour);
        }
        for dot in &mesh.dots {
            let radius = if dot.is_vertex { vertex_px } else { line_px };
            let own = || match (colouring, dot.colour) {
                (Colouring::Depth, _) => scale.colour(dot.position[2]),
                (Colouring::Picture(_), Some(colour)) => colour,
                (Colouring::Picture(seen), None) => {
                    pixel_at(seen, [dot.position[0], dot.position[1]])
                }
            };
            samples.dot(projection.place(dot.position), radius.min(most), own);
        }
    });

    let mut drawing = new_drawing();
    axes.draw_labels(&projection, &mut drawing);
    if matches!(colouring, Colouring::Depth) {
        scale.draw(&mut drawing, BAR_PX, 1.2);
    }
    Figure {
        picture,
        px_per_unit: 1.0,
        drawing,
    }
}

/// The median length of the cells' sides on the drawing, in px; without cells, without bound.
fn spacing_px(mesh: &Mesh, projection: &Projection) -> f64 {
    let mut lengths: Vec<f64> = mesh
        .cells
        .iter()
        .flat_map(|&[a, b, _, d]| [(a, b), (a, d)])
        .map(|(a, b)| {
            let [p, q] = [a, b].map(|node| projection.place(mesh.nodes[node].position));
            (p[0] - q[0]).hypot(p[1] - q[1])
        })
        .collect();
    lengths.sort_by(f64::total_cmp);
    let median = lengths.get(lengths.len() / 2);
    median.copied().unwrap_or(f64::INFINITY)
}

/// Paints the cells over the camera's picture, where it sees them, coloured by depth and not shaded.
pub(super) fn paint_flat(mesh: &Mesh, scale: &Scale, picture: &mut RgbImage) {
    let corner = |node: usize| {
        let Node {
            position, seen_at, ..
        } = mesh.nodes[node];
        let [x, y] = seen_at.unwrap_or([f64::NAN; 2]);
        Corner {
            place: [x, y, position[2]],
            normal: [0.0; 3],
            value: [position[2], 0.0],
        }
    };
    draw_over(picture, |samples| {
        for cell in &mesh.cells {
            samples.cell(&cell.map(corner), &|value| scale.colour(value[0]));
        }
    });
}

/// The corners of every cell as they are drawn.
fn cell_corners(
    mesh: &Mesh,
    projection: &Projection,
    colouring: Colouring<'_>,
) -> Vec<[Corner; 4]> {
    let turned: Vec<_> = mesh
        .nodes
        .iter()
        .map(|n| projection.turned(n.position))
        .collect();
    let normals: Vec<_> = mesh
        .cells
        .iter()
        .map(|cell| cell_normal(cell, &turned))
        .collect();
    let mut cells_of_node = vec![Vec::new(); mesh.nodes.len()];
    for (c, cell) in mesh.cells.iter().enumerate() {
        for &node in cell {
            cells_of_node[node].push(c);
        }
    }
    let corner = |c: usize, node: usize| {
        let smooth = cells_of_node[node]
            .iter()
            .filter(|&&other| dot(normals[c], normals[other]) > CREASE_COSINE)
            .fold([0.0; 3], |sum, &other| add(sum, normals[other]));
        let Node {
            position, seen_at, ..
        } = mesh.nodes[node];
        Corner {
            place: projection.place(position),
            normal: smooth,
            value: match colouring {
                Colouring::Depth => [position[2], 0.0],
                Colouring::Picture(_) => seen_at.unwrap_or([f64::NAN; 2]),
            },
        }
    };
    let cells = mesh.cells.iter().enumerate();
    cells
        .map(|(c, cell)| cell.map(|node| corner(c, node)))
        .collect()
}

/// The direction square to a cell, of length 1: that of its diagonals' cross product.
fn cell_normal(cell: &[usize; 4], turned: &[[f64; 3]]) -> [f64; 3] {
    let [a, b, c, d] = cell.map(|node| turned[node]);
    let (u, v) = (sub(c, a), sub(d, b));
    let normal = [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    let length = dot(normal, normal).sqrt().max(f64::MIN_POSITIVE);
    normal.map(|n| n / length)
}

/// The colour of a picture at a position between its pixels; grey where there is none.
fn pixel_at(picture: &RgbImage, [x, y]: [f64; 2]) -> [u8; 3] {
    if !(x.is_finite() && y.is_finite()) || picture.width() == 0 || picture.height() == 0 {
        return [160; 3];
    }
    let clamp = |v: f64, length: u32| v.clamp(0.0, f64::from(length - 1));
    let (x, y) = (
        clamp(x - 0.5, picture.width()),
        clamp(y - 0.5, picture.height()),
    );
    let (left, top) = (x as u32, y as u32);
    let (right, bottom) = (
        (left + 1).min(picture.width() - 1),
        (top + 1).min(picture.height() - 1),
    );
    let (fx, fy) = (x.fract(), y.fract());
    [0, 1, 2].map(|c| {
        let at = |x, y| f64::from(picture.get_pixel(x, y)[c]);
        let upper = at(left, top) * (1.0 - fx) + at(right, top) * fx;
        let lower = at(left, bottom) * (1.0 - fx) + at(right, bottom) * fx;
        (upper * (1.0 - fy) + lower * fy + 0.5) as u8
    })
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + b[k])
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}
