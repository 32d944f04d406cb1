//! Lights as the shaders have them.

use crate::scene::{Light, LightKind, Scene};
use bytemuck::{Pod, Zeroable};

/// Twin: Light in glsl/world/light.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LightData {
    /// World units; of a spot or a point light.
    pub position: [f32; 3],
    /// 0 directional, 1 spot, 2 point.
    pub kind: u32,
    /// The way a directional light travels, the axis of a spot light; 0 for a point light.
    pub direction: [f32; 3],
    /// Cosine of half the cone of a spot light, −2 for the others.
    pub cos_cone: f32,
    /// Linear RGB.
    pub radiance: [f32; 3],
    /// 1 / radius², 0 for a light that does not end.
    pub falloff: f32,
    /// Its first map among the maps of all lights.
    pub first_map: u32,
    /// 6 for a point light, else 1.
    pub map_count: u32,
    /// 1 where meshes cast.
    pub has_opaque: u32,
}

impl LightData {
    /// The lights of `scene`.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let data = |(i, light): (usize, &Light)| {
            let (kind, position, direction, cos_cone) = match light.kind {
                LightKind::Directional { direction } => (0, glam::DVec3::ZERO, direction, -2.0),
                LightKind::Spot { position, direction, cone_degrees } => {
                    (1, position, direction, (cone_degrees.to_radians() * 0.5).cos())
                }
                LightKind::Point { position } => (2, position, glam::DVec3::ZERO, -2.0),
            };
            Self {
                position: position.as_vec3().into(),
                kind,
                direction: direction.as_vec3().into(),
                cos_cone: cos_cone as f32,
                radiance: light.radiance,
                falloff: if kind == 0 { 0.0 } else { (1.0 / (light.radius * light.radius)) as f32 },
                first_map: scene.first_map(i) as u32,
                map_count: light.map_count() as u32,
                has_opaque: u32::from(scene.has_triangles()),
            }
        };
        scene.lights.iter().enumerate().map(data).collect()
    }
}
