//! Exact visibility past opaque meshes.

use crate::scene::Mesh;
use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use glam::DVec3;
use nalgebra::{Point3, Vector3};

/// Where a ray meets a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// In lengths of the ray's direction.
    pub distance: f64,
    /// Unit length, either side.
    pub normal: DVec3,
    /// Of the mesh.
    pub albedo: [f32; 3],
}

struct Triangle {
    corners: [DVec3; 3],
    albedo: [f32; 3],
    node: usize,
}

impl Bounded<f64, 3> for Triangle {
    fn aabb(&self) -> Aabb<f64, 3> {
        let [a, b, c] = self.corners;
        Aabb::with_bounds(point(a.min(b).min(c)), point(a.max(b).max(c)))
    }
}

impl BHShape<f64, 3> for Triangle {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }
    fn bh_node_index(&self) -> usize {
        self.node
    }
}

fn point(v: DVec3) -> Point3<f64> {
    Point3::new(v.x, v.y, v.z)
}

/// All meshes of a scene in a bounding volume hierarchy.
pub struct Meshes {
    triangles: Vec<Triangle>,
    tree: Bvh<f64, 3>,
    /// Nearest distance that counts as a hit, world units: a surface does not shadow itself.
    pub epsilon: f64,
}

impl Meshes {
    /// Builds the hierarchy.
    pub fn new(meshes: &[Mesh]) -> Self {
        let corner =
            |m: &Mesh, i: u32| m.positions.get(i as usize).map_or(DVec3::ZERO, |p| DVec3::from(p.map(f64::from)));
        let mut triangles: Vec<_> = meshes
            .iter()
            .flat_map(|m| {
                m.triangles.iter().map(move |t| Triangle {
                    corners: t.map(|i| corner(m, i)),
                    albedo: m.albedo,
                    node: 0,
                })
            })
            .collect();
        let extent = triangles.iter().flat_map(|t| t.corners).fold(0.0, |e: f64, c| e.max(c.abs().max_element()));
        let tree = Bvh::build(&mut triangles);
        Self { triangles, tree, epsilon: extent * 1e-7 }
    }

    /// The nearest hit beyond [`Meshes::epsilon`].
    pub fn hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        self.visit(origin, direction, |triangle, distance| {
            if nearest.is_none_or(|n| distance < n.distance) {
                let [a, b, c] = triangle.corners;
                let normal = (b - a).cross(c - a).normalize_or_zero();
                nearest = Some(Hit { distance, normal, albedo: triangle.albedo });
            }
            false
        });
        nearest
    }

    /// Whether nothing stands within `distance` (in lengths of `direction`).
    pub fn free(&self, origin: DVec3, direction: DVec3, distance: f64) -> bool {
        let mut free = true;
        self.visit(origin, direction, |_, hit| {
            free &= hit >= distance;
            !free
        });
        free
    }

    /// Calls `on_hit` for each triangle that the ray meets, in no order, until it returns true.
    fn visit(&self, origin: DVec3, direction: DVec3, mut on_hit: impl FnMut(&Triangle, f64) -> bool) {
        if self.triangles.is_empty() {
            return;
        }
        let ray = bvh::ray::Ray::new(point(origin), Vector3::new(direction.x, direction.y, direction.z));
        let least = self.epsilon / direction.length();
        for triangle in self.tree.traverse_iterator(&ray, &self.triangles) {
            if let Some(distance) = intersect(origin, direction, triangle.corners)
                && distance > least
                && on_hit(triangle, distance)
            {
                return;
            }
        }
    }
}

/// Möller and Trumbore, both sides.
fn intersect(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (e1, e2) = (b - a, c - a);
    let p = direction.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = origin - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(e1);
    let v = direction.dot(q) / determinant;
    let distance = e2.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some(distance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_hides_what_is_behind_it() {
        let square = Mesh {
            name: "square".into(),
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            albedo: [0.5; 3],
            solid: false,
        };
        let meshes = Meshes::new(&[square]);
        assert!(!meshes.free(DVec3::new(0.3, 0.2, -2.0), DVec3::Z, 10.0));
        assert!(meshes.free(DVec3::new(0.3, 0.2, -2.0), DVec3::Z, 1.5), "the square is farther than the light");
        assert!(meshes.free(DVec3::new(0.3, 0.2, 0.0), DVec3::Z, 10.0), "a surface does not shadow itself");
        assert!(meshes.free(DVec3::new(1.3, 0.2, -2.0), DVec3::Z, 10.0));
        let hit = meshes.hit(DVec3::new(0.3, 0.2, -2.0), DVec3::Z * 2.0).expect("it is in front");
        assert!((hit.distance - 1.0).abs() < 1e-12 && hit.normal.abs() == DVec3::Z);
    }
}
