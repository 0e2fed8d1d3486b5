//! The calibration of a rig: two lenses and how they stand to each other; the file `calibration.json`.
//!
//! Everything is expressed in the camera's frame (mm). Unknown extra keys of the file are allowed.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{CameraPixel, Lens, Meeting, Plane, Pose, ProjectorPixel, Ray};

/// Rounds of "where does the camera ray cross the line's plane, and how high on the line is that".
const LINE_ROUNDS: usize = 12;

/// The height on the line has settled when it moves less than this, px.
const LINE_SETTLED_PX: f64 = 1e-9;

/// Half the length of the piece of a line that stands for its tangent, px.
const TANGENT_PX: f64 = 0.5;

/// A camera and a projector in fixed places.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RigCalibration {
    /// The camera's lens.
    pub camera: Lens,
    /// The projector's lens.
    pub projector: Lens,
    /// Takes points of the camera's frame into the projector's.
    pub projector_from_camera: Pose,
}

/// Why a calibration can't be used.
#[derive(Debug, Error)]
pub enum CalibrationError {
    /// It is not JSON with the expected keys.
    #[error(
        "the calibration can't be read: {0}; it needs camera, projector (width height fx fy cx cy \
         distortion[5]) and projector_from_camera (rotation 3x3, translation_mm)"
    )]
    Json(#[from] serde_json::Error),
    /// A number makes no sense.
    #[error("the calibration's {part}: {fault}; calibrate again or correct the file")]
    Value {
        /// The key of the part that is wrong.
        part: &'static str,
        /// What is wrong with it.
        fault: String,
    },
}

impl RigCalibration {
    /// Reads the bytes of a `calibration.json`.
    ///
    /// # Errors
    /// When it is not such a file, or a value can't be (see [`RigCalibration::check`]).
    pub fn from_json(bytes: &[u8]) -> Result<Self, CalibrationError> {
        let calibration: Self = serde_json::from_slice(bytes)?;
        calibration.check()?;
        Ok(calibration)
    }

    /// The text of a `calibration.json`, numbers in full precision.
    ///
    /// # Errors
    /// When a value can't be (see [`RigCalibration::check`]); JSON has no way to write such numbers either.
    pub fn to_json(&self) -> Result<String, CalibrationError> {
        self.check()?;
        Ok(serde_json::to_string_pretty(self)?)
    }

    /// Checks that every number is finite, focal lengths and rasters are positive, the rotation is orthonormal,
    /// and the two devices are not in the same place.
    ///
    /// # Errors
    /// The first part that fails.
    pub fn check(&self) -> Result<(), CalibrationError> {
        let apart = self.projector_from_camera.translation_mm.norm() > 0.0;
        let faults = [
            ("camera", self.camera.fault()),
            ("projector", self.projector.fault()),
            ("projector_from_camera", self.projector_from_camera.fault()),
            (
                "projector_from_camera",
                (!apart).then(|| "camera and projector are in the same place".to_owned()),
            ),
        ];
        let found = faults
            .into_iter()
            .find_map(|(part, fault)| Some((part, fault?)));
        found.map_or(Ok(()), |(part, fault)| {
            Err(CalibrationError::Value { part, fault })
        })
    }

    /// Where the camera sees a point (mm, camera frame); may lie outside its raster.
    #[must_use]
    pub fn camera_pixel(&self, point: &Vector3<f64>) -> Option<CameraPixel> {
        let position = self.camera.project(point)?;
        Some(CameraPixel::new(position.x, position.y))
    }

    /// What projector position lights a point (mm, camera frame); may lie outside its raster.
    #[must_use]
    pub fn projector_pixel(&self, point: &Vector3<f64>) -> Option<ProjectorPixel> {
        let position = self
            .projector
            .project(&self.projector_from_camera.point(point))?;
        Some(ProjectorPixel::new(position.x, position.y))
    }

    /// The ray that a camera position sees, in the camera frame.
    #[must_use]
    pub fn camera_ray(&self, at: CameraPixel) -> Option<Ray> {
        Ray::through(Vector3::zeros(), self.camera.unproject(at.x, at.y)?)
    }

