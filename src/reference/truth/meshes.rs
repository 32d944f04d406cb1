//! Exact visibility past opaque meshes.

use super::alpha::{Coverage, TriangleAlpha, weights};
use crate::scene::{Mesh, Ray, sides};
use bvh::aabb::{Aabb, Bounded, IntersectsAabb};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use glam::DVec3;
use nalgebra::Point3;
use std::cell::Cell;

/// The point where a ray hits a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, in multiples of its direction.
    pub distance: f64,
    /// Unit normal: outwards on a closed surface, otherwise on either side.
    pub normal: DVec3,
    /// Whether the triangle belongs to a closed surface.
    pub closed: bool,
    /// The mesh's albedo.
    pub albedo: [f32; 3],
    /// Index of the triangle hit, counted over all meshes in order.
    pub triangle: usize,
}

/// A triangle of a mesh.
pub(super) struct Triangle {
    pub corners: [DVec3; 3],
    albedo: [f32; 3],
    /// [`Side::sign`](crate::scene::Side::sign): 0 if the surface encloses nothing.
    pub side: i32,
    number: usize,
    node: usize,
    alpha: Option<Box<TriangleAlpha>>,
}

impl Triangle {
    /// Returns a square in the triangle's plane about the point nearest to `middle`, that extends `reach` beyond the triangle's first corner.
    pub fn plane(&self, middle: DVec3, reach: f64) -> Vec<DVec3> {
        let [a, b, _] = self.corners;
        let normal = self.normal();
        let right = (b - a).normalize_or_zero();
        let up = normal.cross(right);
        let nearest = middle - normal * (middle - a).dot(normal);
        let reach = reach + (middle - a).length();
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| nearest + reach * (x * right + y * up)).into()
    }

    /// Returns how much of a convex part of the triangle's plane blocks light, given by the part's corners.
    pub fn coverage(&self, part: &[DVec3]) -> Coverage {
        let Some(alpha) = &self.alpha else { return Coverage::All };
        let part: Option<Vec<_>> = part.iter().map(|corner| weights(self.corners, *corner)).collect();
        part.map_or(Coverage::None, |part| alpha.coverage(&part))
    }

    /// Returns whether the triangle has alpha.
    pub fn has_alpha(&self) -> bool {
        self.alpha.is_some()
    }

    /// Returns whether the triangle blocks light at a point of it.
    pub fn blocks_at(&self, point: DVec3) -> bool {
        self.alpha.as_ref().is_none_or(|alpha| weights(self.corners, point).is_some_and(|at| alpha.blocks(at)))
    }

    /// Returns where a ray hits the triangle, in multiples of its direction. A hole is not hit.
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let (distance, [u, v]) = intersect(origin, direction, self.corners)?;
        self.alpha.as_ref().is_none_or(|alpha| alpha.blocks([1.0 - u - v, u, v])).then_some(distance)
    }

    /// Returns the triangle's normal, as in [`Hit::normal`].
    pub fn normal(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        if self.side < 0 { -normal } else { normal }
    }
}

