//! How a light or a camera sees the world. Twin: glsl/common/view.glsl.

use super::{Camera, Light, LightKind, Mesh, Particle, Scene};
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};

/// Parallel rays or rays from one point.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// A directional light.
    Parallel = 0,
    /// A spot light or a camera.
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

    /// The light's view of the translucent casters, fitted to them (to the meshes where there are none), `size` texels
    /// a side.
    pub fn volume(scene: &Scene, size: u32) -> Self {
        let particles = scene.particles.iter().map(sphere);
        if scene.particles.is_empty() {
            fit(&scene.light, mesh_points(&scene.meshes), size, 0.0)
        } else {
            fit(&scene.light, particles, size, 0.0)
        }
    }

    /// The light's view of the meshes and of all that they may shadow. A tenth more depth than that, so that the map's
    /// bias does not push the farthest surface out of range.
    pub fn opaque(scene: &Scene, size: u32) -> Self {
        fit(&scene.light, mesh_points(&scene.meshes).chain(scene.particles.iter().map(sphere)), size, 0.1)
    }

    /// The camera's view.
    pub fn camera(camera: &Camera, scene: &Scene, size: [u32; 2]) -> Self {
        let forward = (camera.target - camera.position).normalize();
        let (right, up) = across(forward, camera.up);
        let far = mesh_points(&scene.meshes)
            .chain(scene.particles.iter().map(sphere))
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

fn sphere(p: &Particle) -> (DVec3, f64) {
    (vec(p.position), p.radius.into())
}

fn mesh_points(meshes: &[Mesh]) -> impl Iterator<Item = (DVec3, f64)> {
    meshes.iter().flat_map(|m| m.positions.iter().map(|p| (vec(*p), 0.0)))
}

/// A view that holds all spheres (centre, radius). A directional light is fitted in all three directions; a spot light
/// keeps its cone and is fitted in depth.
fn fit(light: &Light, spheres: impl Iterator<Item = (DVec3, f64)>, size: u32, more_depth: f64) -> View {
    // A thousandth of a texel is enough against the rounding to f32.
    const MARGIN: f64 = 1.0 + 1e-5;
    match light.kind {
        LightKind::Directional { direction } => {
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
                far: (2.0 * half.z * (1.0 + more_depth)) as f32,
                width: size,
                height: size,
            }
        }
        LightKind::Spot { position, direction, cone_degrees } => {
            let (right, up) = across(direction, some_up(direction));
            let (mut low, mut high) = (f64::INFINITY, 1e-3);
            for (p, radius) in spheres {
                let z = (p - position).dot(direction);
                low = low.min(z - radius);
                high = f64::max(high, z + radius);
            }
            // Casters around the light itself are cut off at a thousandth of the range.
            let near = low.clamp(high * 1e-3, high * 0.999);
            let scale = (1.0 / (cone_degrees.to_radians() * 0.5).tan()) as f32;
            View {
                origin: position.as_vec3().into(),
                projection: Projection::Perspective as u32,
                right: right.as_vec3().into(),
                scale_x: scale,
                up: up.as_vec3().into(),
                scale_y: scale,
                forward: direction.as_vec3().into(),
                near: near as f32,
                far: (near + (high - near) * MARGIN * (1.0 + more_depth)) as f32,
                width: size,
                height: size,
            }
        }
    }
}
