//! What a calibration says about matches before any depth is known: a camera position and the projector position
//! that lights it lie on a common plane with both lenses.
//!
//! Source: R. Hartley and A. Zisserman, "Multiple View Geometry", 2nd edition, sections 9.2 and 11.4.3.
//! Distortion is removed first, so the lines below are straight in positions "without distortion".

use nalgebra::{Matrix3, Vector3};

use super::{CameraPixel, Lens, ProjectorPixel, RigCalibration};

impl RigCalibration {
    /// The fundamental matrix F: `p' F c = 0` for matching homogeneous positions c of the camera and p of the
    /// projector, both without distortion, px. Scaled to norm 1.
    ///
    /// `None` only for a calibration that [`RigCalibration::check`] refuses.
    #[must_use]
    pub fn fundamental(&self) -> Option<Matrix3<f64>> {
        let pose = &self.projector_from_camera;
        let essential = pose.translation_mm.cross_matrix() * pose.rotation;
        let projector = pinhole(&self.projector).try_inverse()?;
        let f = projector.transpose() * essential * pinhole(&self.camera).try_inverse()?;
        (f.norm() > 0.0).then(|| f / f.norm())
    }

    /// The line on the projector (a x + b y + c = 0, a² + b² = 1, px without distortion) on which the light that
    /// falls on camera position `at` must come from.
    #[must_use]
    pub fn epipolar_line(&self, at: CameraPixel) -> Option<Vector3<f64>> {
        let line = self.fundamental()? * straight(&self.camera, at.x, at.y)?;
        let length = line.xy().norm();
        (length > 0.0).then(|| line / length)
    }

    /// How far a match is from being possible, px: Sampson's distance, to first order the smallest shift of the
    /// two positions together that makes their rays meet.
    #[must_use]
    pub fn sampson_px(&self, camera: CameraPixel, projector: ProjectorPixel) -> Option<f64> {
        let f = self.fundamental()?;
        let c = straight(&self.camera, camera.x, camera.y)?;
        let p = straight(&self.projector, projector.x, projector.y)?;
        let (on_projector, on_camera) = (f * c, f.transpose() * p);
        let slope = on_projector.xy().norm_squared() + on_camera.xy().norm_squared();
        (slope > 0.0).then(|| (p.dot(&(f * c))).abs() / slope.sqrt())
    }
}

fn pinhole(lens: &Lens) -> Matrix3<f64> {
    Matrix3::new(lens.fx, 0.0, lens.cx, 0.0, lens.fy, lens.cy, 0.0, 0.0, 1.0)
}

fn straight(lens: &Lens, x: f64, y: f64) -> Option<Vector3<f64>> {
    lens.without_distortion(x, y)
        .map(|position| position.push(1.0))
}

#[cfg(test)]
mod tests {
    use super::super::calibration::tests::desk_rig;
    use super::*;

    #[test]
    fn true_matches_lie_on_their_epipolar_line_and_shifted_ones_do_not() {
        let rig = desk_rig();
        for depth in [700.0, 1000.0, 1400.0] {
            let point = Vector3::new(60.0, -40.0, depth);
            let camera = rig.camera_pixel(&point).unwrap();
            let projector = rig.projector_pixel(&point).unwrap();
            let line = rig.epipolar_line(camera).unwrap();
            let straight = straight(&rig.projector, projector.x, projector.y).unwrap();
            assert!(line.dot(&straight).abs() < 1e-6, "at {depth} mm");
            assert!(rig.sampson_px(camera, projector).unwrap() < 1e-6);

            let along = Vector3::new(line.y, -line.x, 0.0) * 25.0;
            let across = Vector3::new(line.x, line.y, 0.0) * 25.0;
            let moved = |by: Vector3<f64>| {
                let shifted = ProjectorPixel::new(projector.x + by.x, projector.y + by.y);
                rig.sampson_px(camera, shifted).unwrap()
            };
            assert!(moved(across) > 8.0);
            assert!(moved(along) < 1.0);
        }
    }
}
