//! How a light or a camera sees the world. Twin: glsl/world/view.glsl.

use super::{Camera, FACES, Light, LightKind, Mesh, Particle, Scene, Strand};
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};

/// A depth or a z farther than any: an unused node's, or where light ends that goes on. Twins: EMPTY in
/// glsl/avsm/node.glsl, INFINITY in glsl/bins/tiles.glsl.
pub const FARTHEST: f32 = 3e38;

/// Parallel rays or rays from one point.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// A directional light.
    Parallel = 0,
    /// A spot light, a face of a point light, or a camera.
    Perspective = 1,
}

/// A view, exactly as the shaders have it: numbers are rounded to f32 once, here, so that the f64 reference and the
/// device mean the same rays. `z` is the distance along `forward`, world units.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct View {
    /// World units.
    pub origin: [f32; 3],
    /// A [`Projection`] as a number.
    pub projection: u32,
    /// Unit length.
    pub right: [f32; 3],
    /// NDC a world unit (parallel) or a unit of tangent (perspective).
    pub scale_x: f32,
    /// Unit length.
    pub up: [f32; 3],
    /// As `scale_x`; negative for cameras, since NDC y points down.
    pub scale_y: f32,
    /// Unit length.
    pub forward: [f32; 3],
    /// z of depth 0.
    pub near: f32,
    /// z of depth 1.
    pub far: f32,
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
}

/// A ray whose parameter is z, in f64: point = origin + z · direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// World units.
    pub origin: DVec3,
    /// Length 1 for parallel views, ≥ 1 for perspective ones.
    pub direction: DVec3,
}

impl Ray {
    /// The point at `z`.
    pub fn at(&self, z: f64) -> DVec3 {
        self.origin + z * self.direction
    }
}

