//! The points of the surface as a PLY file, for MeshLab, CloudCompare, Open3D and the like.
//!
//! Takes surface points, gives binary little-endian bytes with the properties `x y z` (float, millimetres,
//! camera frame), `red green blue` (uchar), `row column` (int, -1 where the point lies on no line of that
//! direction) and `confidence` (float, 0 to 1). Source: G. Turk, "The PLY Polygon File Format", 1994.

use super::tables::{finite_points, share};
use crate::pipeline::surface::SurfacePoint;

/// The bytes of a PLY file; `calibration` says in a comment where the millimetres come from.
#[must_use]
pub fn point_cloud(surface: &[SurfacePoint], calibration: &str) -> Vec<u8> {
    let points: Vec<_> = finite_points(surface).collect();
    let mut bytes = header(points.len(), calibration).into_bytes();
    for point in points {
        for v in point.position_mm {
            bytes.extend((v as f32).to_le_bytes());
        }
        bytes.extend(point.colour);
        for line in [point.row, point.column] {
            bytes.extend(line.map_or(-1, i32::from).to_le_bytes());
        }
        bytes.extend((share(point.confidence) as f32).to_le_bytes());
    }
    bytes
}

fn header(points: usize, calibration: &str) -> String {
    // a line break in the name would end the comment
    let calibration: String = calibration
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
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
         end_header\n"
    )
}
