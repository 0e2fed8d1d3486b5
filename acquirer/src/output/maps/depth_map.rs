//! Depth in colours over the camera's picture: where the surface is, and where there is a hole.
//!
//! Takes shift rows, surface points or differences, gives the mesh's cells as the camera sees them, coloured by
//! relative depth, by distance in mm, or by height over the background in mm. Cells with a missing crossing or a cut
//! stay open.

use image::RgbImage;

use super::with_bar;
use crate::{
    output::{
        colour_map::Scale,
        figure::{Figure, subdued},
        relief::{mesh::Mesh, paint_flat},
        shift_table::ShiftRow,
    },
    pipeline::{
        grid::DecodedGrid,
        surface::{SurfacePoint, difference::Difference},
    },
};

/// The share of heights on either side that may be outliers; they take the colours of the ends.
const OUTLIERS: f64 = 0.01;

/// Colours the picture by relative depth.
#[must_use]
pub fn relative_depth_map(rows: &[ShiftRow], picture: &RgbImage) -> Figure {
    let mesh = Mesh::from_shifts(rows);
    let depths = mesh.nodes.iter().map(|node| node.position[2]);
    let scale = Scale::covering(depths, 0.0, "rel. depth");
    map(&mesh, &scale, picture)
}

/// Colours the picture by the distance along the camera's axis, in mm; near is yellow.
#[must_use]
pub fn surface_depth_map(
    points: &[SurfacePoint],
    grid: &DecodedGrid,
    picture: &RgbImage,
) -> Figure {
    let mesh = Mesh::from_surface(points, grid);
    let depths = mesh.nodes.iter().map(|node| node.position[2]);
    let scale = Scale::covering(depths, 0.0, "z / mm").turned();
    map(&mesh, &scale, picture)
}

/// Colours the picture by the object's height over the background, in mm; high is yellow.
#[must_use]
pub fn height_map(differences: &[Difference], grid: &DecodedGrid, picture: &RgbImage) -> Figure {
    let mesh = Mesh::from_differences(differences, grid);
    let heights = mesh.nodes.iter().map(|node| node.position[2]);
    let scale = Scale::covering(heights, OUTLIERS, "height / mm");
    map(&mesh, &scale, picture)
}

fn map(mesh: &Mesh, scale: &Scale, picture: &RgbImage) -> Figure {
    let drawing = with_bar(picture, scale);
    let mut picture = subdued(picture, 0.7);
    paint_flat(mesh, scale, &mut picture);
    Figure {
        picture,
        px_per_unit: 1.0,
        drawing,
    }
}