    /// The ray that a projector position lights, in the camera frame.
    #[must_use]
    pub fn projector_ray(&self, at: ProjectorPixel) -> Option<Ray> {
        let camera_from_projector = self.projector_from_camera.inverse();
        let ahead = self.projector.unproject(at.x, at.y)?;
        Ray::through(
            camera_from_projector.translation_mm,
            camera_from_projector.point(&ahead),
        )
    }

    /// The plane of light (camera frame) of the projector column through `at`.
    ///
    /// With projector distortion a column is not quite a plane; this is its tangent at `at`.
    #[must_use]
    pub fn column_plane(&self, at: ProjectorPixel) -> Option<Plane> {
        self.light_plane(at, 0.0, TANGENT_PX)
    }

    /// The plane of light (camera frame) of the projector row through `at`; as [`RigCalibration::column_plane`].
    #[must_use]
    pub fn row_plane(&self, at: ProjectorPixel) -> Option<Plane> {
        self.light_plane(at, TANGENT_PX, 0.0)
    }

    /// The point (mm, camera frame) that the camera sees at `at` and the projector's column at `x_px` lights.
    ///
    /// Exact with projector distortion too. `None` when the camera ray runs along that light, or misses it.
    #[must_use]
    pub fn point_on_column(&self, at: CameraPixel, x_px: f64) -> Option<Vector3<f64>> {
        let start = ProjectorPixel::new(x_px, f64::from(self.projector.height) / 2.0);
        self.point_on_line(
            at,
            start,
            |p| ProjectorPixel::new(x_px, p.y),
            Self::column_plane,
        )
    }

    /// The point (mm, camera frame) that the camera sees at `at` and the projector's row at `y_px` lights.
    ///
    /// As [`RigCalibration::point_on_column`].
    #[must_use]
    pub fn point_on_row(&self, at: CameraPixel, y_px: f64) -> Option<Vector3<f64>> {
        let start = ProjectorPixel::new(f64::from(self.projector.width) / 2.0, y_px);
        self.point_on_line(
            at,
            start,
            |p| ProjectorPixel::new(p.x, y_px),
            Self::row_plane,
        )
    }

    /// The point (mm, camera frame) where a camera ray and a projector ray come closest.
    #[must_use]
    pub fn triangulate(&self, camera: CameraPixel, projector: ProjectorPixel) -> Option<Meeting> {
        self.camera_ray(camera)?
            .meet(&self.projector_ray(projector)?)
    }

    fn light_plane(&self, at: ProjectorPixel, dx: f64, dy: f64) -> Option<Plane> {
        let before = self.projector_ray(ProjectorPixel::new(at.x - dx, at.y - dy))?;
        let after = self.projector_ray(ProjectorPixel::new(at.x + dx, at.y + dy))?;
        Plane::spanned(&before.origin, &before.direction, &after.direction)
    }

