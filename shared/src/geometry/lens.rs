//! A lens in front of a raster: pinhole projection with Brown's radial and tangential distortion.
//!
//! Takes points in the device's own frame of reference (mm) and gives positions on its raster (px, edge
//! coordinates), and back. The same model serves the camera and the projector, which is a camera run backwards.
//! Source: D. C. Brown, "Close-range camera calibration", 1971, with the coefficient order of OpenCV.
//! Fails quietly where the coefficients were fitted to the middle of a picture only: the polynomial then bends
//! positions near the corners to wherever it likes.

use nalgebra::{Matrix2, Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// Steps of the inverse of the distortion; it doubles its digits at each, so real lenses need four or five.
const INVERSE_STEPS: usize = 30;

/// The inverse is accepted when it reproduces the position to this, in units of the focal length (about 1e-9 px).
const INVERSE_TOLERANCE: f64 = 1e-12;

/// The intrinsic parameters of a camera or projector; the `camera` and `projector` objects of `calibration.json`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Lens {
    /// Columns of the raster, px, at least 1.
    pub width: u32,
    /// Rows of the raster, px, at least 1.
    pub height: u32,
    /// Focal length along x, px, above 0.
    pub fx: f64,
    /// Focal length along y, px, above 0.
    pub fy: f64,
    /// Principal point, px, edge coordinates.
    pub cx: f64,
    /// Principal point, px, edge coordinates.
    pub cy: f64,
    /// Brown's coefficients k1, k2, p1, p2, k3; all 0 is a perfect pinhole.
    pub distortion: [f64; 5],
}

impl Lens {
    /// The position (px) where a point (mm, the device's own frame) falls.
    ///
    /// `None` for a point beside or behind the lens, and for one so far off the axis that the distortion
    /// polynomial has turned round. The position may lie outside the raster, see [`Lens::contains`].
    #[must_use]
    pub fn project(&self, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        if point.z <= 0.0 {
            return None;
        }
        let ideal = Vector2::new(point.x / point.z, point.y / point.z);
        let (distorted, slope) = self.distort(&ideal);
        let folded = slope.determinant() <= 0.0 || slope.trace() <= 0.0;
        let position = self.to_raster(&distorted);
        (!folded && position.iter().all(|v| v.is_finite())).then_some(position)
    }

    /// The point at depth 1 (mm, the device's own frame) that falls on position (`x`, `y`) px.
    ///
    /// Exact to machine precision. `None` where no point falls: outside the range of the distortion polynomial.
    #[must_use]
    pub fn unproject(&self, x: f64, y: f64) -> Option<Vector3<f64>> {
        let distorted = Vector2::new((x - self.cx) / self.fx, (y - self.cy) / self.fy);
        let mut ideal = distorted;
        for _ in 0..INVERSE_STEPS {
            let (position, slope) = self.distort(&ideal);
            let step = slope.try_inverse()? * (position - distorted);
            ideal -= step;
            if step.norm() <= 1e-15 * (1.0 + ideal.norm()) {
                break;
            }
        }
        let (position, slope) = self.distort(&ideal);
        let found = (position - distorted).norm() <= INVERSE_TOLERANCE * (1.0 + distorted.norm())
            && slope.determinant() > 0.0
            && slope.trace() > 0.0;
        found.then(|| Vector3::new(ideal.x, ideal.y, 1.0))
    }

    /// Where position (`x`, `y`) px would be if the lens had no distortion, px; `None` as for [`Lens::unproject`].
    #[must_use]
    pub fn without_distortion(&self, x: f64, y: f64) -> Option<Vector2<f64>> {
        self.unproject(x, y).map(|ray| self.to_raster(&ray.xy()))
    }

    /// Whether a position (px) lies on the raster.
    #[must_use]
    pub fn contains(&self, x: f64, y: f64) -> bool {
        (0.0..f64::from(self.width)).contains(&x) && (0.0..f64::from(self.height)).contains(&y)
    }

