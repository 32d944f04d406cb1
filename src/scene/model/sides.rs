//! Finds the triangles of a mesh that belong to closed surfaces, whose inside no light reaches. A *thing* is a set of triangles connected
//! by edges; a mesh may have several.

use crate::scene::Mesh;
use glam::DVec3;

/// The kind of space behind a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The triangle is not part of a closed thing, as in a leaf.
    Open,
    /// The inside of a closed thing. The triangle's front (counter-clockwise) faces outwards, as it should.
    Outward,
    /// The outside of a closed thing. The triangle's front faces inwards: the mesh is wound inside out.
    Inward,
}

impl Side {
    /// Returns 1 if a ray along the triangle's normal leaves a closed thing, −1 if it enters one, and 0 if the triangle is open.
    pub fn sign(self) -> i32 {
        match self {
            Self::Open => 0,
            Self::Outward => 1,
            Self::Inward => -1,
        }
    }
}

/// The smallest volume of a closed thing, divided by its surface area to the power of 3/2. A leaf with a modelled back has no volume apart
/// from rounding, and must not count as closed.
const LEAST_VOLUME: f64 = 1e-9;

/// Returns the side of each triangle. In a solid mesh all triangles are [`Side::Outward`]. In other meshes, triangles that share an edge
/// belong to one thing; vertices at the same position count as one. A thing is closed if every edge is used equally often in both
/// directions, and the thing has a volume. A triangle with two equal corners is only an edge, and belongs to the thing that has this edge.
/// A mesh with alpha encloses nothing.
pub fn sides(mesh: &Mesh) -> Vec<Side> {
    if mesh.alpha.is_some() {
        return vec![Side::Open; mesh.triangles.len()];
    }
    if mesh.solid {
        return vec![Side::Outward; mesh.triangles.len()];
    }
    let welded = welded(mesh);
    let mut things = Things((0..mesh.triangles.len() as u32).collect());
    let edges = edges(mesh, &welded);
    let same_edge = || edges.chunk_by(|a, b| a.ends == b.ends);
    for edge in same_edge() {
        edge.windows(2).for_each(|pair| things.join(pair[0].triangle, pair[1].triangle));
    }

    let mut measured = vec![Thing::default(); mesh.triangles.len()];
    for edge in same_edge() {
        let balance: i32 = edge.iter().map(|half| if half.forward { 1 } else { -1 }).sum();
        measured[things.of(edge[0].triangle)].is_open |= balance != 0;
    }
    for (number, triangle) in (0..).zip(&mesh.triangles) {
        let thing = things.of(number);
        // Corners are relative to a corner of the thing, so that no precision is lost far from the origin.
        let origin = mesh.triangles[thing].map(|i| position(mesh, i))[0];
        let [a, b, c] = triangle.map(|i| position(mesh, i) - origin);
        measured[thing].area += 0.5 * (b - a).cross(c - a).length();
        measured[thing].volume += a.dot(b.cross(c)) / 6.0;
    }
    (0..mesh.triangles.len() as u32).map(|number| measured[things.of(number)].side()).collect()
}

fn position(mesh: &Mesh, index: u32) -> DVec3 {
    mesh.positions.get(index as usize).map_or(DVec3::NAN, |p| DVec3::from(p.map(f64::from)))
}

/// Sorts elements that are all distinct; in parallel with the feature `program`.
fn sort<T: Ord + Send>(all: &mut [T]) {
    #[cfg(feature = "program")]
    rayon::slice::ParallelSliceMut::par_sort_unstable(all);
    #[cfg(not(feature = "program"))]
    all.sort_unstable();
}