impl Bounded<f64, 3> for Triangle {
    fn aabb(&self) -> Aabb<f64, 3> {
        let [a, b, c] = self.corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        // The margin guards against rounding. It also keeps axis-aligned rays out of the faces of boxes, where the hierarchy would miss
        // them.
        let margin = DVec3::splat(1e-12 * low.abs().max(high.abs()).max_element());
        Aabb::with_bounds(point(low - margin), point(high + margin))
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
    pub(super) triangles: Vec<Triangle>,
    tree: Bvh<f64, 3>,
    /// Whether any triangle belongs to a closed surface.
    closed: bool,
    /// Whether any triangle is see-through.
    glass: bool,
    /// The place of each triangle among `triangles`, by its number, if any is see-through; otherwise empty.
    places: Vec<u32>,
    /// Largest absolute coordinate, in world units.
    pub(super) extent: f64,
    /// Diagonal of the box around all meshes, in world units.
    pub(super) diagonal: f64,
    /// Smallest distance that counts as a hit, in world units, so that a surface does not shadow itself.
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
                m.triangles.iter().zip(sides(m)).map(move |(t, side)| Triangle {
                    corners: t.map(|i| corner(m, i)),
                    albedo: m.albedo,
                    side: side.sign(),
                    number: 0,
                    node: 0,
                    alpha: m.alpha.as_ref().map(|alpha| Box::new(TriangleAlpha::new(alpha, *t))),
                })
            })
            .collect();
        triangles.iter_mut().enumerate().for_each(|(number, triangle)| triangle.number = number);
        let closed = triangles.iter().any(|t| t.side != 0);
        let extent = triangles.iter().flat_map(|t| t.corners).fold(0.0, |e: f64, c| e.max(c.abs().max_element()));
        let corners = || triangles.iter().flat_map(|t| t.corners);
        let diagonal = (corners().fold(DVec3::MIN, DVec3::max) - corners().fold(DVec3::MAX, DVec3::min)).length();
        let tree = Bvh::build(&mut triangles);
        let glass = meshes.iter().any(Mesh::is_see_through);
        let mut places = vec![0; if glass { triangles.len() } else { 0 }];
        if glass {
            (0..).zip(&triangles).for_each(|(place, triangle)| places[triangle.number] = place);
        }
        Self { triangles, tree, closed, glass, places, extent, diagonal, epsilon: extent * 1e-7 }
    }

    /// Returns the nearest hit beyond [`Meshes::epsilon`].
    pub fn hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let way = BoundedRay::new(origin, direction, f64::INFINITY);
        let mut nearest: Option<Hit> = None;
        for (triangle, distance) in self.hits(&way) {
            if nearest.is_none_or(|n| distance < n.distance) {
                let (normal, closed) = (triangle.normal(), triangle.side != 0);
                nearest = Some(Hit { distance, normal, closed, albedo: triangle.albedo, triangle: triangle.number });
                way.end.set(distance);
            }
        }
        nearest
    }

    /// Returns the normal at a point of a triangle, interpolated from the normals of its corners, on the side of [`Hit::normal`]. If the
    /// corners' normals cancel out, it is [`Hit::normal`] itself. Twin: glsl/shading/smooth.comp.
    pub fn smooth_normal(&self, position: DVec3, hit: &Hit, corners: &[[f32; 3]; 3]) -> DVec3 {
        let to = self.triangles[hit.triangle].corners.map(|corner| corner - position);
        let across = (to[1] - to[0]).cross(to[2] - to[0]);
        let share = |i: usize| to[(i + 1) % 3].cross(to[(i + 2) % 3]).dot(across).max(0.0);
        let mixed: DVec3 = (0..3).map(|i| share(i) * DVec3::from(corners[i].map(f64::from))).sum();
        let side = mixed.dot(hit.normal);
        if side == 0.0 { hit.normal } else { (mixed * side.signum()).normalize() }
    }

    /// Returns whether the ray hits no mesh within `distance` (in multiples of `direction`).
    pub fn free(&self, origin: DVec3, direction: DVec3, distance: f64) -> bool {
        let way = BoundedRay::new(origin, direction, distance);
        self.hits(&way).all(|(_, hit)| hit >= distance)
    }

    /// Returns where a ray crosses see-through triangles within `distance` (in multiples of `direction`), and the optical depth there for
    /// light of `color` ([`crate::scene::Scene::color_of_light`]).
    pub fn see_through(&self, origin: DVec3, direction: DVec3, distance: f64, color: usize) -> Vec<(f64, f64)> {
        if !self.glass {
            return Vec::new();
        }
        let way = BoundedRay::new(origin, direction, distance);
        let least = self.epsilon / direction.length();
        let crossed = |triangle: &Triangle| {
            let (at, [u, v]) = intersect(origin, direction, triangle.corners)?;
            let alpha = triangle.alpha.as_ref()?;
            let ratio = f64::from(alpha.extinction_ratio[color]);
            let optical_depth = ratio * alpha.optical_depth([1.0 - u - v, u, v]);
            (optical_depth > 0.0 && at > least && at < distance).then_some((at, optical_depth))
        };
        self.meeting(&way).filter_map(crossed).collect()
    }

    /// Returns where a ray crosses see-through triangle `number`, and the optical depth there; `None` if it does not.
    pub(super) fn sheet(&self, number: u32, ray: &Ray) -> Option<(f64, f64)> {
        let triangle = &self.triangles[*self.places.get(number as usize)? as usize];
        let (at, [u, v]) = intersect(ray.origin, ray.direction, triangle.corners)?;
        let optical_depth = triangle.alpha.as_ref()?.optical_depth([1.0 - u - v, u, v]);
        (optical_depth > 0.0).then_some((at, optical_depth))
    }

    /// Returns the number of boxes and triangles that [`Meshes::free`] tests.
    pub(super) fn tries(&self, origin: DVec3, direction: DVec3, distance: f64) -> usize {
        let way = CountingRay { way: BoundedRay::new(origin, direction, distance), boxes: Cell::new(0) };
        let least = self.epsilon / direction.length();
        let free =
            |triangle: &&Triangle| !triangle.hit(origin, direction).is_some_and(|at| least < at && at < distance);
        let triangles = self.meeting(&way).take_while(free).count();
        triangles + way.boxes.get()
    }

    /// Returns whether a ray leaves more closed meshes than it enters before `distance` (in multiples of `direction`). If so, the ray
    /// starts inside a closed mesh and ends outside it.
    pub fn inside(&self, origin: DVec3, direction: DVec3, distance: f64) -> bool {
        if !self.closed {
            return false;
        }
        let way = BoundedRay::new(origin, direction, distance);
        let mut left = 0;
        for triangle in self.meeting(&way).filter(|t| t.side != 0) {
            if let Some((at, through_the_back)) = crossing(origin, direction, triangle.corners)
                && at > 0.0
                && at < distance
            {
                left += if through_the_back { triangle.side } else { -triangle.side };
            }
        }
        left > 0
    }

    /// Returns the triangles whose boxes in the hierarchy intersect `what`, in no particular order.
    pub(super) fn meeting<'a>(&'a self, what: &'a impl IntersectsAabb<f64, 3>) -> impl Iterator<Item = &'a Triangle> {
        let some = !self.triangles.is_empty();
        some.then(|| self.tree.traverse_iterator(what, &self.triangles)).into_iter().flatten()
    }

    /// Returns the triangles that a ray hits beyond [`Meshes::epsilon`], with the distances of the hits, in no particular order.
    fn hits<'a>(&'a self, way: &'a BoundedRay) -> impl Iterator<Item = (&'a Triangle, f64)> {
        let least = self.epsilon / way.direction.length();
        let hit = move |triangle: &'a Triangle| Some((triangle, triangle.hit(way.origin, way.direction)?));
        self.meeting(way).filter_map(hit).filter(move |(_, distance)| *distance > least)
    }
}

