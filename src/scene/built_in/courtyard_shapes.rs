//! Shapes used only by the courtyard: arches and a knotted ring.

use crate::scene::Mesh;
use crate::scene::built_in::emitters::direction;
use crate::scene::built_in::town_shapes::{Place, extrude};
use glam::DVec3;

/// Number of straight segments per arch.
const PIECES: u32 = 20;

/// A wall on arches. It runs along the y axis of its [`Place`] and is centred on the place's origin.
pub(in crate::scene) struct Arches {
    pub count: u32,
    /// Distance between the centres of neighbouring arches.
    pub bay: f64,
    /// Radius of an arch, which is a semicircle.
    pub radius: f64,
    /// Height at which the arches begin, and height of the wall's top.
    pub heights: [f64; 2],
    /// Half the wall's thickness, along x.
    pub half_thickness: f64,
}

impl Arches {
    /// Returns the centre of arch `i`, along y.
    fn middle(&self, i: u32) -> f64 {
        self.bay * (f64::from(i) + 0.5 - 0.5 * f64::from(self.count))
    }

    /// Adds the wall, as one closed surface.
    pub(in crate::scene) fn wall(&self, mesh: &mut Mesh, place: &Place) {
        let [spring, top] = self.heights;
        let end = 0.5 * self.bay * f64::from(self.count);
        let mut below = vec![[-end, spring]];
        for i in 0..self.count {
            below.extend(arc([self.middle(i), spring], self.radius).into_iter().rev());
        }
        below.push([end, spring]);
        let above = below.iter().rev().map(|[y, _]| [*y, top]);
        let outline: Vec<_> = below.iter().copied().chain(above).collect();
        let half = self.half_thickness;
        extrude(mesh, place, [-half, half], &outline, &strip(below.len() as u32));
    }

    /// Adds a band around each arch on both sides of the wall, protruding from it by `out`.
    pub(in crate::scene) fn frames(&self, mesh: &mut Mesh, place: &Place, width: f64, out: f64) {
        for i in 0..self.count {
            let middle = [self.middle(i), self.heights[0]];
            // The band's opening is slightly narrower than the arch, so that the wall's edge is inside the band.
            let (outer, inner) = (arc(middle, self.radius + width), arc(middle, self.radius - 0.3 * out));
            let outline: Vec<_> = inner.iter().rev().chain(&outer).copied().collect();
            let half = self.half_thickness;
            for from in [-half - out, half - out] {
                extrude(mesh, place, [from, from + 2.0 * out], &outline, &strip(PIECES + 1));
            }
        }
    }
}

/// Returns the upper half of a circle around (y, z), from +y to −y.
fn arc([y, z]: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    let point = |i: u32| {
        let [across, up] = (radius * direction(0.5 * f64::from(i) / f64::from(PIECES))).to_array();
        [y + across, z + up]
    };
    (0..=PIECES).map(point).collect()
}

/// Returns triangles that fill an outline of `count` points from −y to +y, followed by the same number of points back, above them. Two
/// triangles join each pair of a lower and an upper point to the next pair.
fn strip(count: u32) -> Vec<[u32; 3]> {
    let above = |i: u32| 2 * count - 1 - i;
    (0..count - 1).flat_map(|i| [[i, i + 1, above(i + 1)], [i, above(i + 1), above(i)]]).collect()
}

/// Adds a trefoil knot made of a round bar, as a closed surface, in the x-z plane around `middle`; `reach` is its outer radius.
pub(in crate::scene) fn knot(mesh: &mut Mesh, middle: DVec3, reach: f64, thickness: f64) {
    const AROUND: u32 = 240;
    const SIDES: u32 = 18;
    let core = 0.62 * (reach - thickness);
    // The bar turns three times around the core while the core goes around twice.
    let at = |turn: f64| {
        let ([x, z], [out, side]) = (direction(2.0 * turn).to_array(), direction(3.0 * turn).to_array());
        let from_core = DVec3::new(x * out, side, z * out);
        (DVec3::new(x, 0.0, z) * core + 0.6 * core * from_core, from_core)
    };
    let first = mesh.positions.len() as u32;
    for i in 0..AROUND {
        let turn = f64::from(i) / f64::from(AROUND);
        let (position, from_core) = at(turn);
        let along = (at(turn + 1e-3).0 - at(turn - 1e-3).0).normalize_or(DVec3::X);
        let right = (from_core - along * from_core.dot(along)).normalize_or(along.any_orthonormal_vector());
        let up = along.cross(right);
        for side in 0..SIDES {
            let [x, y] = direction(f64::from(side) / f64::from(SIDES)).to_array();
            mesh.positions.push((middle + position + thickness * (x * right + y * up)).as_vec3().to_array());
        }
    }
    for i in 0..AROUND {
        for side in 0..SIDES {
            let corner = |i: u32, side: u32| first + i % AROUND * SIDES + side % SIDES;
            let [a, b, c, d] = [corner(i, side), corner(i, side + 1), corner(i + 1, side + 1), corner(i + 1, side)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
}