/// Returns, for each vertex, the representative of all vertices at its position.
fn welded(mesh: &Mesh) -> Vec<u32> {
    // Adding 0 turns −0 into 0.
    let bits = |p: &[f32; 3]| p.map(|value| (value + 0.0).to_bits());
    let mut order: Vec<_> = (0..).zip(&mesh.positions).map(|(number, p)| (bits(p), number)).collect();
    sort(&mut order);
    let mut welded = vec![0; order.len()];
    for same in order.chunk_by(|a, b| a.0 == b.0) {
        same.iter().for_each(|(_, number): &(_, u32)| welded[*number as usize] = same[0].1);
    }
    welded
}

/// An edge of a triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct HalfEdge {
    /// Welded vertices, the lower index first.
    ends: [u32; 2],
    triangle: u32,
    /// Whether the triangle traverses the edge from the lower to the higher vertex index.
    forward: bool,
}

/// Returns all edges with two distinct ends, sorted so that equal edges are adjacent.
fn edges(mesh: &Mesh, welded: &[u32]) -> Vec<HalfEdge> {
    let vertex = |i: u32| welded.get(i as usize).copied().unwrap_or(i);
    let mut edges = Vec::with_capacity(3 * mesh.triangles.len());
    for (triangle, [a, b, c]) in (0..).zip(mesh.triangles.iter().map(|t| t.map(vertex))) {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            if from != to {
                edges.push(HalfEdge { ends: [from.min(to), from.max(to)], triangle, forward: from < to });
            }
        }
    }
    sort(&mut edges);
    edges
}

/// A union-find structure: each triangle points to another triangle of its thing, and the root points to itself.
struct Things(Vec<u32>);

impl Things {
    /// Returns the thing's root triangle.
    fn of(&mut self, triangle: u32) -> usize {
        let mut at = triangle as usize;
        while self.0[at] as usize != at {
            // Halves the path for the next search.
            self.0[at] = self.0[self.0[at] as usize];
            at = self.0[at] as usize;
        }
        at
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}

/// Totals over the triangles of a thing.
#[derive(Clone, Copy, Default)]
struct Thing {
    is_open: bool,
    area: f64,
    /// Positive if the fronts face outwards.
    volume: f64,
}

impl Thing {
    fn side(&self) -> Side {
        let least = LEAST_VOLUME * self.area * self.area.sqrt();
        match self.is_open {
            false if self.volume > least => Side::Outward,
            false if self.volume < -least => Side::Inward,
            _ => Side::Open,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::{CUBE, both, cube, inside_out, mesh};

    #[test]
    fn cubes_are_closed() {
        // Cubes far out, where f32 has few digits left, and around the origin, where 0 may be −0.
        for low in [[0.0; 3], [-0.0, 0.0, -0.0], [-0.5; 3], [30_000.0, -70_000.0, 5.0]] {
            assert_eq!(sides(&cube(low, 1.0)), [Side::Outward; 12]);
            assert_eq!(sides(&inside_out(cube(low, 1.0))), [Side::Inward; 12]);
        }
    }

    /// A cube must count as closed even if each face, or each triangle, has its own vertices, as exporters may write it.
    #[test]
    fn vertices_at_one_position_are_one() {
        let cube = cube([-1.0, -1.0, 0.0], 1.0);
        let at = |i: &u32| cube.positions[*i as usize];
        let faces = CUBE.iter().flatten().map(at).collect();
        let of_faces = (0..6).flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]]).collect();
        assert_eq!(sides(&mesh(faces, of_faces)), [Side::Outward; 12]);
        let mut corners: Vec<_> = cube.triangles.iter().flatten().map(at).collect();
        let of_triangles: Vec<_> = (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        assert_eq!(sides(&mesh(corners.clone(), of_triangles.clone())), [Side::Outward; 12]);
        // If one of the 36 corners is slightly off, the cube is no longer closed.
        corners[7][1] += 1e-3;
        assert_eq!(sides(&mesh(corners, of_triangles)), [Side::Open; 12]);
    }

