//! The things of one stage and the rays between camera, surfaces and projector.
//!
//! Takes a scene and a stage; answers what a camera position sees, what a projector position lights, and whether
//! the way between is free. No light is measured here, only places.

use nalgebra::Vector3;

use super::{
    scene::Scene,
    solid::{Hit, Solid, first_hit, is_free},
};
use crate::{
    geometry::{CameraPixel, Pose, ProjectorPixel, Ray, RigCalibration},
    stage::Stage,
};

/// Light from so far beside the raster is none, px: beyond a pixel, blur has nothing left to say.
const BESIDE_PX: f64 = 1.0;

/// The geometry of a scene in one stage; cheap to make.
#[derive(Debug, Clone)]
pub struct Space {
    pub(super) stage: Stage,
    pub(super) rig: RigCalibration,
    pub(super) solids: Vec<Solid>,
    room_from_camera: Pose,
    camera_from_room: Pose,
    projector_mm: Vector3<f64>,
}

/// A place that a camera ray ends at.
pub(super) struct Sight {
    pub(super) hit: Hit,
    /// Where on the projector's raster its light comes from; `None` in shadow and beside the raster.
    pub(super) projector: Option<ProjectorPixel>,
}

impl Space {
    /// The things that are there in a stage.
    #[must_use]
    pub fn new(scene: &Scene, stage: Stage) -> Self {
        Self {
            stage,
            rig: scene.calibration(),
            solids: scene.solids(stage),
            room_from_camera: scene.room_from_camera,
            camera_from_room: scene.room_from_camera.inverse(),
            projector_mm: scene.room_from_projector.translation_mm,
        }
    }

    /// The projector position whose light falls on what the camera sees at a position (px).
    ///
    /// `None` where it sees nothing, a shadow, or something that the projector's raster does not reach.
    #[must_use]
    pub fn projector_at(&self, at: CameraPixel) -> Option<ProjectorPixel> {
        self.sight(at)?.projector
    }

    /// The point (mm, camera frame) that the camera sees at a position (px).
    #[must_use]
    pub fn point_at(&self, at: CameraPixel) -> Option<Vector3<f64>> {
        Some(self.in_camera(&self.sight(at)?.hit.point))
    }

    /// From a place towards the projector and towards the camera, mm, in the room's frame.
    pub(super) fn ways(&self, from: &Vector3<f64>) -> [Vector3<f64>; 2] {
        [self.projector_mm, self.room_from_camera.translation_mm].map(|to| to - from)
    }

    /// What the camera sees at a position, px.
    pub(super) fn sight(&self, at: CameraPixel) -> Option<Sight> {
        let ahead = self.rig.camera.unproject(at.x, at.y)?;
        let ray = Ray::through(
            self.room_from_camera.translation_mm,
            self.room_from_camera.point(&ahead),
        )?;
        let hit = first_hit(&self.solids, &ray)?;
        let projector = self
            .light_source(&hit)
            .filter(|_| is_free(&self.solids, &hit, &self.projector_mm));
        Some(Sight { hit, projector })
    }

    /// What the light of a projector position falls on first.
    pub(super) fn lit_place(&self, at: ProjectorPixel) -> Option<Hit> {
        let ray = self.rig.projector_ray(at)?;
        let ahead = self.room_from_camera.point(&ray.at(1.0));
        first_hit(&self.solids, &Ray::through(self.projector_mm, ahead)?)
    }

    /// Where the camera sees a place, if nothing hides it.
    pub(super) fn seen_at(&self, hit: &Hit) -> Option<CameraPixel> {
        let pixel = self.rig.camera_pixel(&self.in_camera(&hit.point))?;
        let inside = self.rig.camera.contains(pixel.x, pixel.y);
        let camera = &self.room_from_camera.translation_mm;
        let faces = hit.normal.dot(&(camera - hit.point)) > 0.0;
        (inside && faces && is_free(&self.solids, hit, camera)).then_some(pixel)
    }

    /// A point of the room in the camera's frame, mm.
    pub(super) fn in_camera(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.camera_from_room.point(point)
    }

    /// A direction of the room in the camera's frame.
    pub(super) fn direction_in_camera(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.camera_from_room.direction(direction)
    }

    /// The projector position that would light a place if nothing stood between.
    fn light_source(&self, hit: &Hit) -> Option<ProjectorPixel> {
        let faces = hit.normal.dot(&(self.projector_mm - hit.point)) > 0.0;
        let at = self
            .rig
            .projector_pixel(&self.in_camera(&hit.point))
            .filter(|_| faces)?;
        let reach = |length: u32| -BESIDE_PX..f64::from(length) + BESIDE_PX;
        let lens = &self.rig.projector;
        (reach(lens.width).contains(&at.x) && reach(lens.height).contains(&at.y)).then_some(at)
    }
}