/// A ray of limited length.
struct BoundedRay {
    origin: DVec3,
    direction: DVec3,
    inverse: DVec3,
    /// The end, in multiples of the direction. A search that has found a hit moves the end to it.
    end: Cell<f64>,
}

impl BoundedRay {
    fn new(origin: DVec3, direction: DVec3, end: f64) -> Self {
        Self { origin, direction, inverse: direction.recip(), end: Cell::new(end) }
    }
}

impl IntersectsAabb<f64, 3> for BoundedRay {
    /// Conservative: never returns false if the ray hits the box, except for a ray exactly in a face of the box (slabs: Kay and Kajiya
    /// 1986; rounding: Ize 2013, Robust BVH ray traversal, section 3).
    fn intersects_aabb(&self, aabb: &Aabb<f64, 3>) -> bool {
        const ROUNDING: f64 = 1.0 + 8.0 * f64::EPSILON;
        let (mut near, mut far) = (0.0_f64, self.end.get());
        for axis in 0..3 {
            let [low, high] = [aabb.min[axis], aabb.max[axis]].map(|at| (at - self.origin[axis]) * self.inverse[axis]);
            near = near.max(low.min(high));
            far = far.min(low.max(high));
        }
        near <= far * ROUNDING
    }
}

/// A ray that counts the boxes against which it is tested.
struct CountingRay {
    way: BoundedRay,
    boxes: Cell<usize>,
}

impl IntersectsAabb<f64, 3> for CountingRay {
    fn intersects_aabb(&self, aabb: &Aabb<f64, 3>) -> bool {
        self.boxes.set(self.boxes.get() + 1);
        self.way.intersects_aabb(aabb)
    }
}