    fn point_on_line(
        &self,
        at: CameraPixel,
        start: ProjectorPixel,
        onto_line: impl Fn(ProjectorPixel) -> ProjectorPixel,
        plane: impl Fn(&Self, ProjectorPixel) -> Option<Plane>,
    ) -> Option<Vector3<f64>> {
        let ray = self.camera_ray(at)?;
        let mut on_line = start;
        for _ in 0..LINE_ROUNDS {
            let point = ray.meet_plane(&plane(self, on_line)?)?;
            let next = onto_line(self.projector_pixel(&point)?);
            let moved = (next.x - on_line.x).hypot(next.y - on_line.y);
            on_line = next;
            if moved < LINE_SETTLED_PX {
                break;
            }
        }
        ray.meet_plane(&plane(self, on_line)?)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A rig like the one of a desk: 22 cm diagonal baseline, a metre to the scene, both lenses distorted.
    pub(in crate::geometry) fn desk_rig() -> RigCalibration {
        let camera = Lens {
            width: 640,
            height: 480,
            fx: 690.0,
            fy: 690.0,
            cx: 324.3,
            cy: 236.9,
            distortion: [-0.06, 0.02, 0.0, 0.0, 0.0],
        };
        let projector = Lens {
            width: 1024,
            height: 768,
            fx: 1270.0,
            fy: 1270.0,
            cx: 512.0,
            cy: 700.0,
            distortion: [0.03, -0.05, 0.001, -0.001, 0.0],
        };
        let position = Vector3::new(170.0, -140.0, 0.0);
        let target = Vector3::new(0.0, 0.0, 1000.0);
        let camera_from_projector = Pose::looking_at(position, target, 0.02).unwrap();
        RigCalibration {
            camera,
            projector,
            projector_from_camera: camera_from_projector.inverse(),
        }
    }

    fn sights() -> impl Iterator<Item = Vector3<f64>> {
        (-2..=2).flat_map(|x| {
            (-2..=2).map(move |y| {
                Vector3::new(
                    f64::from(x) * 90.0,
                    f64::from(y) * 70.0,
                    950.0 + f64::from(x * y) * 20.0,
                )
            })
        })
    }

    #[test]
    fn a_point_is_found_again_from_its_two_positions() {
        let rig = desk_rig();
        for point in sights() {
            let camera = rig.camera_pixel(&point).unwrap();
            let projector = rig.projector_pixel(&point).unwrap();
            let meeting = rig.triangulate(camera, projector).unwrap();
            assert!(
                (meeting.point - point).norm() < 1e-6,
                "{point} came back as {}",
                meeting.point
            );
            assert!(meeting.gap_mm < 1e-6);
            assert!(meeting.sine > 0.15);
        }
    }

    #[test]
    fn a_point_is_found_again_from_one_line_through_a_distorted_projector() {
        let rig = desk_rig();
        for point in sights() {
            let camera = rig.camera_pixel(&point).unwrap();
            let projector = rig.projector_pixel(&point).unwrap();
            let by_column = rig.point_on_column(camera, projector.x).unwrap();
            let by_row = rig.point_on_row(camera, projector.y).unwrap();
            assert!(
                (by_column - point).norm() < 1e-5,
                "column: {by_column} for {point}"
            );
            assert!((by_row - point).norm() < 1e-5, "row: {by_row} for {point}");
        }
    }

    #[test]
    fn the_file_gives_back_the_same_calibration() {
        let rig = desk_rig();
        let back = RigCalibration::from_json(rig.to_json().unwrap().as_bytes()).unwrap();
        assert_eq!((back.camera, back.projector), (rig.camera, rig.projector));
        let point = Vector3::new(120.0, -80.0, 1100.0);
        let error =
            back.projector_from_camera.point(&point) - rig.projector_from_camera.point(&point);
        assert!(error.norm() < 1e-9);
    }

    #[test]
    fn a_broken_file_is_refused_with_the_part_that_is_wrong() {
        let good = desk_rig().to_json().unwrap();
        let refused = |bytes: &[u8]| RigCalibration::from_json(bytes).unwrap_err().to_string();
        assert!(refused(b"").contains("can't be read"));
        assert!(refused(b"\xff\x00").contains("can't be read"));
        assert!(refused(b"{}").contains("camera"));
        let no_focus = good.replacen("\"fx\": 690.0", "\"fx\": -690.0", 1);
        assert!(refused(no_focus.as_bytes()).contains("camera: its focal lengths -690"));
        let no_raster = good.replacen("\"width\": 1024", "\"width\": 0", 1);
        assert!(refused(no_raster.as_bytes()).contains("projector: its raster is 0 x 768"));
    }

    #[test]
    fn rotations_that_are_none_are_refused() {
        let mut rig = desk_rig();
        rig.projector_from_camera.rotation *= 1.01;
        assert!(
            rig.check()
                .unwrap_err()
                .to_string()
                .contains("not orthonormal")
        );
        rig.projector_from_camera.rotation = -nalgebra::Matrix3::identity();
        assert!(rig.check().unwrap_err().to_string().contains("mirror"));
        let mut rig = desk_rig();
        rig.projector_from_camera.translation_mm = Vector3::zeros();
        assert!(rig.check().unwrap_err().to_string().contains("same place"));
        rig.projector_from_camera.translation_mm.x = f64::NAN;
        assert!(rig.check().unwrap_err().to_string().contains("not finite"));
    }
}
