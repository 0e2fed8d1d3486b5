//! The points of the surface as a PLY file, for MeshLab, CloudCompare, Open3D and the like.
//!
//! Takes surface points, gives binary little-endian bytes with the properties `x y z` (float, millimetres,
//! camera frame), `red green blue` (uchar), `row column` (int, -1 where the point lies on no line of that
//! direction) and `confidence` (float, 0 to 1). Where finer grids were read beside the base grid, `grid` (int) says by
//! its number of lines which grid a point, its row and its column belong to. Source: G. Turk, "The PLY Polygon File Format", 1994.

use super::tables::{finite_points, share};
use crate::pipeline::surface::SurfacePoint;

/// The bytes of a PLY file with the points of one or more grids, each with its number of lines; `calibration` says in a
/// comment where the millimetres come from.
#[must_use]
pub fn point_cloud(grids: &[(usize, &[SurfacePoint])], calibration: &str) -> Vec<u8> {
    let with_grid = grids.len() > 1;
    let of_grid = |&(lines, surface): &(usize, _)| (lines, finite_points(surface));
    let points: Vec<_> = grids
        .iter()
        .map(of_grid)
        .flat_map(|(lines, points)| points.map(move |point| (lines, point)))
        .collect();
    let mut bytes = header(points.len(), calibration, with_grid).into_bytes();
    for (lines, point) in points {
        for v in point.position_mm {
            bytes.extend((v as f32).to_le_bytes());
        }
        bytes.extend(point.colour);
        for line in [point.row, point.column] {
            bytes.extend(line.map_or(-1, i32::from).to_le_bytes());
        }
        bytes.extend((share(point.confidence) as f32).to_le_bytes());
        if with_grid {
            bytes.extend((lines as i32).to_le_bytes());
        }
    }
    bytes
}

fn header(points: usize, calibration: &str, with_grid: bool) -> String {
    // a line break in the name would end the comment
    let calibration: String = calibration
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    let grid = match with_grid {
        true => "property int grid\n",
        false => "",
    };
    format!(
        "ply\n\
         format binary_little_endian 1.0\n\
         comment frame camera: x right, y down, z forward, origin at the lens\n\
         comment units millimetres\n\
         comment calibration {calibration}\n\
         comment row and column count from 0; -1: the point lies on no line of that direction\n\
         element vertex {points}\n\
         property float x\n\
         property float y\n\
         property float z\n\
         property uchar red\n\
         property uchar green\n\
         property uchar blue\n\
         property int row\n\
         property int column\n\
         property float confidence\n\
         {grid}end_header\n"
    )
}