    #[test]
    fn what_has_a_hole_is_open() {
        for missing in 0..12 {
            let mut holed = cube([0.0; 3], 1.0);
            holed.triangles.remove(missing);
            assert_eq!(sides(&holed), [Side::Open; 11]);
            // A triangle wound the wrong way also counts as a hole.
            let mut turned = cube([0.0; 3], 1.0);
            turned.triangles[missing].swap(0, 1);
            assert_eq!(sides(&turned), [Side::Open; 12]);
        }
    }

    #[test]
    fn each_thing_of_a_mesh_is_looked_at_by_itself() {
        let overlapping = both(cube([0.0; 3], 1.0), cube([0.5; 3], 1.0));
        assert_eq!(sides(&overlapping), [Side::Outward; 24]);
        let mut holed = cube([0.5; 3], 1.0);
        holed.triangles.pop();
        let mixed = both(inside_out(cube([0.0; 3], 1.0)), holed);
        assert_eq!(sides(&mixed), [vec![Side::Inward; 12], vec![Side::Open; 11]].concat());
        // Things that touch only at a corner stay separate.
        let mut holed = cube([1.0; 3], 1.0);
        holed.triangles.pop();
        let at_a_corner = both(cube([0.0; 3], 1.0), holed);
        assert_eq!(sides(&at_a_corner), [vec![Side::Outward; 12], vec![Side::Open; 11]].concat());
        // Two cubes that share an edge use it twice in each direction.
        assert_eq!(sides(&both(cube([0.0; 3], 1.0), cube([1.0, 1.0, 0.0], 1.0))), [Side::Outward; 24]);
    }

    #[test]
    fn leaves_are_open() {
        let corners = vec![[0.0; 3], [1.0, 0.0, 0.1], [1.0, 1.0, 0.3], [0.0, 1.0, 0.2]];
        assert_eq!(sides(&mesh(corners.clone(), vec![[0, 1, 2], [0, 2, 3]])), [Side::Open; 2]);
        // If the leaf has a back of its own, every edge is balanced, but the volume is 0.
        let both_sides = vec![[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]];
        assert_eq!(sides(&mesh(corners, both_sides)), [Side::Open; 4]);
    }

    #[test]
    fn triangles_of_no_area_do_no_harm() {
        let mut cube = cube([0.0; 3], 1.0);
        // Degenerate triangles with equal corners: on an edge of the cube, and elsewhere.
        cube.triangles.extend([[0, 1, 1], [0, 7, 0], [3, 3, 3]]);
        let found = sides(&cube);
        assert_eq!(found[..13], [Side::Outward; 13]);
        assert_eq!(found[13..], [Side::Open; 2]);
        // An edge of one face has one more vertex than its neighbour's. The cube is closed if a triangle without area connects the two.
        let middle = cube.positions.len() as u32;
        cube.positions.push([0.5, 0.0, 0.0]);
        cube.triangles.truncate(12);
        let [a, b, c] = cube.triangles[0];
        assert_eq!([a, b], [0, 1], "the edge along x");
        cube.triangles.splice(0..1, [[a, middle, c], [middle, b, c]]);
        assert_eq!(sides(&cube), [Side::Open; 13]);
        cube.triangles.push([a, b, middle]);
        assert_eq!(sides(&cube), [Side::Outward; 14]);
    }

    #[test]
    fn solid_is_as_it_is_wound() {
        let mut ground = mesh(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
        assert_eq!(sides(&ground), [Side::Open]);
        ground.solid = true;
        assert_eq!(sides(&ground), [Side::Outward]);
        assert_eq!(sides(&mesh(vec![], vec![])), []);
    }

    #[test]
    fn numbers_that_are_none_are_open() {
        let mut broken = cube([0.0; 3], 1.0);
        broken.positions[3] = [f32::NAN; 3];
        assert_eq!(sides(&broken), [Side::Open; 12]);
        let mut beyond = cube([0.0; 3], 1.0);
        beyond.triangles[4][1] = 99;
        assert_eq!(sides(&beyond), [Side::Open; 12]);
    }
}
