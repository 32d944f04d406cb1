//! Finds the triangles of a mesh that belong to closed surfaces, whose inside no light reaches. A *thing* is a set of triangles that are
//! connected by edges; a mesh may have several.

use crate::scene::Mesh;
use glam::DVec3;

/// The kind of space behind a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The triangle belongs to no closed thing, as a leaf does not.
    Open,
    /// The inside of a closed thing. The triangle's front (counter-clockwise) looks outwards, as it should.
    Outward,
    /// The outside of a closed thing. The triangle's front looks inwards: the mesh is wound inside out.
    Inward,
}

impl Side {
    /// 1 where a ray along the triangle's normal leaves a closed thing, −1 where it enters one, 0 where the triangle is open.
    pub fn sign(self) -> i32 {
        match self {
            Self::Open => 0,
            Self::Outward => 1,
            Self::Inward => -1,
        }
    }
}

/// The least volume of a closed thing, divided by its surface to the power of 3/2. A leaf whose back is modelled too has no volume but that
/// of rounding, and must not count as closed.
const LEAST_VOLUME: f64 = 1e-9;

/// The side of each triangle. In a solid mesh all triangles have [`Side::Outward`]. In other meshes, triangles that share an edge belong to
/// one thing; vertices at the same position count as one. A thing is closed if every edge is used equally often in both directions, and the
/// thing has a volume. A triangle with two equal corners is only an edge, and belongs to the thing that has this edge.
pub fn sides(mesh: &Mesh) -> Vec<Side> {
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
        // Corners are relative to a corner of the thing, so that a distance from the origin costs no precision.
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

/// Sorts elements that are all different; with the feature `program`, in parallel.
fn sort<T: Ord + Send>(all: &mut [T]) {
    #[cfg(feature = "program")]
    rayon::slice::ParallelSliceMut::par_sort_unstable(all);
    #[cfg(not(feature = "program"))]
    all.sort_unstable();
}

/// For each vertex, the vertex that stands for all vertices at its position.
fn welded(mesh: &Mesh) -> Vec<u32> {
    // Adding 0 makes −0 the same as 0.
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
    /// Welded vertices, the lesser first.
    ends: [u32; 2],
    triangle: u32,
    /// Whether the triangle uses the edge from the lesser to the greater vertex.
    forward: bool,
}

/// All edges with two different ends, sorted so that equal edges are neighbours.
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

/// A union-find structure: each triangle names another triangle of its thing, and the last one names itself.
struct Things(Vec<u32>);

impl Things {
    /// The triangle that stands for the thing.
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
    /// Positive where the fronts look outwards.
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
        // Far out, where f32 has few digits left, and about the origin, where 0 may be −0.
        for low in [[0.0; 3], [-0.0, 0.0, -0.0], [-0.5; 3], [30_000.0, -70_000.0, 5.0]] {
            assert_eq!(sides(&cube(low, 1.0)), [Side::Outward; 12]);
            assert_eq!(sides(&inside_out(cube(low, 1.0))), [Side::Inward; 12]);
        }
    }

    /// As exporters write meshes: each face, or each triangle, with vertices of its own.
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
        // If one corner of the 36 is a bit off, the cube is no longer closed.
        corners[7][1] += 1e-3;
        assert_eq!(sides(&mesh(corners, of_triangles)), [Side::Open; 12]);
    }

    #[test]
    fn what_has_a_hole_is_open() {
        for missing in 0..12 {
            let mut holed = cube([0.0; 3], 1.0);
            holed.triangles.remove(missing);
            assert_eq!(sides(&holed), [Side::Open; 11]);
            // A triangle that is wound the wrong way counts as a hole too.
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
        // Things that meet in a corner alone stay separate.
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
        // With a back of its own, every edge of the leaf is balanced, but it has no volume.
        let both_sides = vec![[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]];
        assert_eq!(sides(&mesh(corners, both_sides)), [Side::Open; 4]);
    }

    #[test]
    fn triangles_of_no_area_do_no_harm() {
        let mut cube = cube([0.0; 3], 1.0);
        // Triangles with equal corners: on an edge of the cube, and elsewhere.
        cube.triangles.extend([[0, 1, 1], [0, 7, 0], [3, 3, 3]]);
        let found = sides(&cube);
        assert_eq!(found[..13], [Side::Outward; 13]);
        assert_eq!(found[13..], [Side::Open; 2]);
        // One side's edge has one more vertex than its neighbour's. The cube is closed if a triangle without area on the edge connects
        // both.
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
