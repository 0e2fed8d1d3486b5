//! The surface as a picture: what is raised, what is flat, what stays open.

use std::path::Path;

use image::RgbImage;
use shared::pattern::GridIndex;

use super::fixture::{BOX_MM, on_box, result};
use crate::output::{
    relief::{Colouring, Viewpoint, draw_relief, draw_surface, mesh::Mesh},
    shift_table::{ShiftRow, read_appendix_c},
};

fn appendix_c(object: &str) -> Vec<ShiftRow> {
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/recorded/appendix-c.csv");
    read_appendix_c(&table, object).unwrap()
}

/// Depth of each crossing in a block of rows and columns, as (row, column, depth).
fn block(mesh: &Mesh, rows: [u16; 2], columns: [u16; 2]) -> Vec<[f64; 3]> {
    let within = |i: &GridIndex| {
        (rows[0]..=rows[1]).contains(&i.row) && (columns[0]..=columns[1]).contains(&i.column)
    };
    let nodes = mesh.indices.iter().zip(&mesh.nodes);
    nodes
        .filter(|(index, _)| within(index))
        .map(|(index, node)| [index.row.into(), index.column.into(), node.position[2]])
        .collect()
}

/// Curvature across the columns: c of the least-squares fit of depth = a + b column + c column^2, once the mean
/// over the rows is taken.
fn bend(points: &[[f64; 3]]) -> f64 {
    let middle = points.iter().map(|p| p[1]).sum::<f64>() / points.len() as f64;
    let row = |p: &[f64; 3]| {
        let x = p[1] - middle;
        nalgebra::Vector4::new(1.0, x, x * x, p[0])
    };
    let mut normal = nalgebra::Matrix4::zeros();
    let mut right = nalgebra::Vector4::zeros();
    for point in points {
        let r = row(point);
        normal += r * r.transpose();
        right += r * point[2];
    }
    normal.lu().solve(&right).unwrap()[2]
}

fn mean_depth(points: &[[f64; 3]]) -> f64 {
    points.iter().map(|p| p[2]).sum::<f64>() / points.len() as f64
}

#[test]
fn both_objects_of_appendix_c_stand_out_of_their_background() {
    for object in ["cube", "cylinder"] {
        let mesh = Mesh::from_shifts(&appendix_c(object));
        let raised = mean_depth(&block(&mesh, [1, 8], [1, 6]));
        let wall = mean_depth(&block(&mesh, [1, 9], [11, 12]));
        assert!(raised > 7.0 && wall < 1.5, "{object}: {raised} on {wall}");
    }
}

#[test]
fn the_cylinder_of_appendix_c_is_curved_and_the_face_of_its_cube_is_flat() {
    let cylinder = Mesh::from_shifts(&appendix_c("cylinder"));
    let cube = Mesh::from_shifts(&appendix_c("cube"));
    let curved = bend(&block(&cylinder, [3, 11], [1, 7]));
    let flat = bend(&block(&cube, [2, 6], [0, 4]));
    assert!(curved < -0.15, "the cylinder bends by {curved}");
    assert!(flat.abs() < 0.25 * curved.abs(), "the face bends by {flat}");
    let across = block(&cylinder, [3, 11], [4, 4]);
    let depths = across.iter().map(|p| p[2]);
    let range = depths.clone().fold(f64::MIN, f64::max) - depths.fold(f64::MAX, f64::min);
    assert!(range < 1.6, "along its axis it is straight to {range}");
}

#[test]
fn beyond_its_edge_the_cube_of_appendix_c_falls_away() {
    let cube = Mesh::from_shifts(&appendix_c("cube"));
    let edge = mean_depth(&block(&cube, [1, 5], [5, 5]));
    let side = mean_depth(&block(&cube, [1, 5], [8, 9]));
    assert!(edge - side > 4.0, "{edge} at the edge, {side} on the side");
}

/// How many pixels are neither paper nor grey: the coloured surface.
fn coloured(picture: &RgbImage, is_meant: impl Fn([u8; 3]) -> bool) -> usize {
    picture.pixels().filter(|p| is_meant(p.0)).count()
}

#[test]
fn the_picture_of_the_cube_shows_a_bright_object_and_a_dark_background() {
    let rows = appendix_c("cube");
    let picture = draw_relief(&rows, Viewpoint::default(), Colouring::Depth).painted();
    let bright = |[r, g, b]: [u8; 3]| g > 60 && g > r.saturating_add(5) && g > b.saturating_add(20);
    let dark = |[r, g, b]: [u8; 3]| b > g.saturating_add(30) && r > g;
    assert!(coloured(&picture, bright) > 15_000);
    assert!(coloured(&picture, dark) > 5_000);
}

#[test]
fn no_facet_crosses_the_step_from_the_box_to_the_wall() {
    let scan = result(true);
    let grid = &scan.object.as_ref().unwrap().grid;
    let rows: Vec<ShiftRow> = scan.shifts.iter().map(ShiftRow::from).collect();
    // 14 x 14 cells, of which the ring round the 5 x 5 crossings of the box has 20; the shifts lack one corner
    let surface = Mesh::from_surface(&scan.surface, grid);
    let relief = Mesh::from_shifts(&rows);
    assert_eq!(surface.cells.len(), 196 - 20);
    assert_eq!(relief.cells.len(), 196 - 20 - 1);
    for mesh in [surface, relief] {
        for cell in &mesh.cells {
            let on = cell.map(|node| on_box(mesh.indices[node]));
            assert!(on.iter().all(|&side| side == on[0]));
        }
    }
}

#[test]
fn a_slope_and_noise_are_no_cuts() {
    let mut rows: Vec<ShiftRow> = result(false).shifts.iter().map(ShiftRow::from).collect();
    for row in &mut rows {
        let (i, j) = (f64::from(row.index.row), f64::from(row.index.column));
        (row.x_px, row.y_px) = (40.0 * j, 30.0 * i);
        row.shift_px = 2.0 * j + 0.3 * (7.0 * i + 3.0 * j).sin();
        row.depth = row.shift_px;
    }
    assert_eq!(Mesh::from_shifts(&rows).cells.len(), 195);
}

#[test]
fn a_single_wrong_label_does_not_squeeze_the_rest() {
    let mut scan = result(true);
    for point in &mut scan.surface {
        if (point.row, point.column) == (Some(2), Some(2)) {
            point.position_mm[2] = 9000.0;
        }
    }
    let mesh = Mesh::from_surface(&scan.surface, &scan.object.as_ref().unwrap().grid);
    assert_eq!(mesh.nodes.len(), 224);
    assert!(mesh.dots.iter().all(|dot| dot.position[2] <= 1100.0));
    assert!(mesh.nodes.iter().any(|node| node.position[2] == BOX_MM));
}

#[test]
fn nothing_measured_and_numbers_without_end_are_drawn_as_an_empty_box() {
    let mut rows: Vec<ShiftRow> = result(false).shifts.iter().map(ShiftRow::from).collect();
    rows.truncate(1);
    rows[0].depth = f64::NAN;
    for rows in [&rows[..], &[]] {
        let figure = draw_relief(rows, Viewpoint::default(), Colouring::Depth);
        assert_eq!(figure.picture.dimensions(), (1200, 900));
    }
    let empty = draw_surface(
        &[],
        &Default::default(),
        Viewpoint::default(),
        Colouring::Depth,
    );
    let violet = |[r, g, b]: [u8; 3]| b > g.saturating_add(30) && r > g;
    assert_eq!(coloured(&empty.picture, violet), 0);
}
