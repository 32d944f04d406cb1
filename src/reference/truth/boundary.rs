//! Points nearer to where an opaque shadow begins or ends than a map of depths resolves: what is wrong there is the
//! resolution's, not the method's.

use super::casters::Casters;
use crate::scene::{Projection, View};
use glam::DVec3;

/// Where a point is tried besides itself, across the light's view.
const DIRECTIONS: [[f64; 2]; 8] =
    [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];

/// How far, texels. A look-up weighs texels whose centres are up to one texel away, and each of them has its depth moved
/// by what its surface's changes over one texel and a step of the coarsest rasterizer, a 16th: so a surface is felt up to
/// two texels and a 16th away. Nearer, so that what is thinner than a texel is met.
const REACHES: [f64; 3] = [2.0625, 1.0, 0.5];

/// Of the light's range: what the rounding of a stored depth and of the look-up's projection is.
const DEPTH_ROUNDING: f64 = 1e-5;

/// Cosine between a surface and the light's rays below which a texel covers so much of the surface that no depth map has
/// the answer.
const GRAZING: f64 = 0.02;

impl Casters<'_> {
    /// Whether a point lies in the boundary of an opaque shadow of light `light`, whose opaque map is `view`: whether a point
    /// within two texels of it, across the light's rays, or within a depth's rounding along them, is blocked where it is not, or
    /// the other way round.
    pub fn in_boundary(&self, light: usize, view: &View, position: DVec3) -> bool {
        let [right, up, along, z] = self.footprint(view, position);
        let rounding = DEPTH_ROUNDING * f64::from(view.far - view.near) * along;
        let blocked = !self.unblocked(light, position);
        let differs = |offset: DVec3| self.unblocked(light, position + offset) == blocked;
        z.x <= 0.0
            || [-rounding, rounding].into_iter().any(differs)
            || offsets().any(|[x, y]| differs(x * right + y * up))
    }

    /// The same of a point on a surface with that normal, which is moved within the surface's plane.
    pub fn in_surface_boundary(&self, light: usize, view: &View, position: DVec3, normal: DVec3) -> bool {
        let [right, up, along, z] = self.footprint(view, position);
        let facing = normal.dot(along) / along.length();
        if z.x <= 0.0 || facing.abs() < GRAZING {
            return true;
        }
        let within = |v: DVec3| v - along * (normal.dot(v) / normal.dot(along));
        let (right, up) = (within(right), within(up));
        let blocked = !self.unblocked(light, position);
        offsets().any(|[x, y]| self.unblocked(light, position + x * right + y * up) == blocked)
    }

    /// A texel to the right and up at a point, the ray's direction there, and its z (in x).
    fn footprint(&self, view: &View, position: DVec3) -> [DVec3; 4] {
        let z = view.axes(position).z;
        let spread = if view.projection() == Projection::Parallel { 1.0 } else { z };
        let texel = |axis: [f32; 3], scale: f32, count: u32| {
            DVec3::from(axis.map(f64::from)) * (2.0 * spread / (f64::from(scale) * f64::from(count)))
        };
        let right = texel(view.right, view.scale_x, view.width);
        let up = texel(view.up, view.scale_y, view.height);
        let z = if view.projection() == Projection::Parallel { 1.0 } else { z };
        [right, up, view.ray_through(position).direction, DVec3::X * z]
    }
}

fn offsets() -> impl Iterator<Item = [f64; 2]> {
    REACHES.into_iter().flat_map(|reach| DIRECTIONS.map(|direction| direction.map(|c| reach * c)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::on_the_axis;
    use crate::scene::{Mesh, Scene};

    /// A square from −1 to 1 at z = 0, under a light that goes down.
    fn plate() -> Scene {
        let mut scene = on_the_axis(&[(0.0, 2.0, 0.1)]);
        scene.meshes.push(Mesh {
            name: "plate".into(),
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            albedo: [0.5; 3],
            solid: false,
        });
        scene
    }

    /// Along the edge of the plate's shadow two texels to either side, and nothing else: not the middle of the shadow, not the
    /// light beside it, not above the plate.
    #[test]
    fn two_texels_about_the_edge() {
        let scene = plate();
        let casters = Casters::new(&scene);
        let view = View::opaques(&scene, 64)[0];
        let texel = 2.0 / (f64::from(view.scale_x) * 64.0);
        let near = |x: f64, z: f64| casters.in_boundary(0, &view, DVec3::new(x, 0.1, z));
        for share in [-1.9, -0.9, -0.4, 0.4, 0.9, 1.9] {
            assert!(near(1.0 + share * texel, -1.0), "{share} texels from the edge");
            assert!(!near(1.0 + share * texel, 0.5), "above the plate");
        }
        for x in [0.0, 0.5, 1.0 - 2.2 * texel, 1.0 + 2.2 * texel, 1.5] {
            assert!(!near(x, -1.0), "at {x}");
        }
        // Just behind the plate, where a stored depth may round to either side.
        assert!(near(0.2, -1e-6) && !near(0.2, -1e-3));
    }

    /// A plate's own surface is no boundary, but for its rim.
    #[test]
    fn a_surface_is_no_boundary_of_itself() {
        let scene = plate();
        let casters = Casters::new(&scene);
        let view = View::opaques(&scene, 64)[0];
        let near = |x: f64| casters.in_surface_boundary(0, &view, DVec3::new(x, 0.1, 0.0), DVec3::Z);
        assert!(!near(0.0) && !near(0.8));
        assert!(casters.in_surface_boundary(0, &view, DVec3::ZERO, DVec3::X), "along the rays");
    }
}
