//! Shapes in their own frame, and where a ray meets them.

use nalgebra::Vector3;

use super::Mesh;
use crate::geometry::Ray;

/// A ray does not meet the place where it starts: nearer than this is nothing, mm.
pub(super) const NEAREST_MM: f64 = 1e-6;

/// A shape around its own origin, mm.
#[derive(Debug, Clone)]
pub(in crate::simulation) enum Shape {
    /// A rectangle in z = 0, seen from both sides; half its width and height.
    Plane { half: [f64; 2] },
    /// Half its width, height and depth.
    Box { half: Vector3<f64> },
    /// Closed, axis along y.
    Cylinder { radius: f64, half_height: f64 },
    /// Half axes along x, y and z.
    Ellipsoid { radii: Vector3<f64> },
    /// Triangles.
    Mesh(Mesh),
}

/// Where a ray meets a shape, in the shape's frame.
#[derive(Debug, Clone, Copy)]
pub(in crate::simulation) struct LocalHit {
    /// Along the ray, mm.
    pub(in crate::simulation) distance_mm: f64,
    /// Unit length, on either side.
    pub(in crate::simulation) normal: Vector3<f64>,
    /// The normal for shading, unit length.
    pub(in crate::simulation) shading_normal: Vector3<f64>,
}

impl LocalHit {
    fn flat(distance_mm: f64, normal: Vector3<f64>) -> Self {
        Self {
            distance_mm,
            normal,
            shading_normal: normal,
        }
    }
}

impl Shape {
    /// The first place before `limit_mm` where the ray meets the shape.
    pub(super) fn meet(&self, ray: &Ray, limit_mm: f64) -> Option<LocalHit> {
        let hit = match self {
            Self::Plane { half } => meet_plane(ray, *half),
            Self::Box { half } => meet_box(ray, half),
            Self::Cylinder {
                radius,
                half_height,
            } => meet_cylinder(ray, *radius, *half_height),
            Self::Ellipsoid { radii } => meet_ellipsoid(ray, radii),
            Self::Mesh(mesh) => mesh.meet(ray, limit_mm),
        }?;
        (hit.distance_mm < limit_mm).then_some(hit)
    }

    /// Radius of a ball around the origin that holds the shape, mm.
    pub(super) fn reach_mm(&self) -> f64 {
        match self {
            Self::Plane { half } => half[0].hypot(half[1]),
            Self::Box { half } => half.norm(),
            Self::Cylinder {
                radius,
                half_height,
            } => radius.hypot(*half_height),
            Self::Ellipsoid { radii } => radii.max(),
            Self::Mesh(mesh) => mesh.reach_mm(),
        }
    }
}

fn meet_plane(ray: &Ray, half: [f64; 2]) -> Option<LocalHit> {
    let distance = -ray.origin.z / ray.direction.z;
    if !(distance.is_finite() && distance > NEAREST_MM) {
        return None;
    }
    let point = ray.at(distance);
    let inside = point.x.abs() <= half[0] && point.y.abs() <= half[1];
    inside.then(|| LocalHit::flat(distance, Vector3::z()))
}

fn meet_box(ray: &Ray, half: &Vector3<f64>) -> Option<LocalHit> {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut enter_axis, mut leave_axis) = (0, 0);
    for axis in 0..3 {
        let inverse = 1.0 / ray.direction[axis];
        let centre = -ray.origin[axis] * inverse;
        let spread = half[axis] * inverse.abs();
        if !centre.is_finite() {
            // the ray runs along this pair of faces: it is between them or never
            if ray.origin[axis].abs() > half[axis] {
                return None;
            }
            continue;
        }
        if centre - spread > enter {
            (enter, enter_axis) = (centre - spread, axis);
        }
        if centre + spread < leave {
            (leave, leave_axis) = (centre + spread, axis);
        }
    }
    let (distance, axis) = if enter > NEAREST_MM {
        (enter, enter_axis)
    } else {
        (leave, leave_axis)
    };
    let mut normal = Vector3::zeros();
    normal[axis] = 1.0;
    (enter <= leave && distance > NEAREST_MM).then(|| LocalHit::flat(distance, normal))
}

