//! Lights, and which of its maps a light is looked up through. Twin: glsl/world/light.glsl.

use glam::{DVec3, Vec3};

/// Where a light stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel rays.
    Directional {
        /// The way the light travels, unit length.
        direction: DVec3,
    },
    /// A cone.
    Spot {
        /// World units.
        position: DVec3,
        /// The axis, unit length.
        direction: DVec3,
        /// Full opening angle, degrees, in (0, 170].
        cone_degrees: f64,
    },
    /// The same in all directions.
    Point {
        /// World units.
        position: DVec3,
    },
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where it stands.
    pub kind: LightKind,
    /// Radiance scale, linear RGB; 1 lights a white surface fully, at any distance.
    pub radiance: [f32; 3],
}

/// The maps of a point light, in order: name and direction of the faces of the cube around it.
///
/// A cube and not an octahedron: a face is an ordinary perspective view, in which spheres have exact segments and tight
/// bounds, while an octahedral map bends rays' footprints and with them every bound.
pub const FACES: [(&str, DVec3); 6] = [
    ("+x", DVec3::X),
    ("-x", DVec3::NEG_X),
    ("+y", DVec3::Y),
    ("-y", DVec3::NEG_Y),
    ("+z", DVec3::Z),
    ("-z", DVec3::NEG_Z),
];

impl Light {
    /// Maps that the light is looked up through: [`FACES`] for a point light, else one.
    pub fn map_count(&self) -> usize {
        if matches!(self.kind, LightKind::Point { .. }) { FACES.len() } else { 1 }
    }

    /// Which of its maps answers for a position: a function of the position alone, the same in f32 here as on the device.
    /// Twin: light_map.
    pub fn map_at(&self, position: [f32; 3]) -> usize {
        let LightKind::Point { position: light } = self.kind else { return 0 };
        let offset = Vec3::from(position) - light.as_vec3();
        let far = offset.abs();
        let axis = if far.x >= far.y && far.x >= far.z {
            0
        } else if far.y >= far.z {
            1
        } else {
            2
        };
        2 * axis + usize::from(offset[axis] < 0.0)
    }

    /// The direction towards the light from `position`, unit length; 0 at the light.
    pub fn towards(&self, position: DVec3) -> DVec3 {
        match self.kind {
            LightKind::Directional { direction } => -direction,
            LightKind::Spot { position: light, .. } | LightKind::Point { position: light } => {
                (light - position).normalize_or_zero()
            }
        }
    }

    /// Whether the light sends anything towards `position` if nothing stands between.
    pub fn shines_on(&self, position: DVec3) -> bool {
        match self.kind {
            LightKind::Directional { .. } | LightKind::Point { .. } => true,
            LightKind::Spot { direction, cone_degrees, .. } => {
                -self.towards(position).dot(direction) >= (cone_degrees.to_radians() * 0.5).cos()
            }
        }
    }
}
