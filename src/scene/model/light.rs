//! Lights, and the choice of the light's map for a look-up. Twin: glsl/world/light.glsl.

use glam::{DVec3, Vec3};

/// Kind and position of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel rays.
    Directional {
        /// Direction in which the light shines, unit length.
        direction: DVec3,
    },
    /// A cone.
    Spot {
        /// Position, in world units.
        position: DVec3,
        /// The cone's axis, unit length.
        direction: DVec3,
        /// Full opening angle in degrees, in (0, 170].
        cone_degrees: f64,
    },
    /// Shines equally in all directions.
    Point {
        /// Position, in world units.
        position: DVec3,
    },
    /// A virtual point light (Keller 1997), which represents a patch of a lit surface. It shines into the half space of its normal,
    /// following the cosine law and the inverse square of the distance.
    Virtual {
        /// Position, in world units.
        position: DVec3,
        /// The surface's normal, unit length, on the lit side.
        normal: DVec3,
        /// Distance in world units below which the light no longer increases. The light's 1/d² grows without bound near it, while the light
        /// of the patch it represents does not.
        nearest: f64,
    },
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Kind and position.
    pub kind: LightKind,
    /// Radiance scale, linear RGB; 1 fully lights a white surface near the light. For a virtual light, the radiance leaving its patch,
    /// times the patch's area in square world units, over π.
    pub radiance: [f32; 3],
    /// The distance at which a spot or point light ends, in world units; infinite if its light does not fall off.
    pub radius: f64,
}

/// The maps of a point light, in order: name and direction of each face of the cube around the light.
///
/// The maps form a cube rather than an octahedron, because a cube face is an ordinary perspective view, in which spheres have exact
/// segments and tight bounds. An octahedral map would bend the footprints of rays, and all bounds with them.
pub const FACES: [(&str, DVec3); 6] = [
    ("+x", DVec3::X),
    ("-x", DVec3::NEG_X),
    ("+y", DVec3::Y),
    ("-y", DVec3::NEG_Y),
    ("+z", DVec3::Z),
    ("-z", DVec3::NEG_Z),
];

impl Light {
    /// Returns the number of the light's maps: one per face of [`FACES`] for a point light, otherwise one.
    pub fn map_count(&self) -> usize {
        match self.kind {
            LightKind::Directional { .. } | LightKind::Spot { .. } => 1,
            LightKind::Point { .. } | LightKind::Virtual { .. } => FACES.len(),
        }
    }

    /// Returns the light's position; None for a directional light.
    pub fn position(&self) -> Option<DVec3> {
        match self.kind {
            LightKind::Directional { .. } => None,
            LightKind::Spot { position, .. } | LightKind::Point { position } | LightKind::Virtual { position, .. } => {
                Some(position)
            }
        }
    }

    /// Returns the map that a look-up at a position uses. It depends on the position alone, computed in f32 with the same result as on the
    /// device. Twin: light_map.
    pub fn map_at(&self, position: [f32; 3]) -> usize {
        let (LightKind::Point { position: light } | LightKind::Virtual { position: light, .. }) = self.kind else {
            return 0;
        };
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

    /// Returns the direction towards the light from `position`, unit length; 0 at the light.
    pub fn towards(&self, position: DVec3) -> DVec3 {
        match self.kind {
            LightKind::Directional { direction } => -direction,
            LightKind::Spot { position: light, .. }
            | LightKind::Point { position: light }
            | LightKind::Virtual { position: light, .. } => (light - position).normalize_or_zero(),
        }
    }

    /// Returns the attenuation of the radiance at `position`: 1 at the light, smoothly down to 0 at its radius; for a virtual light, by
    /// distance and cosine. Twin: light_falloff.
    pub fn falloff(&self, position: DVec3) -> f64 {
        match self.kind {
            LightKind::Directional { .. } => 1.0,
            LightKind::Spot { position: light, .. } | LightKind::Point { position: light } => {
                (1.0 - light.distance_squared(position) / (self.radius * self.radius)).max(0.0).powi(2)
            }
            LightKind::Virtual { position: light, normal, nearest } => {
                let cosine = -self.towards(position).dot(normal);
                cosine.max(0.0) / light.distance_squared(position).max(nearest * nearest)
            }
        }
    }

    /// Returns whether the light sends anything towards `position` if nothing is in between.
    pub fn shines_on(&self, position: DVec3) -> bool {
        self.falloff(position) > 0.0 && self.opens_towards(position)
    }

    /// Returns whether `position` is inside the cone of a spot light; true for other lights.
    fn opens_towards(&self, position: DVec3) -> bool {
        match self.kind {
            // For a virtual light, [`Light::falloff`] is already 0 behind its plane.
            LightKind::Directional { .. } | LightKind::Point { .. } | LightKind::Virtual { .. } => true,
            LightKind::Spot { direction, cone_degrees, .. } => {
                -self.towards(position).dot(direction) >= (cone_degrees.to_radians() * 0.5).cos()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A virtual light falls off by the cosine law and the inverse square, is bounded near the light, and is 0 behind its surface.
    #[test]
    fn a_virtual_light_is_a_patch() {
        let kind = LightKind::Virtual { position: DVec3::X, normal: DVec3::Z, nearest: 0.5 };
        let light = Light { kind, radiance: [1.0; 3], radius: f64::INFINITY };
        let at = |offset: DVec3| light.falloff(DVec3::X + offset);
        assert_eq!((at(2.0 * DVec3::Z), at(0.25 * DVec3::Z), at(-DVec3::Z)), (0.25, 4.0, 0.0));
        assert!((at(DVec3::new(0.0, 3.0, 3.0)) - 0.5_f64.sqrt() / 18.0).abs() < 1e-15);
        assert_eq!((light.falloff(DVec3::X), light.shines_on(DVec3::X - DVec3::Z)), (0.0, false));
    }

    /// The falloff is 1 at the lamp, 9/16 halfway to its radius, and 0 at the radius and beyond.
    #[test]
    fn a_light_ends_at_its_radius() {
        let mut light = Light { kind: LightKind::Point { position: DVec3::X }, radiance: [1.0; 3], radius: 2.0 };
        let at = |light: &Light, x: f64| (light.falloff(x * DVec3::X), light.shines_on(x * DVec3::X));
        assert_eq!(
            [1.0, 2.0, 3.0, 9.0].map(|x| at(&light, x)),
            [(1.0, true), (0.5625, true), (0.0, false), (0.0, false)]
        );
        light.radius = f64::INFINITY;
        assert_eq!(at(&light, 1e9), (1.0, true));
        light.kind = LightKind::Directional { direction: DVec3::X };
        light.radius = 1.0;
        assert_eq!(at(&light, 1e9), (1.0, true));
    }
}