fn meet_cylinder(ray: &Ray, radius: f64, half_height: f64) -> Option<LocalHit> {
    let (o, d) = (&ray.origin, &ray.direction);
    let side = roots(
        d.x * d.x + d.z * d.z,
        o.x * d.x + o.z * d.z,
        o.x * o.x + o.z * o.z - radius * radius,
    );
    let wall = side
        .into_iter()
        .flatten()
        .find(|t| *t > NEAREST_MM && (o.y + t * d.y).abs() <= half_height);
    let cap = [-1.0, 1.0].into_iter().filter_map(|end| {
        let t = (end * half_height - o.y) / d.y;
        let p = ray.at(t);
        (t.is_finite() && t > NEAREST_MM && p.x.hypot(p.z) <= radius).then_some(t)
    });
    let cap = cap.min_by(f64::total_cmp);
    match (wall, cap) {
        (Some(wall), cap) if cap.is_none_or(|cap| wall <= cap) => {
            let p = ray.at(wall);
            Some(LocalHit::flat(wall, Vector3::new(p.x, 0.0, p.z) / radius))
        }
        (_, cap) => cap.map(|t| LocalHit::flat(t, Vector3::y())),
    }
}

fn meet_ellipsoid(ray: &Ray, radii: &Vector3<f64>) -> Option<LocalHit> {
    let o = ray.origin.component_div(radii);
    let d = ray.direction.component_div(radii);
    let t = roots(d.norm_squared(), o.dot(&d), o.norm_squared() - 1.0)
        .into_iter()
        .flatten()
        .find(|t| *t > NEAREST_MM)?;
    let normal = (o + d * t).component_div(radii).try_normalize(0.0)?;
    Some(LocalHit::flat(t, normal))
}

/// The roots of a t² + 2 b t + c, the smaller first.
fn roots(a: f64, b: f64, c: f64) -> [Option<f64>; 2] {
    let under = b * b - a * c;
    if a <= 0.0 || under < 0.0 {
        return [None, None];
    }
    let root = under.sqrt();
    [Some((-b - root) / a), Some((-b + root) / a)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from_front(x: f64, y: f64) -> Ray {
        Ray {
            origin: Vector3::new(x, y, -100.0),
            direction: Vector3::z(),
        }
    }

    /// Distance in nanometres, so that rounding does not count.
    fn distance(shape: &Shape, ray: &Ray) -> Option<i64> {
        shape
            .meet(ray, f64::INFINITY)
            .map(|hit| (hit.distance_mm * 1e6).round() as i64)
    }

    #[test]
    fn each_shape_is_met_at_its_front() {
        let plane = Shape::Plane { half: [10.0, 5.0] };
        assert_eq!(distance(&plane, &from_front(9.0, 4.0)), Some(100_000_000));
        assert_eq!(distance(&plane, &from_front(9.0, 6.0)), None);
        let cuboid = Shape::Box {
            half: Vector3::new(10.0, 5.0, 20.0),
        };
        assert_eq!(distance(&cuboid, &from_front(9.0, 4.0)), Some(80_000_000));
        assert_eq!(distance(&cuboid, &from_front(11.0, 4.0)), None);
        let cylinder = Shape::Cylinder {
            radius: 10.0,
            half_height: 5.0,
        };
        assert_eq!(distance(&cylinder, &from_front(6.0, 4.0)), Some(92_000_000));
        assert_eq!(distance(&cylinder, &from_front(6.0, 6.0)), None);
        let ellipsoid = Shape::Ellipsoid {
            radii: Vector3::new(10.0, 5.0, 20.0),
        };
        assert_eq!(
            distance(&ellipsoid, &from_front(0.0, 0.0)),
            Some(80_000_000)
        );
        assert_eq!(
            distance(&ellipsoid, &from_front(6.0, 0.0)),
            Some(84_000_000)
        );
    }

    #[test]
    fn a_cylinder_is_closed_by_its_caps() {
        let cylinder = Shape::Cylinder {
            radius: 10.0,
            half_height: 5.0,
        };
        let from_above = Ray {
            origin: Vector3::new(3.0, -50.0, 3.0),
            direction: Vector3::y(),
        };
        let hit = cylinder.meet(&from_above, f64::INFINITY).unwrap();
        assert!((hit.distance_mm - 45.0).abs() < 1e-9);
        assert_eq!(hit.normal, Vector3::y());
    }

    #[test]
    fn from_inside_the_far_side_is_met_and_beyond_the_limit_nothing() {
        let inside = Ray {
            origin: Vector3::zeros(),
            direction: Vector3::z(),
        };
        let cuboid = Shape::Box {
            half: Vector3::new(10.0, 5.0, 20.0),
        };
        assert_eq!(distance(&cuboid, &inside), Some(20_000_000));
        assert!(cuboid.meet(&inside, 19.0).is_none());
        let ellipsoid = Shape::Ellipsoid {
            radii: Vector3::new(10.0, 5.0, 20.0),
        };
        assert_eq!(distance(&ellipsoid, &inside), Some(20_000_000));
    }
}