    /// What is wrong with the parameters, in words for an error message, or `None`.
    pub(crate) fn fault(&self) -> Option<String> {
        let numbers = [self.fx, self.fy, self.cx, self.cy];
        if self.width == 0 || self.height == 0 {
            return Some(format!("its raster is {} x {} px", self.width, self.height));
        }
        if !numbers
            .iter()
            .chain(&self.distortion)
            .all(|v| v.is_finite())
        {
            return Some("a lens parameter is not a finite number".to_owned());
        }
        (self.fx <= 0.0 || self.fy <= 0.0).then(|| {
            format!(
                "its focal lengths {} and {} px must be above 0",
                self.fx, self.fy
            )
        })
    }

    fn to_raster(self, normalised: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(
            self.fx * normalised.x + self.cx,
            self.fy * normalised.y + self.cy,
        )
    }

    /// The distorted position and its derivative, both in units of the focal length.
    fn distort(&self, ideal: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let (x, y) = (ideal.x, ideal.y);
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let radial_slope = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
        let position = Vector2::new(
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        );
        let mixed = 2.0 * x * y * radial_slope + 2.0 * p1 * x + 2.0 * p2 * y;
        let slope = Matrix2::new(
            radial + 2.0 * x * x * radial_slope + 2.0 * p1 * y + 6.0 * p2 * x,
            mixed,
            mixed,
            radial + 2.0 * y * y * radial_slope + 6.0 * p1 * y + 2.0 * p2 * x,
        );
        (position, slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn webcam() -> Lens {
        Lens {
            width: 640,
            height: 480,
            fx: 690.0,
            fy: 685.0,
            cx: 324.3,
            cy: 236.9,
            distortion: [-0.21, 0.07, 0.001, -0.0015, 0.01],
        }
    }

    #[test]
    fn every_pixel_survives_the_round_trip_through_the_distortion() {
        let lens = webcam();
        for y in 0..=48 {
            for x in 0..=64 {
                let (x, y) = (f64::from(x) * 10.0, f64::from(y) * 10.0);
                let ray = lens.unproject(x, y).unwrap();
                let back = lens.project(&(ray * 731.0)).unwrap();
                assert!(
                    (back - Vector2::new(x, y)).norm() < 1e-9,
                    "({x}, {y}) came back as {back}"
                );
            }
        }
    }

    #[test]
    fn a_point_on_the_axis_falls_on_the_principal_point() {
        let on_axis = webcam().project(&Vector3::new(0.0, 0.0, 900.0)).unwrap();
        assert_eq!(on_axis, Vector2::new(324.3, 236.9));
    }

    #[test]
    fn barrel_distortion_pulls_the_corner_towards_the_middle() {
        let straight = Lens {
            distortion: [0.0; 5],
            ..webcam()
        };
        let corner = Vector3::new(-400.0, -300.0, 1000.0);
        let bent = webcam().project(&corner).unwrap();
        let ideal = straight.project(&corner).unwrap();
        assert!(bent.x > ideal.x + 5.0 && bent.y > ideal.y + 5.0);
        let mended = webcam().without_distortion(bent.x, bent.y).unwrap();
        assert!((mended - ideal).norm() < 1e-9);
    }

    #[test]
    fn points_behind_the_lens_and_beyond_the_fold_fall_nowhere() {
        let lens = Lens {
            distortion: [-0.3, 0.0, 0.0, 0.0, 0.0],
            ..webcam()
        };
        assert_eq!(lens.project(&Vector3::new(10.0, 0.0, -500.0)), None);
        assert_eq!(lens.project(&Vector3::new(10.0, 0.0, 0.0)), None);
        assert_eq!(
            lens.project(&Vector3::new(1500.0, 0.0, 1000.0)),
            None,
            "r = 1.5 is beyond 1.05"
        );
        assert_eq!(lens.unproject(5000.0, 240.0), None);
        assert_eq!(lens.unproject(f64::NAN, 240.0), None);
    }
}