fn vec(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// Two unit vectors across `forward`, the same for the same input.
fn across(forward: DVec3, up: DVec3) -> (DVec3, DVec3) {
    let right = forward.cross(up).normalize();
    (right, right.cross(forward))
}

/// Any up that is not along `forward`.
fn some_up(forward: DVec3) -> DVec3 {
    if forward.z.abs() < 0.99 { DVec3::Z } else { DVec3::Y }
}

impl View {
    /// Parallel or perspective.
    pub fn projection(&self) -> Projection {
        if self.projection == Projection::Parallel as u32 { Projection::Parallel } else { Projection::Perspective }
    }

    /// Texel coordinates (centres at .5) and z of a point. Behind a perspective view the coordinates mean nothing.
    pub fn project(&self, position: DVec3) -> (DVec2, f64) {
        let offset = position - vec(self.origin);
        let z = offset.dot(vec(self.forward));
        let w = if self.projection() == Projection::Parallel { 1.0 } else { z };
        let ndc = DVec2::new(
            offset.dot(vec(self.right)) * f64::from(self.scale_x),
            offset.dot(vec(self.up)) * f64::from(self.scale_y),
        ) / w;
        ((ndc * 0.5 + 0.5) * DVec2::new(self.width.into(), self.height.into()), z)
    }

    /// The ray through a point given in texels.
    pub fn ray(&self, texel: DVec2) -> Ray {
        let ndc = texel / DVec2::new(self.width.into(), self.height.into()) * 2.0 - 1.0;
        let across =
            vec(self.right) * (ndc.x / f64::from(self.scale_x)) + vec(self.up) * (ndc.y / f64::from(self.scale_y));
        match self.projection() {
            Projection::Parallel => Ray { origin: vec(self.origin) + across, direction: vec(self.forward) },
            Projection::Perspective => Ray { origin: vec(self.origin), direction: vec(self.forward) + across },
        }
    }

    /// The ray through the view and `position`.
    pub fn ray_through(&self, position: DVec3) -> Ray {
        let offset = position - vec(self.origin);
        let z = offset.dot(vec(self.forward));
        match self.projection() {
            Projection::Parallel => Ray { origin: position - z * vec(self.forward), direction: vec(self.forward) },
            Projection::Perspective => Ray { origin: vec(self.origin), direction: offset / z },
        }
    }

    /// z of a depth in [0, 1].
    pub fn z(&self, depth: f64) -> f64 {
        f64::from(self.near) + depth * (f64::from(self.far) - f64::from(self.near))
    }

    /// Depth of a z: 0 at `near`, 1 at `far`.
    pub fn depth(&self, z: f64) -> f64 {
        (z - f64::from(self.near)) / (f64::from(self.far) - f64::from(self.near))
    }

    /// Texels in all.
    pub fn texels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The views of the translucent casters, one for each map of each light (a point light has one for each of
    /// [`super::FACES`]), fitted to them (to the meshes where there are none), `size` texels a side.
    pub fn volumes(scene: &Scene, size: u32) -> Vec<Self> {
        if scene.has_only_meshes() {
            fit_all(scene, &mesh_points(&scene.meshes).collect::<Vec<_>>(), size, Casting::Volume)
        } else {
            fit_all(scene, &caster_spheres(&scene.particles, &scene.strands).collect::<Vec<_>>(), size, Casting::Volume)
        }
    }

    /// The views of the meshes and of all that they may shadow, one for each map of each light.
    pub fn opaques(scene: &Scene, size: u32) -> Vec<Self> {
        let all = mesh_points(&scene.meshes).chain(caster_spheres(&scene.particles, &scene.strands));
        fit_all(scene, &all.collect::<Vec<_>>(), size, Casting::Opaque)
    }

    /// The camera's view.
    pub fn camera(camera: &Camera, scene: &Scene, size: [u32; 2]) -> Self {
        let forward = (camera.target - camera.position).normalize();
        let (right, up) = across(forward, camera.up);
        let far = mesh_points(&scene.meshes)
            .chain(caster_spheres(&scene.particles, &scene.strands))
            .map(|(p, radius)| (p - camera.position).dot(forward) + radius)
            .fold(1e-3, f64::max)
            * 1.01;
        let tangent = (camera.fov_y_degrees.to_radians() * 0.5).tan();
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        Self {
            origin: camera.position.as_vec3().into(),
            projection: Projection::Perspective as u32,
            right: right.as_vec3().into(),
            scale_x: (1.0 / (tangent * aspect)) as f32,
            up: up.as_vec3().into(),
            scale_y: (-1.0 / tangent) as f32,
            forward: forward.as_vec3().into(),
            near: (far * 1e-4) as f32,
            far: far as f32,
            width: size[0],
            height: size[1],
        }
    }
}

/// Spheres in whose hull all translucent casters lie.
pub(super) fn caster_spheres(particles: &[Particle], strands: &[Strand]) -> impl Iterator<Item = (DVec3, f64)> {
    let particles = particles.iter().map(|p| (vec(p.position), p.radius.into()));
    particles.chain(strands.iter().flat_map(|s| [s.start, s.end].map(|end| (vec(end), s.radius.into()))))
}

pub(super) fn mesh_points(meshes: &[Mesh]) -> impl Iterator<Item = (DVec3, f64)> {
    meshes.iter().flat_map(|m| m.positions.iter().map(|p| (vec(*p), 0.0)))
}

/// What a view is fitted to.
#[derive(Clone, Copy, PartialEq)]
enum Casting {
    Volume,
    Opaque,
}

impl Casting {
    /// A tenth more depth for the opaque map, so that its bias does not push the farthest surface out of range.
    fn more_depth(self) -> f64 {
        if self == Self::Opaque { 0.1 } else { 0.0 }
    }
}

/// A thousandth of a texel is enough against the rounding to f32.
const MARGIN: f64 = 1.0 + 1e-5;

/// Texels by which a point light's face of `size` texels reaches past its 90° on each side: room for the widest filter,
/// which reaches 8 texels, and one more for rounding. Small maps have less, and take narrower filters.
pub fn gutter_texels(size: u32) -> u32 {
    (size / 8).clamp(1, 9)
}

/// Tangent of half the angle that such a face covers; at most 2, also where a map is too small to have a gutter.
fn face_tangent(size: u32) -> f64 {
    let share = (f64::from(gutter_texels(size)) / f64::from(size)).min(0.25);
    1.0 / (1.0 - 2.0 * share)
}

/// The views of all maps of all lights that hold the spheres (centre, radius; a radius of 0 is a mesh's vertex). A
/// directional light is fitted in all three directions, a spot light keeps its cone and is fitted in depth.
fn fit_all(scene: &Scene, spheres: &[(DVec3, f64)], size: u32, casting: Casting) -> Vec<View> {
    let all = || spheres.iter().copied();
    let maps = |light: &Light| match light.kind {
        LightKind::Directional { direction } => vec![parallel(direction, all(), size, casting)],
        LightKind::Spot { position, direction, cone_degrees } => {
            let tangent = (cone_degrees.to_radians() * 0.5).tan();
            // Casters around the light itself are cut off at a thousandth of the range.
            vec![perspective(position, direction, tangent, all(), size, 1e-3, casting)]
        }
        LightKind::Point { position } => {
            FACES.map(|(_, forward)| face(position, forward, scene, spheres, size, casting)).to_vec()
        }
    };
    scene.lights.iter().flat_map(maps).collect()
}

/// The view of one face, fitted in depth to the spheres that it sees.
fn face(position: DVec3, forward: DVec3, scene: &Scene, spheres: &[(DVec3, f64)], size: u32, casting: Casting) -> View {
    let (right, up) = across(forward, some_up(forward));
    let tangent = face_tangent(size);
    let slope = (1.0 + tangent * tangent).sqrt();
    let sees = |&(p, radius): &(DVec3, f64)| {
        let offset = p - position;
        let z = offset.dot(forward);
        // Outside one of the pyramid's four planes. A triangle or a strand may cross a face that sees none of its ends.
        let outside = (offset.dot(right).abs().max(offset.dot(up).abs()) - tangent * z) / slope;
        radius == 0.0 || !scene.strands.is_empty() || (outside < radius && z + radius > 0.0)
    };
    let seen = spheres.iter().copied().filter(sees);
    // Nothing divides by the z of particles, so that those around the light count whole.
    let nearest = if casting == Casting::Opaque { 1e-3 } else { 0.0 };
    perspective(position, forward, tangent, seen, size, nearest, casting)
}

/// A view along parallel rays, fitted in all three directions.
fn parallel(direction: DVec3, spheres: impl Iterator<Item = (DVec3, f64)>, size: u32, casting: Casting) -> View {
    let (right, up) = across(direction, some_up(direction));
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (p, radius) in spheres {
        let p = DVec3::new(p.dot(right), p.dot(up), p.dot(direction));
        low = low.min(p - radius);
        high = high.max(p + radius);
    }
    if low.x > high.x {
        (low, high) = (DVec3::ZERO, DVec3::ONE);
    }
    let middle = (low + high) * 0.5;
    let half = ((high - low) * 0.5 * MARGIN).max(DVec3::splat(1e-6));
    let origin = right * middle.x + up * middle.y + direction * (middle.z - half.z);
    View {
        origin: origin.as_vec3().into(),
        projection: Projection::Parallel as u32,
        right: right.as_vec3().into(),
        scale_x: (1.0 / half.x) as f32,
        up: up.as_vec3().into(),
        scale_y: (1.0 / half.y) as f32,
        forward: direction.as_vec3().into(),
        near: 0.0,
        far: (2.0 * half.z * (1.0 + casting.more_depth())) as f32,
        width: size,
        height: size,
    }
}

/// A view from a point, fitted in depth. What lies nearer than `nearest` of the range is cut off.
fn perspective(
    position: DVec3,
    forward: DVec3,
    tangent: f64,
    spheres: impl Iterator<Item = (DVec3, f64)>,
    size: u32,
    nearest: f64,
    casting: Casting,
) -> View {
    let (right, up) = across(forward, some_up(forward));
    let (mut low, mut high) = (f64::INFINITY, 1e-3);
    for (p, radius) in spheres {
        let z = (p - position).dot(forward);
        low = low.min(z - radius);
        high = f64::max(high, z + radius);
    }
    let near = low.clamp(high * nearest, high * 0.999);
    let scale = (1.0 / tangent) as f32;
    View {
        origin: position.as_vec3().into(),
        projection: Projection::Perspective as u32,
        right: right.as_vec3().into(),
        scale_x: scale,
        up: up.as_vec3().into(),
        scale_y: scale,
        forward: forward.as_vec3().into(),
        near: near as f32,
        far: (near + (high - near) * MARGIN * (1.0 + casting.more_depth())) as f32,
        width: size,
        height: size,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A point light's point lies in the face that is asked for it, a gutter away from the face's edge: a filter that
        /// reaches as far needs no other face.
        #[test]
        fn points_lie_inside_the_face_that_is_asked(
            offset in prop::array::uniform3(-10.0f32..10.0),
            tie in 0usize..6,
            size in prop::sample::select(vec![4u32, 8, 12, 33, 72, 256]),
        ) {
            let light = [0.3f32, -1.1, 0.7];
            let mut offset = offset;
            // One in two with two coordinates equal, up to the rounding of the sum.
            if tie < 3 {
                offset[tie] = offset[(tie + 1) % 3];
            }
            prop_assume!(offset.iter().any(|c| c.abs() > 0.01));
            let position = [0, 1, 2].map(|i| light[i] + offset[i]);
            let kind = LightKind::Point { position: vec(light) };
            let sphere = super::super::Particle { position: light, radius: 1.0, extinction: 1.0 };
            let camera = Camera { position: DVec3::X, target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 40.0 };
            let lights = vec![Light { kind, radiance: [1.0; 3] }];
            let scene = Scene { name: String::new(), particles: vec![sphere], strands: vec![], meshes: vec![], lights, camera };
            let view = View::volumes(&scene, size)[scene.lights[0].map_at(position)];
            let (texel, z) = view.project(vec(position));
            let (gutter, size) = (f64::from(gutter_texels(size)), f64::from(size));
            prop_assert!(z > 0.0);
            let inside = gutter - 1e-3..=size - gutter + 1e-3;
            prop_assert!(inside.contains(&texel.x) && inside.contains(&texel.y), "{texel} of {size}");
        }
    }
}
