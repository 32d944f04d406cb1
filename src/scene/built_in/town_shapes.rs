//! Closed shapes from which the town and the courtyard are built, and leaves.

use crate::scene::Mesh;
use glam::{DVec2, DVec3};

/// A local frame in the world: x and y are horizontal, z is up.
#[derive(Clone, Copy)]
pub(in crate::scene) struct Place {
    pub origin: DVec3,
    /// Direction of the local x axis, unit length.
    pub along: DVec2,
}

impl Place {
    /// Returns the world position of a point given in local axes.
    pub(in crate::scene) fn at(&self, [x, y, z]: [f64; 3]) -> DVec3 {
        self.origin + (x * self.along + y * self.along.perp()).extend(z)
    }

    /// Returns another place, whose origin and x axis are given in this place's axes.
    pub(in crate::scene) fn turned(&self, origin: [f64; 3], along: [f64; 2]) -> Self {
        Self { origin: self.at(origin), along: along[0] * self.along + along[1] * self.along.perp() }
    }
}

/// Creates an empty mesh with a name and an albedo.
pub(in crate::scene) fn empty(name: &str, albedo: [f32; 3]) -> Mesh {
    Mesh { name: name.into(), positions: vec![], triangles: vec![], albedo, solid: false, alpha: None }
}

/// Adds a closed shape that runs through successive `rings`, all with the same number of points. Each ring is counter-clockwise as seen
/// from the next ring. `cap` divides a ring into counter-clockwise triangles, which close both ends.
pub(in crate::scene) fn loft(mesh: &mut Mesh, rings: &[Vec<DVec3>], cap: &[[u32; 3]]) {
    let first = mesh.positions.len() as u32;
    let around = rings[0].len() as u32;
    mesh.positions.extend(rings.iter().flatten().map(|p| p.as_vec3().to_array()));
    let last = first + around * (rings.len() as u32 - 1);
    mesh.triangles.extend(cap.iter().map(|[a, b, c]| [first + a, first + c, first + b]));
    for ring in (first..last).step_by(around as usize) {
        for i in 0..around {
            let (a, b) = (ring + i, ring + (i + 1) % around);
            mesh.triangles.extend([[a, b, b + around], [a, b + around, a + around]]);
        }
    }
    mesh.triangles.extend(cap.iter().map(|t| t.map(|i| last + i)));
}

/// Adds a box between two corners.
pub(in crate::scene) fn block(mesh: &mut Mesh, place: &Place, [x0, y0, z0]: [f64; 3], [x1, y1, z1]: [f64; 3]) {
    let ring = |z: f64| [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]].map(|p| place.at(p)).to_vec();
    loft(mesh, &[ring(z0), ring(z1)], &fan(4));
}

/// Adds an outline (y, z), counter-clockwise as seen from +x, extruded along x. `cap` divides the outline into triangles.
pub(in crate::scene) fn extrude(
    mesh: &mut Mesh,
    place: &Place,
    [x0, x1]: [f64; 2],
    outline: &[[f64; 2]],
    cap: &[[u32; 3]],
) {
    let ring = |x: f64| outline.iter().map(|[y, z]| place.at([x, *y, *z])).collect();
    loft(mesh, &[ring(x0), ring(x1)], cap);
}

/// Adds a tube with `sides` sides along a path of points with radii.
pub(in crate::scene) fn tube(mesh: &mut Mesh, path: &[(DVec3, f64)], sides: u32) {
    let direction = (path[path.len() - 1].0 - path[0].0).normalize_or(DVec3::Z);
    let right = DVec3::Z.cross(direction).normalize_or(DVec3::X);
    let up = direction.cross(right);
    let ring = |(middle, radius): &(DVec3, f64)| {
        let point = |i: u32| {
            let [x, y] = crate::scene::built_in::emitters::direction(f64::from(i) / f64::from(sides)).to_array();
            *middle + *radius * (x * right + y * up)
        };
        (0..sides).map(point).collect()
    };
    loft(mesh, &path.iter().map(ring).collect::<Vec<_>>(), &fan(sides));
}

/// Adds a beam between two points, with its width horizontal.
pub(in crate::scene) fn beam(mesh: &mut Mesh, [from, to]: [DVec3; 2], half_width: f64, half_height: f64) {
    let right = DVec3::Z.cross(to - from).normalize_or(DVec3::X) * half_width;
    let up = DVec3::Z * half_height;
    let ring = |p: DVec3| vec![p - right - up, p + right - up, p + right + up, p - right + up];
    loft(mesh, &[ring(from), ring(to)], &fan(4));
}

/// Adds a slightly bent leaf of two triangles. `along` is half its length, starting at the stem; `across` is half its width, to each side.
pub(in crate::scene) fn leaf(mesh: &mut Mesh, stem: DVec3, along: DVec3, across: DVec3) {
    let first = mesh.positions.len() as u32;
    let bend = 0.15 * along.cross(across).normalize_or_zero() * along.length();
    let corners = [stem, stem + along + across + bend, stem + 2.0 * along, stem + along - across + bend];
    mesh.positions.extend(corners.map(|p| p.as_vec3().to_array()));
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
}

/// Returns triangles that divide a convex ring, fanning out from its first point.
pub(in crate::scene) fn fan(points: u32) -> Vec<[u32; 3]> {
    (1..points - 1).map(|i| [0, i, i + 1]).collect()
}
