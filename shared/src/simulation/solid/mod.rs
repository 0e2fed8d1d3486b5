//! The things in the room: a shape, where it stands, what its surface is like; and what a ray meets first.
//!
//! All lengths are mm, in the room's frame unless a name says `local`.

mod mesh;
mod mesh_file;
mod shape;

use nalgebra::Vector3;

use super::surface::Surface;
use crate::geometry::{Pose, Ray};

pub(super) use mesh::{Mesh, MeshData};
pub(super) use mesh_file::read_mesh;
pub(super) use shape::Shape;

/// A ray that leaves a surface starts this far above it, so that it does not meet the surface itself, mm.
const LIFT_MM: f64 = 1e-4;

/// Surfaces are coloured this far beneath them, so that a pattern's border on the very surface stays clean, mm.
const SKIN_MM: f64 = 0.01;

/// One thing in the room.
#[derive(Debug, Clone)]
pub(super) struct Solid {
    pub(super) shape: Shape,
    pub(super) surface: Surface,
    room_from_local: Pose,
    local_from_room: Pose,
    reach_mm: f64,
}

/// Where a ray meets a surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    /// The place, mm.
    pub(super) point: Vector3<f64>,
    /// Unit length, on the side that the ray comes from.
    pub(super) normal: Vector3<f64>,
    /// Unit length; differs from `normal` where a mesh is shaded smooth.
    pub(super) shading_normal: Vector3<f64>,
    /// The solid's place in the list.
    pub(super) solid: usize,
}

impl Solid {
    /// A shape put into the room.
    pub(super) fn new(shape: Shape, room_from_local: Pose, surface: Surface) -> Self {
        let reach_mm = shape.reach_mm() + LIFT_MM;
        Self {
            shape,
            surface,
            local_from_room: room_from_local.inverse(),
            room_from_local,
            reach_mm,
        }
    }

    /// The surface's colour at a hit: the share of red, green and blue light that it gives back, 0 to 1.
    pub(super) fn albedo(&self, hit: &Hit) -> [f32; 3] {
        let beneath = hit.point - hit.normal * SKIN_MM;
        self.surface.albedo(&self.local_from_room.point(&beneath))
    }

    fn is_near(&self, ray: &Ray) -> bool {
        let to_centre = self.room_from_local.translation_mm - ray.origin;
        let along = to_centre.dot(&ray.direction);
        let reach2 = self.reach_mm * self.reach_mm;
        let distance2 = to_centre.norm_squared();
        (along > 0.0 || distance2 < reach2) && distance2 - along * along < reach2
    }

    fn localise(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.local_from_room.point(&ray.origin),
            direction: self.local_from_room.direction(&ray.direction),
        }
    }
}

/// What a ray meets first among the solids.
pub(super) fn first_hit(solids: &[Solid], ray: &Ray) -> Option<Hit> {
    let mut nearest = f64::INFINITY;
    let mut found = None;
    for (index, solid) in solids.iter().enumerate() {
        if !solid.is_near(ray) {
            continue;
        }
        if let Some(local) = solid.shape.meet(&solid.localise(ray), nearest) {
            nearest = local.distance_mm;
            found = Some((index, local));
        }
    }
    let (solid, local) = found?;
    let facing = |n: Vector3<f64>| if n.dot(&ray.direction) > 0.0 { -n } else { n };
    let pose = &solids[solid].room_from_local;
    Some(Hit {
        point: ray.at(local.distance_mm),
        normal: facing(pose.direction(&local.normal)),
        shading_normal: facing(pose.direction(&local.shading_normal)),
        solid,
    })
}

/// Whether nothing stands between a place just above a surface and another place.
pub(super) fn is_free(solids: &[Solid], from: &Hit, to: &Vector3<f64>) -> bool {
    let origin = from.point + from.normal * LIFT_MM;
    let Some(ray) = Ray::through(origin, *to) else {
        return true;
    };
    let distance = (to - origin).norm();
    !solids
        .iter()
        .filter(|solid| solid.is_near(&ray))
        .any(|solid| solid.shape.meet(&solid.localise(&ray), distance).is_some())
}
