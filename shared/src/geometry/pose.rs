//! A rigid transform: how one frame of reference stands in another.
//!
//! Named `b_from_a` everywhere: `projector_from_camera.point(&p)` takes a point in the camera's frame (mm) and
//! gives it in the projector's.

use nalgebra::{Matrix3, Rotation3, Vector3};
use serde::{Deserialize, Serialize};

/// How far from orthonormal a rotation may be, as the largest entry of R R' - 1: files give nine or ten digits.
const ORTHONORMAL_TOLERANCE: f64 = 1e-4;

/// A rotation followed by a translation in mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "PoseFile", into = "PoseFile")]
pub struct Pose {
    /// The rotation, orthonormal with determinant 1.
    pub rotation: Matrix3<f64>,
    /// The translation, mm: where frame a's origin lies in frame b.
    pub translation_mm: Vector3<f64>,
}

/// The two keys as they stand in `calibration.json`.
#[derive(Serialize, Deserialize)]
struct PoseFile {
    rotation: [[f64; 3]; 3],
    translation_mm: [f64; 3],
}

impl From<PoseFile> for Pose {
    fn from(file: PoseFile) -> Self {
        Self {
            rotation: Matrix3::from_fn(|row, column| file.rotation[row][column]),
            translation_mm: Vector3::from(file.translation_mm),
        }
    }
}

impl From<Pose> for PoseFile {
    fn from(pose: Pose) -> Self {
        let entry = |row, column| pose.rotation[(row, column)];
        Self {
            rotation: [0, 1, 2].map(|row| [0, 1, 2].map(|column| entry(row, column))),
            translation_mm: pose.translation_mm.into(),
        }
    }
}

impl Pose {
    /// The transform that changes nothing.
    #[must_use]
    pub fn identity() -> Self {
        Self {
            rotation: Matrix3::identity(),
            translation_mm: Vector3::zeros(),
        }
    }

    /// `world_from_device` of a device at `position` (mm) whose z axis points at `target` (mm).
    ///
    /// Its x axis stays level (y points down in the world), then it is turned by `roll_rad` clockwise as seen by
    /// the device. `None` when the target is the position itself, or straight above or below it.
    #[must_use]
    pub fn looking_at(position: Vector3<f64>, target: Vector3<f64>, roll_rad: f64) -> Option<Self> {
        let forward = (target - position).try_normalize(1e-9)?;
        let right = Vector3::y().cross(&forward).try_normalize(1e-9)?;
        let level = Matrix3::from_columns(&[right, forward.cross(&right), forward]);
        let roll = Rotation3::from_axis_angle(&Vector3::z_axis(), roll_rad);
        Some(Self {
            rotation: level * roll.matrix(),
            translation_mm: position,
        })
    }

    /// The pose turned about x, then y, then z by `angles_rad`, at `position` (mm).
    #[must_use]
    pub fn turned(position: Vector3<f64>, angles_rad: [f64; 3]) -> Self {
        let [x, y, z] = angles_rad;
        let rotation = Rotation3::from_euler_angles(x, y, z);
        Self {
            rotation: *rotation.matrix(),
            translation_mm: position,
        }
    }

    /// A point of frame a, in frame b (mm).
    #[must_use]
    pub fn point(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point + self.translation_mm
    }

    /// A direction of frame a, in frame b; lengths stay.
    #[must_use]
    pub fn direction(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * direction
    }

    /// `a_from_b`, the way back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self {
            rotation,
            translation_mm: -(rotation * self.translation_mm),
        }
    }

    /// `c_from_a`, where `self` is `c_from_b` and `b_from_a` comes first.
    #[must_use]
    pub fn after(&self, b_from_a: &Self) -> Self {
        Self {
            rotation: self.rotation * b_from_a.rotation,
            translation_mm: self.point(&b_from_a.translation_mm),
        }
    }

    /// What is wrong with the numbers, in words for an error message, or `None`.
    pub(crate) fn fault(&self) -> Option<String> {
        if !self
            .rotation
            .iter()
            .chain(self.translation_mm.iter())
            .all(|v| v.is_finite())
        {
            return Some("a number is not finite".to_owned());
        }
        let off = (self.rotation * self.rotation.transpose() - Matrix3::identity()).amax();
        if off > ORTHONORMAL_TOLERANCE {
            return Some(format!(
                "its rotation is not orthonormal (off by {off:.2e})"
            ));
        }
        (self.rotation.determinant() < 0.0).then(|| "its rotation is a mirror image".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_and_its_inverse_cancel() {
        let pose = Pose::turned(Vector3::new(10.0, -20.0, 300.0), [0.3, -0.7, 1.9]);
        let there_and_back = pose.inverse().after(&pose);
        assert!((there_and_back.rotation - Matrix3::identity()).amax() < 1e-12);
        assert!(there_and_back.translation_mm.amax() < 1e-9);
    }

    #[test]
    fn a_device_that_looks_at_a_point_has_it_on_its_axis_and_stays_level() {
        let position = Vector3::new(220.0, -60.0, 30.0);
        let target = Vector3::new(0.0, 40.0, 1000.0);
        let world_from_device = Pose::looking_at(position, target, 0.0).unwrap();
        let seen = world_from_device.inverse().point(&target);
        assert!(seen.x.abs() < 1e-9 && seen.y.abs() < 1e-9);
        assert!((seen.z - (target - position).norm()).abs() < 1e-9);
        assert!(
            world_from_device.rotation[(1, 0)].abs() < 1e-12,
            "the x axis is level"
        );
        assert_eq!(world_from_device.fault(), None);
    }

    #[test]
    fn looking_straight_down_has_no_level_direction() {
        let down = Vector3::new(0.0, 500.0, 0.0);
        assert_eq!(Pose::looking_at(Vector3::zeros(), down, 0.0), None);
        assert_eq!(Pose::looking_at(down, down, 0.0), None);
    }
}
