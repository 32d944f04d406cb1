//! CPU twins of glsl/technique/half_angle/ and of its picture. Casters are cut into slices along the half vector of light and camera, and
//! the light's buffer holds the light left after each slice. Sources: Kniss et al. 2003; Green 2008.

use super::filter::Filter;
use super::order::{float_order, sort};
use super::segment::{Segment, ray, texel_segment};
use super::splat::strand_axis;
use crate::reference::truth::{Casters, camera_rays, lift, lit_surface};
use crate::scene::{Caster, Order, Picture, Scene, View};
use glam::{DVec3, Vec2, Vec3};

/// Returns the unit vector along which slices are stacked, and whether the camera meets them from near to far.
/// Twin: `technique::half_vector`.
pub fn half_vector(camera: [f32; 3], light: [f32; 3]) -> (Vec3, bool) {
    let (camera, light) = (Vec3::from(camera), Vec3::from(light));
    let near_to_far = camera.dot(light) >= 0.0;
    ((light + if near_to_far { camera } else { -camera }).normalize_or_zero(), near_to_far)
}

/// Returns the position of each caster's centre along the half vector. Twin: keys.comp.
pub fn keys(half: Vec3, light: &View, casters: &[Caster]) -> Vec<f32> {
    let middle = |c: &Caster| Vec3::from(c.position) + 0.5 * strand_axis(c) - Vec3::from(light.origin);
    casters.iter().map(|caster| middle(caster).dot(half)).collect()
}

/// Returns the depth at which a texel's ray hits the first mesh, in the volume view's range; infinite if it hits none. Reads it from
/// `depths`, the opaque map of the view `opaque`. Twin: mesh_depth.
pub fn mesh_depth(view: &View, opaque: &View, depths: &[f32], texel: [u32; 2]) -> f32 {
    let (origin, direction) = ray(view, Vec2::new(texel[0] as f32, texel[1] as f32) + 0.5);
    let (at, _) = opaque.project((origin + direction).as_dvec3());
    let [x, y] = [at.x.floor() as i64, at.y.floor() as i64];
    if !(0..i64::from(opaque.width)).contains(&x) || !(0..i64::from(opaque.height)).contains(&y) {
        return f32::INFINITY;
    }
    let depth = depths[(y * i64::from(opaque.width) + x) as usize];
    let apart = (Vec3::from(opaque.origin) - Vec3::from(view.origin)).dot(view.forward.into());
    let z = opaque.near + depth * (opaque.far - opaque.near) + apart;
    if depth < 1.0 { (z - view.near) / (view.far - view.near) } else { f32::INFINITY }
}

/// Returns the light that these casters leave at a texel, counted up to the depth `end`. Twin: light.frag and its blending.
pub fn light<'a>(view: &View, texel: [u32; 2], end: f32, casters: impl IntoIterator<Item = &'a Caster>) -> f32 {
    let segments = casters.into_iter().filter_map(|caster| texel_segment(view, texel, caster));
    let taken = |Segment { entry, exit, optical_depth }| match () {
        _ if entry >= end => 0.0,
        _ if exit > end => optical_depth * ((end - entry) / (exit - entry)),
        _ => optical_depth,
    };
    (-segments.map(taken).sum::<f32>()).exp()
}

/// The light's buffer before each slice and after the last one, and the slice of each caster.
pub struct Slices {
    /// The buffers, each in rows of texels.
    pub buffers: Vec<Vec<f32>>,
    /// The slice of each caster.
    pub slice: Vec<usize>,
    /// Casters in slice order.
    pub order: Vec<u32>,
    /// Whether this order is near to far for the camera.
    pub near_to_far: bool,
}

/// Cuts the casters into `count` slices with equal numbers of casters, along the half vector of `camera` and the light's map `view`.
pub fn slices(view: &View, camera: &View, casters: &[Caster], count: usize) -> Slices {
    let (half, near_to_far) = half_vector(camera.forward, view.forward);
    let keys: Vec<u32> = keys(half, view, casters).into_iter().map(float_order).collect();
    let order = sort(&keys);
    let (mut slice, mut buffers) = (vec![0; casters.len()], vec![vec![1.0; view.texels()]]);
    for i in 0..count {
        let places = i * casters.len() / count..(i + 1) * casters.len() / count;
        let drawn: Vec<_> = order[places].iter().map(|caster| *caster as usize).collect();
        drawn.iter().for_each(|caster| slice[*caster] = i);
        let texel = |at: usize, before: f32| {
            let texel = [at as u32 % view.width, at as u32 / view.width];
            before * light(view, texel, f32::INFINITY, drawn.iter().map(|caster| &casters[*caster]))
        };
        let next = buffers[i].iter().enumerate().map(|(at, before)| texel(at, *before)).collect();
        buffers.push(next);
    }
    Slices { buffers, slice, order, near_to_far }
}

impl Slices {
    /// Returns the light at a point, read from the buffer before slice `slice`. Twin: visibility.glsl without meshes.
    fn at(&self, view: &View, slice: usize, position: DVec3) -> f64 {
        let (at, z) = view.project(position);
        if z <= f64::from(view.near) {
            return 1.0;
        }
        let size = Vec2::new(view.width as f32, view.height as f32);
        let texels = Filter::Bilinear.weights(size, at.as_vec2());
        let inside = |x: i32, y: i32| (0..view.width as i32).contains(&x) && (0..view.height as i32).contains(&y);
        let value = |x: i32, y: i32| {
            if inside(x, y) { self.buffers[slice][(y * view.width as i32 + x) as usize] } else { 1.0 }
        };
        texels.into_iter().map(|(texel, weight)| f64::from(weight * value(texel.x, texel.y))).sum()
    }
}

/// Renders a scene with one light and no meshes.
pub fn picture(casters: &Casters, scene: &Scene, camera: &View, view: &View, count: usize) -> Picture {
    let mut slices = slices(view, camera, &casters.all, count);
    if slices.near_to_far {
        // Blending "under" from near to far equals blending "over" from far to near.
        slices.order.reverse();
    }
    let order = Order { casters: std::mem::take(&mut slices.order), volumes: Vec::new() };
    let slices = &slices;
    let light = |_, index: Option<u32>, position: DVec3| {
        let index = index.expect("what is painted has no volumes, but their cells");
        let towards = scene.lights[0].towards(position);
        let caster = &casters.all[index as usize];
        let all = arriving_unshadowed(scene, position);
        all * slices.at(view, slices.slice[index as usize], position + lift(caster, towards) * towards)
    };
    camera_rays(casters, scene, camera, &order, light, |at, hit| lit_surface(casters, scene, at, hit))
}

fn arriving_unshadowed(scene: &Scene, position: DVec3) -> DVec3 {
    let light = &scene.lights[0];
    if !light.shines_on(position) {
        return DVec3::ZERO;
    }
    DVec3::from(light.radiance.map(f64::from)) * light.falloff(position)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The half vector lies between the two directions; the camera's is reversed if it looks against the light.
    #[test]
    fn half_vectors_lie_between() {
        let (down, along) = ([0.0, 0.0, -1.0], [1.0, 0.0, 0.0]);
        assert_eq!(half_vector(down, down), (Vec3::NEG_Z, true));
        assert_eq!(half_vector([0.0, 0.0, 1.0], down), (Vec3::NEG_Z, false));
        let (half, near_to_far) = half_vector(along, down);
        assert!(near_to_far && (half - Vec3::new(0.5f32.sqrt(), 0.0, -0.5f32.sqrt())).length() < 1e-6);
    }
}
