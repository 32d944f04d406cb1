//! How a light or a camera sees the world. Twin: glsl/world/view.glsl.

use super::sheet::sheets;
use crate::scene::model::fit::{Aim, aimed, fit_all};
use crate::scene::{Camera, Caster, Casting, FACES, Mesh, Particle, Scene, Splat, Strand, Volume};
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};

/// A depth or z farther than any other, used for unused nodes and for rays that no mesh blocks. Twins: FARTHEST in glsl/world/view.glsl,
/// EMPTY in glsl/maps/curve/node.glsl.
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

/// A view, in the shaders' layout. Numbers are rounded to f32 once, here, so that the f64 reference and the device use the same rays. `z`
/// is the distance along `forward`, in world units.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct View {
    /// Origin, in world units.
    pub origin: [f32; 3],
    /// A [`Projection`] as a number.
    pub projection: u32,
    /// Right axis, unit length.
    pub right: [f32; 3],
    /// NDC per world unit (parallel) or per unit of tangent (perspective).
    pub scale_x: f32,
    /// Up axis, unit length.
    pub up: [f32; 3],
    /// Vertical counterpart of `scale_x`; negative for cameras, since NDC y points down.
    pub scale_y: f32,
    /// View direction, unit length.
    pub forward: [f32; 3],
    /// z at depth 0.
    pub near: f32,
    /// z at depth 1.
    pub far: f32,
    /// Width, in texels.
    pub width: u32,
    /// Height, in texels.
    pub height: u32,
}

/// A ray whose parameter is z, in f64: point = origin + z · direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin, in world units.
    pub origin: DVec3,
    /// Direction: of length 1 in parallel views, ≥ 1 in perspective ones.
    pub direction: DVec3,
}

impl Ray {
    /// Returns the point at `z`.
    pub fn at(&self, z: f64) -> DVec3 {
        self.origin + z * self.direction
    }
}

