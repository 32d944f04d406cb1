//! Lights, and which of a light's maps a look-up uses. Twin: glsl/world/light.glsl.

use glam::{DVec3, Vec3};

/// Kind and place of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel rays.
    Directional {
        /// The direction in which the light travels, unit length.
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
    /// Shines equally in all directions.
    Point {
        /// World units.
        position: DVec3,
    },
    /// A virtual point light (Keller 1997), which stands for a patch of a lit surface. It shines into the half space of its normal, by the
    /// cosine law and the inverse square of the distance.
    Virtual {
        /// World units.
        position: DVec3,
        /// The surface's normal, unit length, on the side that shines.
        normal: DVec3,
        /// World units. Points nearer than this distance get the light of a point at this distance. The light's 1/d² grows without bound
        /// near it, while the light of the patch that it stands for does not.
        nearest: f64,
    },
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Kind and place.
    pub kind: LightKind,
    /// Radiance scale, linear RGB; 1 lights a white surface fully, near the light. For a virtual light, the radiance that
    /// leaves its patch, times the patch's area in square world units, over π.
    pub radiance: [f32; 3],
    /// The distance at which a spot or point light ends, world units; infinite where its light does not fall off.
    pub radius: f64,
}

/// The maps of a point light, in order: for each face of the cube around the light, its name and its direction.
///
/// The maps form a cube and not an octahedron, since a face of a cube is an ordinary perspective view. In such a view spheres have exact
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
    /// The number of the light's maps: one per face of [`FACES`] for a point light, else one.
    pub fn map_count(&self) -> usize {
        match self.kind {
            LightKind::Directional { .. } | LightKind::Spot { .. } => 1,
            LightKind::Point { .. } | LightKind::Virtual { .. } => FACES.len(),
        }
    }

    /// The light's place; none for a directional light.
    pub fn position(&self) -> Option<DVec3> {
        match self.kind {
            LightKind::Directional { .. } => None,
            LightKind::Spot { position, .. } | LightKind::Point { position } | LightKind::Virtual { position, .. } => {
                Some(position)
            }
        }
    }

    /// The map that a look-up at a position uses: a function of the position alone, in f32 the same here as on the device. Twin: light_map.
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

    /// The direction towards the light from `position`, unit length; 0 at the light.
    pub fn towards(&self, position: DVec3) -> DVec3 {
        match self.kind {
            LightKind::Directional { direction } => -direction,
            LightKind::Spot { position: light, .. }
            | LightKind::Point { position: light }
            | LightKind::Virtual { position: light, .. } => (light - position).normalize_or_zero(),
        }
    }

    /// Attenuation of the radiance at `position`: 1 at the light, smoothly down to 0 at its radius; for a virtual light, by distance and
    /// cosine. Twin: light_falloff.
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

    /// Whether the light sends anything towards `position` if nothing stands between.
    pub fn shines_on(&self, position: DVec3) -> bool {
        self.falloff(position) > 0.0 && self.opens_towards(position)
    }

    /// Whether `position` is not outside the cone of a spot light.
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

    /// A virtual light falls off by the cosine law and the inverse square, bounded near the light, and is 0 behind its surface.
    #[test]
    fn a_virtual_light_is_a_patch() {
        let kind = LightKind::Virtual { position: DVec3::X, normal: DVec3::Z, nearest: 0.5 };
        let light = Light { kind, radiance: [1.0; 3], radius: f64::INFINITY };
        let at = |offset: DVec3| light.falloff(DVec3::X + offset);
        assert_eq!((at(2.0 * DVec3::Z), at(0.25 * DVec3::Z), at(-DVec3::Z)), (0.25, 4.0, 0.0));
        assert!((at(DVec3::new(0.0, 3.0, 3.0)) - 0.5_f64.sqrt() / 18.0).abs() < 1e-15);
        assert_eq!((light.falloff(DVec3::X), light.shines_on(DVec3::X - DVec3::Z)), (0.0, false));
    }

    /// All light at the lamp, 9/16 of it half way to its radius, none at the radius and beyond.
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