/// Returns where a ray hits a triangle from either side, in multiples of its direction, and the weights of the second and third corner there
/// (Möller and Trumbore).
fn intersect(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<(f64, [f64; 2])> {
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
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some((distance, [u, v]))
}

/// Returns where the ray's line crosses the triangle, and whether it does so from behind, with the normal pointing along the ray. A line
/// exactly through an edge or corner counts as if moved slightly, always in the same direction, so that closed meshes never count a
/// crossing twice or miss one.
///
/// Woop et al. 2013, Watertight ray/triangle intersection, section 3, with ties broken as in Edelsbrunner and Mücke 1990, Simulation of
/// simplicity.
fn crossing(origin: DVec3, direction: DVec3, corners: [DVec3; 3]) -> Option<(f64, bool)> {
    let z = direction.abs().max_position();
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    // Sheared so that the ray is the z axis and z is measured in multiples of the direction.
    let [a, b, c] = corners.map(|corner| {
        let (offset, far) = (corner - origin, (corner[z] - origin[z]) / direction[z]);
        DVec3::new(offset[x] - direction[x] * far, offset[y] - direction[y] * far, far)
    });
    let edges = [[b, c], [c, a], [a, b]];
    let areas = edges.map(|[from, to]| from.x * to.y - from.y * to.x);
    let left = |i: usize| {
        let [from, to] = edges[i];
        // On a tie, the line counts as moved slightly along x, and far less along y.
        [areas[i], from.y - to.y, to.x - from.x].into_iter().find(|value| *value != 0.0).map(|value| value > 0.0)
    };
    let turn = left(0)?;
    if left(1)? != turn || left(2)? != turn {
        return None;
    }
    let distance = (areas[0] * a.z + areas[1] * b.z + areas[2] * c.z) / (areas[0] + areas[1] + areas[2]);
    Some((distance, turn == (direction[z] > 0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::{both, cube, inside_out, mesh};

    #[test]
    fn a_square_hides_what_is_behind_it() {
        let square = Mesh {
            name: "square".into(),
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            albedo: [0.5; 3],
            solid: false,
            alpha: None,
        };
        let meshes = Meshes::new(&[square]);
        assert!(!meshes.free(DVec3::new(0.3, 0.2, -2.0), DVec3::Z, 10.0));
        assert!(meshes.free(DVec3::new(0.3, 0.2, -2.0), DVec3::Z, 1.5), "the square is farther than the light");
        assert!(meshes.free(DVec3::new(0.3, 0.2, 0.0), DVec3::Z, 10.0), "a surface does not shadow itself");
        assert!(meshes.free(DVec3::new(1.3, 0.2, -2.0), DVec3::Z, 10.0));
        let hit = meshes.hit(DVec3::new(0.3, 0.2, -2.0), DVec3::Z * 2.0).expect("it is in front");
        assert!((hit.distance - 1.0).abs() < 1e-12 && hit.normal.abs() == DVec3::Z);
    }

    /// Asserts that [`Meshes::inside`] gives the expected result for each point (x, y, z), with rays in many directions: along axes,
    /// through edges and corners of the unit cube, and at a slant.
    #[track_caller]
    fn check(meshes: &[Mesh], points: &[([f64; 3], bool)]) {
        let meshes = Meshes::new(meshes);
        let steps = || [-1.0, 0.0, 1.0].into_iter();
        let straight = steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| DVec3::new(x, y, z))));
        let slanted = (1..200).map(|i| DVec3::new((f64::from(i) * 0.7).sin(), (f64::from(i) * 1.3).cos(), 0.3));
        for direction in straight.chain(slanted).filter(|d| *d != DVec3::ZERO) {
            for (point, inside) in points {
                let found = meshes.inside(DVec3::from(*point), 0.5 * direction, f64::INFINITY);
                assert_eq!(found, *inside, "{point:?} along {direction}");
            }
        }
    }

    /// The hierarchy drops no triangle that a ray hits: hits are the same as when every triangle is tested. Some of the rays run along axes
    /// or in the planes of box faces, and their ends are near and far.
    #[test]
    fn boxes_hide_nothing() {
        use rand::Rng;
        let mut random = rand_pcg::Pcg32::new(5, 7);
        let mut whole = |count: u32| f64::from(random.next_u32() % count);
        // Integer coordinates make many boxes and rays share planes.
        let corners: Vec<[f32; 3]> = (0..600).map(|_| [0; 3].map(|_| whole(17) as f32 - 8.0)).collect();
        let cubes = (0..6).map(|i| cube([2.0 * i as f32 - 6.0, 0.0, 0.0], 1.0));
        let scattered = mesh(corners, (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
        let meshes = Meshes::new(&cubes.chain([scattered]).collect::<Vec<_>>());
        let (mut met, mut free) = (0, 0);
        for i in 0..20_000 {
            let mut place = || DVec3::from([0; 3].map(|_| 0.5 * whole(41) - 10.0));
            let (origin, mut direction) = (place(), place());
            if i % 3 == 0 {
                let axis = direction.abs().max_position();
                direction = DVec3::from([0, 1, 2].map(|i| if i == axis { direction[i] } else { 0.0 }));
            }
            if direction == DVec3::ZERO {
                continue;
            }
            let least = meshes.epsilon / direction.length();
            let hits = || meshes.triangles.iter().filter_map(|t| t.hit(origin, direction));
            let nearest = hits().filter(|at| *at > least).min_by(f64::total_cmp);
            assert_eq!(meshes.hit(origin, direction).map(|hit| hit.distance), nearest, "{origin} {direction}");
            for distance in [0.25, 1.0, f64::INFINITY].into_iter().chain(nearest) {
                let is_free = nearest.is_none_or(|at| at >= distance);
                assert_eq!(meshes.free(origin, direction, distance), is_free, "{origin} {direction} {distance}");
                free += u32::from(is_free);
            }
            met += u32::from(nearest.is_some());
        }
        assert!(met > 3000 && free > 3000, "{met} {free}");
    }

    /// Splits each triangle into four, for more edges and corners that rays may pass through.
    fn divided(mesh: &Mesh) -> Mesh {
        let corners = mesh.triangles.iter().map(|t| t.map(|i| DVec3::from(mesh.positions[i as usize].map(f64::from))));
        let positions: Vec<[f32; 3]> = corners
            .flat_map(|[a, b, c]| {
                let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
                [a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca]
            })
            .map(|p| p.as_vec3().into())
            .collect();
        let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh { positions, triangles, ..mesh.clone() }
    }

    #[test]
    fn a_point_is_inside_whatever_way_it_looks() {
        let middle = [0.5; 3];
        let around = [[0.5, 0.5, 1.5], [-0.5, 0.5, 0.5], [0.5, 2.0, 0.5], [1.5, 1.5, 1.5], [-1.0, 0.0, 1.0]];
        let all = |inside: &[[f64; 3]], outside: &[[f64; 3]]| -> Vec<_> {
            inside.iter().map(|p| (*p, true)).chain(outside.iter().map(|p| (*p, false))).collect()
        };
        let near_its_sides = [middle, [0.999, 0.5, 0.5], [0.5, 0.001, 0.25], [0.001, 0.001, 0.999]];
        check(&[cube([0.0; 3], 1.0)], &all(&near_its_sides, &around));
        check(&[inside_out(cube([0.0; 3], 1.0))], &all(&near_its_sides, &around));
        check(&[divided(&cube([0.0; 3], 1.0))], &all(&near_its_sides, &around));
        // Two overlapping cubes: as two meshes, as one mesh, and with one cube inside out.
        let two = [cube([0.0; 3], 1.0), cube([0.5; 3], 1.0)];
        let inside = [middle, [0.25; 3], [0.75; 3], [1.25; 3]];
        let outside = [[0.25, 0.25, 1.25], [1.75; 3], [1.25, 1.25, 0.25]];
        check(&two, &all(&inside, &outside));
        check(&[both(two[0].clone(), two[1].clone())], &all(&inside, &outside));
        check(&[both(two[0].clone(), inside_out(two[1].clone()))], &all(&inside, &outside));
        // A mesh with a hole has no inside, even around a closed mesh.
        let mut holed = cube([0.0; 3], 1.0);
        holed.triangles.pop();
        check(&[holed.clone()], &all(&[], &[middle, around[0]]));
        check(&[holed, cube([0.25; 3], 0.5)], &all(&[middle], &[[0.125; 3], around[0]]));
    }

    /// Points under a solid ground are inside if their rays leave through the ground's front and end above it.
    #[test]
    fn under_a_solid_ground() {
        let corners = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let mut ground = mesh(corners, vec![[0, 1, 2], [0, 2, 3]]);
        let inside = |ground: &Mesh, x: f64, z: f64| {
            Meshes::new(std::slice::from_ref(ground)).inside(DVec3::new(x, 0.0, z), DVec3::new(0.3, 0.0, 1.0), 4.0)
        };
        assert!(!inside(&ground, 0.0, -0.5), "not solid");
        ground.solid = true;
        assert!(inside(&ground, 0.0, -0.5) && inside(&ground, 0.5, -1e-9));
        assert!(!inside(&ground, 0.0, 0.5) && !inside(&ground, 0.0, 0.0) && !inside(&ground, 0.95, -0.5));
        assert!(!inside(&ground, 0.0, -4.5), "the light is under it too");
        let below = inside_out(ground);
        assert!(!inside(&below, 0.0, -0.5), "its front looks down");
    }
}
