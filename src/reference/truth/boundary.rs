//! Points nearer to where an opaque shadow begins or ends than a technique resolves: what is wrong there is the
//! resolution's, not the method's.

use super::casters::Casters;
use crate::scene::{Projection, Resolution, View};
use glam::DVec3;

/// The nearest that a point is tried across the rays, texels, so that what is thinner than a texel is met.
const NEAREST: f64 = 0.5;

/// Places on a square about the point are no farther apart than this, texels.
const APART: f64 = 2.0625;

/// Cosine between a surface and the light's rays below which a texel covers so much of the surface that nothing with
/// texels has the answer.
const GRAZING: f64 = 0.02;

impl Casters<'_> {
    /// Whether a point lies in the boundary of an opaque shadow of light `light`: whether a point nearer to it than the
    /// technique resolves, across the light's rays or along them, is blocked where it is not, or the other way round; or lies
    /// inside something closed, where the technique may answer anything.
    pub fn in_boundary(&self, light: usize, resolution: &Resolution, position: DVec3) -> bool {
        let [right, up, along, z] = self.footprint(&resolution.view, position);
        let depth = depth(resolution) * along;
        let blocked = !self.unblocked(light, position);
        let differs = |offset: DVec3| {
            let at = position + offset;
            self.unblocked(light, at) == blocked || resolution.free_inside && self.inside(light, at)
        };
        z.x <= 0.0
            || [-depth, depth].into_iter().any(differs)
            || offsets(resolution.reach_texels).any(|[x, y]| differs(x * right + y * up))
    }

    /// The same of a point on a surface with that normal, which is moved within the surface's plane, and off it where look-ups
    /// are; or whether another
    /// surface is so near to it along the rays that the technique does not tell the two apart.
    pub fn in_surface_boundary(&self, light: usize, resolution: &Resolution, position: DVec3, normal: DVec3) -> bool {
        let [right, up, along, z] = self.footprint(&resolution.view, position);
        let facing = normal.dot(along) / along.length();
        if z.x <= 0.0 || facing.abs() < GRAZING {
            return true;
        }
        let within = |v: DVec3| v - along * (normal.dot(v) / normal.dot(along));
        let (across, across_up) = (right, up);
        let (right, up) = (within(right), within(up));
        let depth = depth(resolution) * along;
        let blocked = !self.unblocked(light, position);
        let differs = |offset: DVec3| self.unblocked(light, position + offset) == blocked;
        // Away from the surface, on the side that is looked at: the light's of what is open, the outside of what is not.
        let off = normal * across.length() * resolution.normal_texels;
        let moved = resolution.normal_texels > 0.0;
        offsets(resolution.reach_texels).any(|[x, y]| differs(x * right + y * up))
            || moved && offsets(resolution.reach_texels).any(|[x, y]| differs(off + x * across + y * across_up))
            || [-depth, depth].into_iter().any(|depth| !self.meshes.free(position, depth, 1.0))
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

/// How far along a ray, in lengths of its direction.
fn depth(resolution: &Resolution) -> f64 {
    resolution.depth * f64::from(resolution.view.far - resolution.view.near)
}

/// Where a point is tried besides itself, texels: on squares about it, the outermost at `reach`, the others at each whole
/// texel between and at the nearest.
fn offsets(reach: f64) -> impl Iterator<Item = [f64; 2]> {
    let between = (1..).map(f64::from).take_while(move |texels| texels + 1.0 <= reach);
    [reach, NEAREST.min(reach)].into_iter().chain(between).flat_map(square)
}

/// Corners and sides of a square of that reach.
fn square(reach: f64) -> impl Iterator<Item = [f64; 2]> {
    let parts = (2.0 * reach / APART).ceil().max(2.0) as u32;
    let place = move |i: u32| reach * (2.0 * f64::from(i) / f64::from(parts) - 1.0);
    let all = (0..=parts).flat_map(move |x| (0..=parts).map(move |y| [x, y]));
    all.filter(move |at| at.iter().any(|i| *i == 0 || *i == parts)).map(move |at| at.map(place))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::on_the_axis;
    use crate::scene::{Mesh, Scene, View};

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

    /// Of the scene's light, 64 texels across.
    fn resolution(scene: &Scene, reach_texels: f64, depth: f64) -> (Resolution, f64) {
        let view = View::opaques(scene, 64)[0];
        (
            Resolution { view, reach_texels, normal_texels: 0.0, free_inside: false, depth },
            2.0 / (f64::from(view.scale_x) * 64.0),
        )
    }

    /// Along the edge of the plate's shadow two texels to either side, and nothing else: not the middle of the shadow, not the
    /// light beside it, not above the plate.
    #[test]
    fn two_texels_about_the_edge() {
        let scene = plate();
        let casters = Casters::new(&scene);
        let (resolution, texel) = resolution(&scene, 2.0625, 1e-5);
        let near = |x: f64, z: f64| casters.in_boundary(0, &resolution, DVec3::new(x, 0.1, z));
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
        let (resolution, _) = resolution(&scene, 2.0625, 1e-5);
        let near = |x: f64| casters.in_surface_boundary(0, &resolution, DVec3::new(x, 0.1, 0.0), DVec3::Z);
        assert!(!near(0.0) && !near(0.8));
        assert!(casters.in_surface_boundary(0, &resolution, DVec3::ZERO, DVec3::X), "along the rays");
    }

    /// With a wide reach a caster of two texels is met however far off it stands within it, and none farther off.
    #[test]
    fn a_wide_reach_has_no_gaps() {
        let mut scene = plate();
        let (resolution, texel) = resolution(&scene, 6.0, 1e-5);
        for (x, y) in [(5.9, 0.0), (3.0, 5.9), (-1.0, 2.0), (0.0, 0.4), (-5.9, 5.9)] {
            let ([x, y], half) = ([x, y].map(|c: f64| (c * texel) as f32), (1.1 * texel) as f32);
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            scene.meshes[0].positions = corners.map(|[i, j]| [x + i * half, y + j * half, 0.0]).into();
            let casters = Casters::new(&scene);
            let near = |x: f64| casters.in_boundary(0, &resolution, DVec3::new(x * texel, 0.0, -1.0));
            assert!(near(0.0), "{x} {y}");
            assert!(!near(20.0), "{x} {y}");
        }
    }

    /// Two surfaces nearer to each other than the depth that is resolved, and no other two.
    #[test]
    fn surfaces_that_touch_along_the_rays() {
        let mut scene = plate();
        let mut below = scene.meshes[0].clone();
        below.positions.iter_mut().for_each(|p| p[2] = -0.1);
        scene.meshes.push(below);
        let casters = Casters::new(&scene);
        let (fine, _) = resolution(&scene, 2.0625, 1e-5);
        let range = f64::from(fine.view.far - fine.view.near);
        let near = |z: f64, depth: f64| {
            let resolution = Resolution { depth: depth / range, ..fine };
            casters.in_surface_boundary(0, &resolution, DVec3::new(0.1, 0.2, z), DVec3::Z)
        };
        for z in [0.0, f64::from(-0.1f32)] {
            assert!(!near(z, 0.09) && near(z, 0.11), "{z}");
        }
    }
}
