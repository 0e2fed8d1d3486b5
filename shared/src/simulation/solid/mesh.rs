//! Triangles, sorted into a tree of bounding boxes so that a ray looks at few of them.
//!
//! Method: split at the median along the longest side until four are left (a bounding volume hierarchy); each
//! triangle is met by the test of T. Möller and B. Trumbore, 1997.

use nalgebra::Vector3;

use super::shape::{LocalHit, NEAREST_MM};
use crate::geometry::Ray;

/// Triangles in a leaf of the tree.
const LEAF: usize = 4;

/// Most triangles of one mesh; a scan of a thing at 1 mm has fewer.
const MAX_FACES: usize = 2_000_000;

/// Nodes that can wait for a look: one per level, and halving [`MAX_FACES`] gives fewer than 22 levels.
const DEPTH: usize = 32;

/// A triangle mesh in its own frame, mm.
#[derive(Debug, Clone)]
pub(in crate::simulation) struct Mesh {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
    reach_mm: f64,
}

/// The corners and faces of a mesh, as files give them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::simulation) struct MeshData {
    pub(in crate::simulation) vertices: Vec<Vector3<f64>>,
    pub(in crate::simulation) faces: Vec<[usize; 3]>,
}

#[derive(Debug, Clone, Copy)]
struct Triangle {
    corner: Vector3<f64>,
    edges: [Vector3<f64>; 2],
    normal: Vector3<f64>,
    corner_normals: [Vector3<f64>; 3],
}

#[derive(Debug, Clone, Copy)]
struct Node {
    low: Vector3<f64>,
    high: Vector3<f64>,
    content: Content,
}

#[derive(Debug, Clone, Copy)]
enum Content {
    /// The first child is the next node, this is the second.
    Children(usize),
    /// Triangles from, to (exclusive).
    Triangles(usize, usize),
}

impl Mesh {
    /// A mesh of checked triangles, each corner multiplied by `scale`; `smooth` bends the shading normals
    /// over the edges.
    ///
    /// The error says in words what is wrong with the data.
    pub(in crate::simulation) fn new(
        mut data: MeshData,
        scale: f64,
        smooth: bool,
    ) -> Result<Self, String> {
        check(&data)?;
        data.vertices.iter_mut().for_each(|v| *v *= scale);
        let vertex_normals = if smooth {
            smooth_normals(&data)
        } else {
            Vec::new()
        };
        let mut triangles: Vec<Triangle> = data
            .faces
            .iter()
            .filter_map(|face| triangle(&data, *face, &vertex_normals))
            .collect();
        if triangles.is_empty() {
            return Err("every triangle has no area".to_owned());
        }
        let reach_mm = data.vertices.iter().map(Vector3::norm).fold(0.0, f64::max);
        let mut nodes = Vec::with_capacity(2 * triangles.len() / LEAF + 1);
        let count = triangles.len();
        build(&mut triangles, 0, count, &mut nodes);
        Ok(Self {
            triangles,
            nodes,
            reach_mm,
        })
    }

    /// Radius of a ball around the origin that holds all corners, mm.
    pub(super) fn reach_mm(&self) -> f64 {
        self.reach_mm
    }

    /// The first triangle before `limit_mm` that the ray meets.
    pub(super) fn meet(&self, ray: &Ray, limit_mm: f64) -> Option<LocalHit> {
        let inverse = ray.direction.map(|d| 1.0 / d);
        let mut nearest = limit_mm;
        let mut found = None;
        let mut pending = [0; DEPTH];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let index = pending[waiting];
            let node = &self.nodes[index];
            if !node.is_crossed(ray, &inverse, nearest) {
                continue;
            }
            match node.content {
                Content::Children(second) => {
                    pending[waiting..waiting + 2].copy_from_slice(&[second, index + 1]);
                    waiting += 2;
                }
                Content::Triangles(from, to) => {
                    for triangle in &self.triangles[from..to] {
                        if let Some(hit) = triangle.meet(ray, nearest) {
                            nearest = hit.distance_mm;
                            found = Some(hit);
                        }
                    }
                }
            }
        }
        found
    }
}