pub(in crate::scene) fn vec(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// Returns two unit vectors, right and up, perpendicular to `forward` and to each other.
pub(in crate::scene) fn across(forward: DVec3, up: DVec3) -> (DVec3, DVec3) {
    let right = forward.cross(up).normalize();
    (right, right.cross(forward))
}

/// Returns an up vector that is not parallel to `forward`.
pub(in crate::scene) fn some_up(forward: DVec3) -> DVec3 {
    if forward.z.abs() < 0.99 { DVec3::Z } else { DVec3::Y }
}

impl View {
    /// Returns the kind of projection.
    pub fn projection(&self) -> Projection {
        if self.projection == Projection::Parallel as u32 { Projection::Parallel } else { Projection::Perspective }
    }

    /// Returns the texel coordinates (centres at .5) and z of a point. Behind a perspective view the coordinates are meaningless.
    pub fn project(&self, position: DVec3) -> (DVec2, f64) {
        self.project_offset(position - vec(self.origin))
    }

    /// Like [`View::project`], but for a point given by its offset from the view's origin, in world units.
    pub fn project_offset(&self, offset: DVec3) -> (DVec2, f64) {
        let z = offset.dot(vec(self.forward));
        let w = if self.projection() == Projection::Parallel { 1.0 } else { z };
        let ndc = DVec2::new(
            offset.dot(vec(self.right)) * f64::from(self.scale_x),
            offset.dot(vec(self.up)) * f64::from(self.scale_y),
        ) / w;
        ((ndc * 0.5 + 0.5) * DVec2::new(self.width.into(), self.height.into()), z)
    }

    /// Returns a point's coordinates along right, up and forward, relative to the view's origin, in world units.
    pub fn axes(&self, position: DVec3) -> DVec3 {
        let offset = position - vec(self.origin);
        DVec3::new(offset.dot(vec(self.right)), offset.dot(vec(self.up)), offset.dot(vec(self.forward)))
    }

    /// Returns the ray through a point given in texels.
    pub fn ray(&self, texel: DVec2) -> Ray {
        let ndc = texel / DVec2::new(self.width.into(), self.height.into()) * 2.0 - 1.0;
        let across =
            vec(self.right) * (ndc.x / f64::from(self.scale_x)) + vec(self.up) * (ndc.y / f64::from(self.scale_y));
        match self.projection() {
            Projection::Parallel => Ray { origin: vec(self.origin) + across, direction: vec(self.forward) },
            Projection::Perspective => Ray { origin: vec(self.origin), direction: vec(self.forward) + across },
        }
    }

    /// Returns the steps to the next texel right and up at `position`, in world units. In perspective, `position` must be in front of the
    /// view.
    pub fn texel_at(&self, position: DVec3) -> [DVec3; 2] {
        let spread = if self.projection() == Projection::Parallel { 1.0 } else { self.axes(position).z };
        let texel =
            |axis: [f32; 3], scale: f32, count: u32| vec(axis) * (2.0 * spread / (f64::from(scale) * f64::from(count)));
        [texel(self.right, self.scale_x, self.width), texel(self.up, self.scale_y, self.height)]
    }

    /// Returns the view's ray through `position`.
    pub fn ray_through(&self, position: DVec3) -> Ray {
        let offset = position - vec(self.origin);
        let z = offset.dot(vec(self.forward));
        match self.projection() {
            Projection::Parallel => Ray { origin: position - z * vec(self.forward), direction: vec(self.forward) },
            Projection::Perspective => Ray { origin: vec(self.origin), direction: offset / z },
        }
    }

    /// Returns the face that contains `position`, for a view that is one of a light's six faces.
    pub fn face_towards(&self, position: DVec3) -> Self {
        let offset = position - vec(self.origin);
        let axis = offset.abs().max_position();
        let (_, forward) = FACES[2 * axis + usize::from(offset[axis] < 0.0)];
        let (right, up) = across(forward, some_up(forward));
        let [right, up, forward] = [right, up, forward].map(|axis| axis.as_vec3().into());
        Self { right, up, forward, ..*self }
    }

    /// Returns the z of a depth in [0, 1].
    pub fn z(&self, depth: f64) -> f64 {
        f64::from(self.near) + depth * (f64::from(self.far) - f64::from(self.near))
    }

    /// Returns the depth of a z: 0 at `near`, 1 at `far`.
    pub fn depth(&self, z: f64) -> f64 {
        (z - f64::from(self.near)) / (f64::from(self.far) - f64::from(self.near))
    }

    /// Returns the total number of texels.
    pub fn texels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Returns the views of all maps of all lights before fitting, `size` texels per side. A point light has one view for each of
    /// [`crate::scene::FACES`]. These views have an origin and axes, and in perspective a scale. A directional light's origin is a position
    /// among the casters of `casting`, or a corner of their box if they are simulated, so that distances from it are small. `near` is the
    /// smallest fraction of the range at which the fitted view may begin. `far` is the range of the fitted view, relative to the range that
    /// the casters need.
    pub fn aimed(aim: &Aim, size: u32, casting: Casting) -> Vec<Self> {
        aimed(aim, size, casting)
    }

    /// Returns the views of all maps of all lights, fitted to the translucent casters, or to the meshes if there are none, `size` texels
    /// per side. They are computed in f64 and serve as the truth for the views that the device fits.
    pub fn volumes(scene: &Scene, size: u32) -> Vec<Self> {
        fit_all(scene, size, Casting::Volume)
    }

    /// Returns the views fitted to the meshes, one for each map of each light, `size` texels per side.
    pub fn opaques(scene: &Scene, size: u32) -> Vec<Self> {
        fit_all(scene, size, Casting::Opaque)
    }

    /// Returns the camera's view of a scene; its far plane is behind everything in the scene.
    pub fn camera(camera: &Camera, scene: &Scene, size: [u32; 2]) -> Self {
        let forward = (camera.target - camera.position).normalize();
        let far = mesh_points(&scene.meshes)
            .chain(lasting_spheres(scene))
            .map(|(p, radius)| (p - camera.position).dot(forward) + radius)
            .fold(1e-3, f64::max)
            * 1.01;
        Self::perspective(camera, [far * 1e-4, far], size)
    }

    /// Returns the camera's view between two distances along its axis, near and far, `size` pixels wide and high.
    pub fn perspective(camera: &Camera, [near, far]: [f64; 2], size: [u32; 2]) -> Self {
        let forward = (camera.target - camera.position).normalize();
        let (right, up) = across(forward, camera.up);
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
            near: near as f32,
            far: far as f32,
            width: size[0],
            height: size[1],
        }
    }
}

