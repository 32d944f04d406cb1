//! A scene as the shaders have it.

use crate::Result;
use crate::gpu::{Buffer, Context};
use crate::scene::{LightKind, Scene, View};
use bytemuck::{Pod, Zeroable};

/// Twin: Light in glsl/common/light.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LightData {
    /// The light's view of the translucent casters.
    pub volume: View,
    /// The light's view of the meshes and all they may shadow.
    pub opaque: View,
    /// Linear RGB.
    pub radiance: [f32; 3],
    /// 1 where meshes cast.
    pub has_opaque: u32,
    /// Cosine of half the cone of a spot light, −2 for a directional light.
    pub cos_cone: f32,
}

/// Twin: Triangle in glsl/common/triangle.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TriangleData {
    /// World units.
    pub corners: [[f32; 3]; 3],
    /// Diffuse reflectance.
    pub albedo: [f32; 3],
}

/// Texels a side of the opaque map where there are meshes.
pub const OPAQUE_SIZE: u32 = 1024;

impl LightData {
    /// The light of `scene` with a volume map of `size` texels a side.
    pub fn new(scene: &Scene, size: u32) -> Self {
        let has_opaque = !scene.meshes.is_empty();
        Self {
            volume: View::volume(scene, size),
            opaque: View::opaque(scene, if has_opaque { OPAQUE_SIZE } else { 1 }),
            radiance: scene.light.radiance,
            has_opaque: has_opaque.into(),
            cos_cone: match scene.light.kind {
                LightKind::Directional { .. } => -2.0,
                LightKind::Spot { cone_degrees, .. } => (cone_degrees.to_radians() * 0.5).cos() as f32,
            },
        }
    }
}

/// The casters on the device. All techniques of a scene share it.
pub struct SceneData {
    /// Twin: Particle[] in glsl/common/particle.glsl.
    pub particles: Buffer,
    /// How many.
    pub particle_count: u32,
    /// [`TriangleData`].
    pub triangles: Buffer,
    /// How many.
    pub triangle_count: u32,
}

impl SceneData {
    /// Uploads the casters of `scene`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &Scene) -> Result<Self> {
        let corner = |positions: &[[f32; 3]], i: u32| positions.get(i as usize).copied().unwrap_or_default();
        let triangles: Vec<_> = scene
            .meshes
            .iter()
            .flat_map(|m| {
                m.triangles
                    .iter()
                    .map(|t| TriangleData { corners: t.map(|i| corner(&m.positions, i)), albedo: m.albedo })
            })
            .collect();
        Ok(Self {
            particles: Buffer::with_data(context, "scene.particles", &scene.particles)?,
            particle_count: scene.particles.len() as u32,
            triangles: Buffer::with_data(context, "scene.triangles", &triangles)?,
            triangle_count: triangles.len() as u32,
        })
    }
}