impl Triangle {
    fn meet(&self, ray: &Ray, limit_mm: f64) -> Option<LocalHit> {
        let [a, b] = &self.edges;
        let p = ray.direction.cross(b);
        let determinant = a.dot(&p);
        if determinant == 0.0 {
            return None;
        }
        let s = ray.origin - self.corner;
        let u = s.dot(&p) / determinant;
        let q = s.cross(a);
        let v = ray.direction.dot(&q) / determinant;
        let distance_mm = b.dot(&q) / determinant;
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        if !(inside && distance_mm > NEAREST_MM && distance_mm < limit_mm) {
            return None;
        }
        let [first, second, third] = &self.corner_normals;
        let mixed = first * (1.0 - u - v) + second * u + third * v;
        let shading_normal = mixed.try_normalize(1e-9).unwrap_or(self.normal);
        Some(LocalHit {
            distance_mm,
            normal: self.normal,
            shading_normal,
        })
    }

    fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        let others = self.edges.map(|edge| self.corner + edge);
        (
            self.corner.inf(&others[0]).inf(&others[1]),
            self.corner.sup(&others[0]).sup(&others[1]),
        )
    }

    fn middle(&self) -> Vector3<f64> {
        self.corner + (self.edges[0] + self.edges[1]) / 3.0
    }
}