/// Returns spheres whose convex hull contains all translucent casters.
pub(in crate::scene) fn caster_spheres(
    particles: &[Particle],
    strands: &[Strand],
    splats: &[Splat],
    volumes: &[Volume],
    meshes: &[Mesh],
) -> impl Iterator<Item = (DVec3, f64)> {
    let particles = particles.iter().map(|p| (vec(p.position), p.radius.into()));
    let strands = strands.iter().flat_map(|s| [s.start, s.end].map(|end| (vec(end), s.radius.into())));
    let splats = splats.iter().map(|g| (vec(g.position), f64::from(Caster::from(g).radius)));
    let cells = volumes.iter().flat_map(Volume::cells).map(|cell| (vec(cell.position), cell.radius.into()));
    let sheets = sheets(meshes).map(|sheet| (vec(sheet.position), sheet.radius.into()));
    particles.chain(strands).chain(splats).chain(sheets).chain(cells)
}

/// Returns spheres whose convex hull contains all translucent casters at this and all later times. Particles moved by passes on the device
/// stay in a box.
pub(in crate::scene) fn lasting_spheres(scene: &Scene) -> Box<dyn Iterator<Item = (DVec3, f64)> + '_> {
    let others = |particles| caster_spheres(particles, &scene.strands, &scene.splats, &scene.volumes, &scene.meshes);
    match scene.reserve.stay_in {
        Some(all) => Box::new(all.corners().chain(others(&[]))),
        None => Box::new(others(&scene.particles)),
    }
}

pub(in crate::scene) fn mesh_points(meshes: &[Mesh]) -> impl Iterator<Item = (DVec3, f64)> {
    meshes.iter().flat_map(|m| m.positions.iter().map(|p| (vec(*p), 0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Light, LightKind, gutter_texels};
    use proptest::prelude::*;

    proptest! {
        /// A point lies in the point light's face that look-ups use, at least a gutter away from the face's edge, so that a filter of that
        /// radius needs no other face.
        #[test]
        fn points_lie_inside_the_face_that_is_asked(
            offset in prop::array::uniform3(-10.0f32..10.0),
            tie in 0usize..6,
            size in prop::sample::select(vec![4u32, 8, 12, 33, 72, 256]),
        ) {
            let light = [0.3f32, -1.1, 0.7];
            let mut offset = offset;
            // In half of the cases, two coordinates are equal up to rounding.
            if tie < 3 {
                offset[tie] = offset[(tie + 1) % 3];
            }
            prop_assume!(offset.iter().any(|c| c.abs() > 0.01));
            let position = [0, 1, 2].map(|i| light[i] + offset[i]);
            let kind = LightKind::Point { position: vec(light) };
            let sphere = crate::scene::Particle { position: light, radius: 1.0, extinction: 1.0 };
            let camera = Camera { position: DVec3::X, target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 40.0 };
            let lights = vec![Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }];
            let scene = Scene { particles: vec![sphere], lights, camera, ..Scene::default() };
            let view = View::volumes(&scene, size)[scene.lights[0].map_at(position)];
            let (texel, z) = view.project(vec(position));
            let (gutter, size) = (f64::from(gutter_texels(size)), f64::from(size));
            prop_assert!(z > 0.0);
            let inside = gutter - 1e-3..=size - gutter + 1e-3;
            prop_assert!(inside.contains(&texel.x) && inside.contains(&texel.y), "{texel} of {size}");
        }
    }
}
