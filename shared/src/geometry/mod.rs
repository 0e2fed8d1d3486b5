//! Where light goes: pixels, lenses, poses, and the rig made of one camera and one projector.
//!
//! # Conventions
//! - Pixel positions are edge coordinates: pixel k covers `[k, k + 1)`, its centre is at k + 1/2.
//! - In every frame of reference x points right, y points down, z points forward; lengths are millimetres.
//! - A transform is named `b_from_a`: it takes the coordinates of a point in frame a and gives those in frame b.
//! - Results that do not exist (a point behind the lens, parallel rays) are `None`, never a number.

mod pixel;

mod lens;

mod pose;

mod ray;

mod calibration;

mod epipolar;

pub use calibration::{CalibrationError, RigCalibration};
pub use lens::Lens;
pub use pixel::{CameraPixel, ProjectorPixel};
pub use pose::Pose;
pub use ray::{Meeting, Plane, Ray};