impl Node {
    fn is_crossed(&self, ray: &Ray, inverse: &Vector3<f64>, limit_mm: f64) -> bool {
        let (mut enter, mut leave) = (0.0_f64, limit_mm);
        for axis in 0..3 {
            let a = (self.low[axis] - ray.origin[axis]) * inverse[axis];
            let b = (self.high[axis] - ray.origin[axis]) * inverse[axis];
            // a ray within a face gives 0 x infinity; min and max pass over such a NaN, which errs to "crossed"
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        enter <= leave * (1.0 + 1e-12)
    }
}

fn check(data: &MeshData) -> Result<(), String> {
    if data.faces.is_empty() {
        return Err("it has no triangles".to_owned());
    }
    if data.faces.len() > MAX_FACES {
        return Err(format!(
            "it has {} triangles, more than {MAX_FACES}",
            data.faces.len()
        ));
    }
    if let Some(k) = data
        .vertices
        .iter()
        .position(|v| !v.iter().all(|x| x.abs() <= 1e6))
    {
        return Err(format!(
            "vertex {k} lies beyond 1000000 mm or is not a number"
        ));
    }
    let count = data.vertices.len();
    let beyond = data
        .faces
        .iter()
        .position(|face| face.iter().any(|v| *v >= count));
    beyond.map_or(Ok(()), |k| {
        Err(format!(
            "triangle {k} has a corner that is none of the {count} vertices"
        ))
    })
}

fn triangle(
    data: &MeshData,
    face: [usize; 3],
    vertex_normals: &[Vector3<f64>],
) -> Option<Triangle> {
    let [corner, b, c] = face.map(|k| data.vertices[k]);
    let edges = [b - corner, c - corner];
    let normal = edges[0].cross(&edges[1]).try_normalize(1e-12)?;
    let corner_normals = face.map(|k| vertex_normals.get(k).copied().unwrap_or(normal));
    Some(Triangle {
        corner,
        edges,
        normal,
        corner_normals,
    })
}

/// The mean normal of the triangles around each vertex, weighted by their area.
fn smooth_normals(data: &MeshData) -> Vec<Vector3<f64>> {
    let mut sums = vec![Vector3::zeros(); data.vertices.len()];
    for face in &data.faces {
        let [a, b, c] = face.map(|k| data.vertices[k]);
        let weighted = (b - a).cross(&(c - a));
        face.iter().for_each(|k| sums[*k] += weighted);
    }
    sums.into_iter()
        .map(|n| n.try_normalize(1e-12).unwrap_or_else(Vector3::z))
        .collect()
}

/// Sorts triangles `from..to` into a subtree and adds its nodes.
fn build(triangles: &mut [Triangle], from: usize, to: usize, nodes: &mut Vec<Node>) {
    let bounds = triangles[from..to].iter().map(Triangle::bounds);
    let (low, high) = bounds
        .reduce(|(low, high), (l, h)| (low.inf(&l), high.sup(&h)))
        .unwrap_or_default();
    let index = nodes.len();
    nodes.push(Node {
        low,
        high,
        content: Content::Triangles(from, to),
    });
    if to - from <= LEAF {
        return;
    }
    let axis = (high - low).imax();
    let middle = (to - from) / 2;
    triangles[from..to]
        .select_nth_unstable_by(middle, |a, b| a.middle()[axis].total_cmp(&b.middle()[axis]));
    build(triangles, from, from + middle, nodes);
    nodes[index].content = Content::Children(nodes.len());
    build(triangles, from + middle, to, nodes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::random::Random;

    /// A bumpy sheet of 2 x 20 x 20 triangles.
    fn sheet() -> MeshData {
        let random = Random::new(5);
        let vertices = (0..21 * 21_u32).map(|k| {
            let height = random.uniform(u64::from(k)) * 8.0;
            Vector3::new(
                f64::from(k % 21) * 5.0 - 50.0,
                f64::from(k / 21) * 5.0 - 50.0,
                height,
            )
        });
        let faces = (0..20).flat_map(|y| (0..20).map(move |x| y * 21 + x));
        MeshData {
            vertices: vertices.collect(),
            faces: faces
                .flat_map(|k| [[k, k + 1, k + 21], [k + 1, k + 22, k + 21]])
                .collect(),
        }
    }

    #[test]
    fn the_tree_finds_the_same_triangle_as_looking_at_all_of_them() {
        let mesh = Mesh::new(sheet(), 1.0, false).unwrap();
        let random = Random::new(9);
        let mut met = 0;
        for k in 0..500_u64 {
            let place = |c: u64| random.uniform(8 * k + c) * 140.0 - 70.0;
            let origin = Vector3::new(place(0), place(1), -200.0);
            let ray = Ray::through(origin, Vector3::new(place(2), place(3), 4.0)).unwrap();
            let all = mesh
                .triangles
                .iter()
                .filter_map(|t| t.meet(&ray, f64::INFINITY));
            let expected = all.map(|hit| hit.distance_mm).min_by(f64::total_cmp);
            let found = mesh.meet(&ray, f64::INFINITY).map(|hit| hit.distance_mm);
            assert_eq!(found, expected);
            met += usize::from(found.is_some());
        }
        assert!((100..500).contains(&met), "{met} rays met the sheet");
    }

    #[test]
    fn scale_and_smoothing_do_what_they_say() {
        let big = Mesh::new(sheet(), 2.0, true).unwrap();
        assert!(
            (big.reach_mm() - 2.0 * Mesh::new(sheet(), 1.0, false).unwrap().reach_mm()).abs()
                < 1e-9
        );
        let ray = Ray {
            origin: Vector3::new(11.0, 7.0, -50.0),
            direction: Vector3::z(),
        };
        let hit = big.meet(&ray, f64::INFINITY).unwrap();
        assert!((hit.shading_normal.norm() - 1.0).abs() < 1e-9);
        assert!((hit.shading_normal - hit.normal).norm() > 1e-3);
    }

    #[test]
    fn data_that_is_no_mesh_is_refused() {
        let refused = |data: MeshData| Mesh::new(data, 1.0, false).unwrap_err();
        assert!(refused(MeshData::default()).contains("no triangles"));
        let corners = vec![Vector3::zeros(), Vector3::x(), Vector3::y()];
        let beyond = MeshData {
            vertices: corners.clone(),
            faces: vec![[0, 1, 3]],
        };
        assert!(refused(beyond).contains("none of the 3 vertices"));
        let flat = MeshData {
            vertices: corners,
            faces: vec![[0, 1, 1]],
        };
        assert!(refused(flat).contains("no area"));
        let nan = MeshData {
            vertices: vec![Vector3::repeat(f64::NAN); 3],
            faces: vec![[0, 1, 2]],
        };
        assert!(refused(nan).contains("not a number"));
    }
}
