//! Lights in the shaders' layout.

use crate::scene::{Light, LightKind, Scene};
use bytemuck::{Pod, Zeroable};

/// Twin: Light in glsl/world/light.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LightData {
    /// Position, in world units; 0 for a directional light.
    pub position: [f32; 3],
    /// Kind: 0 directional, 1 spot, 2 point, 3 virtual.
    pub kind: u32,
    /// Direction in which a directional light shines, axis of a spot light, or normal of a virtual light; 0 for a point light.
    pub direction: [f32; 3],
    /// Cosine of half the opening angle of a spot light, 0 for a virtual light, −2 for directional and point lights.
    pub cos_cone: f32,
    /// Radiance, linear RGB.
    pub radiance: [f32; 3],
    /// 1 / radius², or 0 for a light of infinite range; for a virtual light 1 / nearest².
    pub falloff: f32,
    /// Index of the light's first map among the maps of all lights.
    pub first_map: u32,
    /// Number of maps: 6 for a point or a virtual light, otherwise 1.
    pub map_count: u32,
    /// 1 if meshes cast shadows.
    pub has_opaque: u32,
}

impl LightData {
    /// Returns the data of all lights of `scene`.
    pub fn all(scene: &Scene) -> Vec<Self> {
        Self::of(&scene.lights, scene.has_triangles())
    }

    /// Returns the data of `lights`; `has_opaque` is whether meshes cast shadows.
    pub fn of(lights: &[Light], has_opaque: bool) -> Vec<Self> {
        let mut first_map = 0;
        let data = |light: &Light| {
            let first = first_map;
            first_map += light.map_count();
            let ends = 1.0 / (light.radius * light.radius);
            let (kind, direction, cos_cone, falloff) = match light.kind {
                LightKind::Directional { direction } => (0, direction, -2.0, 0.0),
                LightKind::Spot { direction, cone_degrees, .. } => {
                    (1, direction, (cone_degrees.to_radians() * 0.5).cos(), ends)
                }
                LightKind::Point { .. } => (2, glam::DVec3::ZERO, -2.0, ends),
                LightKind::Virtual { normal, nearest, .. } => (3, normal, 0.0, 1.0 / (nearest * nearest)),
            };
            Self {
                position: light.position().unwrap_or_default().as_vec3().into(),
                kind,
                direction: direction.as_vec3().into(),
                cos_cone: cos_cone as f32,
                radiance: light.radiance,
                falloff: falloff as f32,
                first_map: first as u32,
                map_count: light.map_count() as u32,
                has_opaque: u32::from(has_opaque),
            }
        };
        lights.iter().map(data).collect()
    }
}
