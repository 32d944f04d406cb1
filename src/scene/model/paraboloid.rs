//! The paraboloid map of `ism`, over the half space that a virtual light shines into. Source: Brabec, Annen and Seidel 2002.
//! Twin: glsl/technique/ism/map.glsl.

use crate::scene::model::view::vec;
use crate::scene::{Projection, View};
use glam::{DQuat, DVec3};

impl View {
    /// Returns a view with the axes of a paraboloid map, for a light at `position` that shines along `normal`, with `size` texels per side.
    /// The view matches the map only near the direction of the normal; for other directions use [`View::about`].
    pub fn paraboloid(position: DVec3, normal: DVec3, size: u32) -> Self {
        let forward = normal.as_vec3().as_dvec3();
        // Source: Duff et al. 2017. Twin: axes_of.
        let side = if forward.z >= 0.0 { 1.0 } else { -1.0 };
        let (a, b) = (-1.0 / (side + forward.z), -forward.x * forward.y / (side + forward.z));
        let right = DVec3::new(1.0 + side * forward.x * forward.x * a, side * b, -side * forward.x);
        let up = DVec3::new(b, side + forward.y * forward.y * a, -forward.y);
        Self {
            origin: position.as_vec3().into(),
            projection: Projection::Perspective as u32,
            right: right.as_vec3().into(),
            scale_x: 0.5,
            up: up.as_vec3().into(),
            scale_y: 0.5,
            forward: forward.as_vec3().into(),
            near: 0.0,
            far: 1.0,
            width: size,
            height: size,
        }
    }

    /// Returns a view that looks at `position` and matches a paraboloid map there. A paraboloid map preserves angles: seen from the light,
    /// a texel at an angle θ to the normal is a square, 2 (1 + cos θ) / size wide. The view's axes are the map's, rotated along the
    /// shortest arc from the normal to that direction. Positions behind the light's plane, which are in no map, are treated as if on the
    /// plane.
    pub fn about(&self, position: DVec3) -> Self {
        let [normal, right, up] = [self.forward, self.right, self.up].map(vec);
        let forward = (position - vec(self.origin)).normalize_or(normal);
        let turn = DQuat::from_rotation_arc(normal.normalize(), forward);
        let scale = (1.0 / (1.0 + forward.dot(normal).max(0.0))) as f32;
        let [right, up, forward] = [turn * right, turn * up, forward].map(|axis| axis.as_vec3().into());
        Self { right, up, forward, scale_x: scale, scale_y: scale, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use proptest::prelude::*;

    proptest! {
        /// Takes two directions that are up to a texel apart in the map, by the map's formula. In the view about one of them, they must
        /// differ by the same offset.
        #[test]
        fn texels_about_a_place_are_the_maps(
            normal in prop::array::uniform3(-1.0f64..1.0),
            way in prop::array::uniform3(-1.0f64..1.0),
            beside in prop::array::uniform2(-1.0f64..1.0),
            size in prop::sample::select(vec![32u32, 64, 128]),
        ) {
            let (normal, way) = (DVec3::from(normal), DVec3::from(way).normalize_or_zero());
            prop_assume!(normal.length() > 0.1 && way.dot(normal) > 0.05 * normal.length());
            let light = DVec3::new(0.5, -1.25, 2.0);
            let map = View::paraboloid(light, normal.normalize(), size);
            let axes = [map.right, map.up, map.forward].map(vec);
            // The formula of glsl/technique/ism/visibility.glsl, and the inverse of map_way.
            let texel = |offset: DVec3| {
                let [x, y, z] = axes.map(|axis| axis.dot(offset));
                (DVec2::new(x, y) / (offset.length() + z) * 0.5 + 0.5) * f64::from(size)
            };
            let back = |texel: DVec2| {
                let place = texel / f64::from(size) * 2.0 - 1.0;
                let [x, y, z] = [2.0 * place.x, 2.0 * place.y, 1.0 - place.length_squared()];
                x * axes[0] + y * axes[1] + z * axes[2]
            };
            let offset = back(texel(way) + DVec2::from(beside));
            let view = map.about(light + 3.0 * way);
            let (middle, _) = view.project(light + 3.0 * way);
            let (at, _) = view.project(light + offset);
            // Straight lines in the view are curved in the map, by about a texel's angle.
            let most = 8.0 / f64::from(size);
            prop_assert!((at - middle - DVec2::from(beside)).length() < most, "{:?} is {}", beside, at - middle);
        }
    }
}
