//! Rays and planes of light in space, and where they meet (mm).

use nalgebra::Vector3;

/// Sine of the smallest angle between two directions that are told apart; below it a meeting is meaningless.
const PARALLEL: f64 = 1e-9;

/// A half line: from `origin` (mm) along `direction` (unit length).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it begins, mm.
    pub origin: Vector3<f64>,
    /// Where it goes, unit length.
    pub direction: Vector3<f64>,
}

/// A plane: the points p with `normal . p = offset_mm`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Perpendicular to the plane, unit length.
    pub normal: Vector3<f64>,
    /// Distance from the origin along the normal, mm.
    pub offset_mm: f64,
}

/// Where two rays pass closest to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    /// The middle of the shortest segment between them, mm.
    pub point: Vector3<f64>,
    /// The length of that segment, mm: how badly they miss.
    pub gap_mm: f64,
    /// Sine of the angle between the rays, 0 to 1; the depth error grows as 1 / sine.
    pub sine: f64,
}

impl Ray {
    /// The ray from `origin` through `target` (mm); `None` when they are the same point.
    #[must_use]
    pub fn through(origin: Vector3<f64>, target: Vector3<f64>) -> Option<Self> {
        let direction = (target - origin).try_normalize(f64::MIN_POSITIVE)?;
        Some(Self { origin, direction })
    }

    /// The point `distance_mm` along the ray.
    #[must_use]
    pub fn at(&self, distance_mm: f64) -> Vector3<f64> {
        self.origin + self.direction * distance_mm
    }

    /// The point where the ray meets a plane; `None` when it runs along it or away from it.
    #[must_use]
    pub fn meet_plane(&self, plane: &Plane) -> Option<Vector3<f64>> {
        let slope = plane.normal.dot(&self.direction);
        if slope.abs() < PARALLEL {
            return None;
        }
        let distance = (plane.offset_mm - plane.normal.dot(&self.origin)) / slope;
        (distance > 0.0).then(|| self.at(distance))
    }

    /// Where two rays come closest; `None` when they are parallel or do so behind one of the origins.
    #[must_use]
    pub fn meet(&self, other: &Self) -> Option<Meeting> {
        let sine = self.direction.cross(&other.direction).norm();
        if sine < PARALLEL {
            return None;
        }
        let cosine = self.direction.dot(&other.direction);
        let between = other.origin - self.origin;
        let (along_self, along_other) =
            (between.dot(&self.direction), between.dot(&other.direction));
        let distance = (along_self - cosine * along_other) / (sine * sine);
        let distance_other = (cosine * along_self - along_other) / (sine * sine);
        if distance <= 0.0 || distance_other <= 0.0 {
            return None;
        }
        let (here, there) = (self.at(distance), other.at(distance_other));
        Some(Meeting {
            point: (here + there) / 2.0,
            gap_mm: (there - here).norm(),
            sine,
        })
    }
}

impl Plane {
    /// The plane through `point` (mm) that contains two directions; `None` when these are parallel.
    #[must_use]
    pub fn spanned(point: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>) -> Option<Self> {
        let scale = a.norm() * b.norm();
        let normal = a.cross(b).try_normalize(PARALLEL * scale)?;
        Some(Self {
            normal,
            offset_mm: normal.dot(point),
        })
    }

    /// Distance of a point from the plane, mm, negative behind it.
    #[must_use]
    pub fn distance_mm(&self, point: &Vector3<f64>) -> f64 {
        self.normal.dot(point) - self.offset_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_meets_a_plane_in_front_and_not_behind() {
        let plane =
            Plane::spanned(&Vector3::new(0.0, 0.0, 800.0), &Vector3::x(), &Vector3::y()).unwrap();
        let ray = Ray::through(Vector3::zeros(), Vector3::new(1.0, 0.0, 2.0)).unwrap();
        let hit = ray.meet_plane(&plane).unwrap();
        assert!((hit - Vector3::new(400.0, 0.0, 800.0)).norm() < 1e-9);
        assert!(plane.distance_mm(&hit).abs() < 1e-9);
        let away = Ray {
            direction: -ray.direction,
            ..ray
        };
        assert_eq!(away.meet_plane(&plane), None);
        let along = Ray {
            origin: Vector3::zeros(),
            direction: Vector3::x(),
        };
        assert_eq!(along.meet_plane(&plane), None);
    }

    #[test]
    fn skew_rays_meet_in_the_middle_of_their_gap() {
        let a = Ray {
            origin: Vector3::zeros(),
            direction: Vector3::z(),
        };
        let b = Ray {
            origin: Vector3::new(-100.0, 2.0, 500.0),
            direction: Vector3::x(),
        };
        let meeting = a.meet(&b).unwrap();
        assert!((meeting.point - Vector3::new(0.0, 1.0, 500.0)).norm() < 1e-9);
        assert!((meeting.gap_mm - 2.0).abs() < 1e-12);
        assert!((meeting.sine - 1.0).abs() < 1e-12);
    }

    #[test]
    fn parallel_and_parting_rays_do_not_meet() {
        let a = Ray {
            origin: Vector3::zeros(),
            direction: Vector3::z(),
        };
        let beside = Ray {
            origin: Vector3::x() * 100.0,
            direction: Vector3::z(),
        };
        assert_eq!(a.meet(&beside), None);
        let parting = Ray::through(Vector3::x() * 100.0, Vector3::new(200.0, 0.0, 100.0)).unwrap();
        assert_eq!(a.meet(&parting), None);
    }
}
