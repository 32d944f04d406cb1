//! How a scene file places the files it names.

use crate::scene::files::stage::{self, CameraEntry, finite, unit};
use crate::scene::{Camera, Light, LightKind};
use glam::{DQuat, DVec3};

/// Scale, rotation and translation of a file's contents, applied in this order, in f64: a file may stand where floats are coarse, and its
/// placement bring it to where they are fine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) struct Placement {
    pub translate: DVec3,
    pub rotate: DQuat,
    /// Scale factor, greater than 0.
    pub scale: f64,
}

impl Placement {
    /// Keeps everything at the file's own coordinates.
    pub(in crate::scene) const AS_IT_STANDS: Self =
        Self { translate: DVec3::ZERO, rotate: DQuat::IDENTITY, scale: 1.0 };

    /// Creates a placement; `rotate` is an axis and an angle in degrees.
    pub(in crate::scene) fn new(
        translate: [f64; 3],
        rotate: Option<[f64; 4]>,
        scale: f64,
    ) -> std::result::Result<Self, String> {
        if !(scale.is_finite() && scale > 0.0) {
            return Err(format!("scale {scale} is not finite and greater than 0"));
        }
        let rotate = match rotate {
            None => DQuat::IDENTITY,
            Some([x, y, z, degrees]) => {
                let axis = unit(finite("rotate", [x, y, z])?).ok_or("rotate has an axis of no length")?;
                DQuat::from_axis_angle(axis, finite("rotate", [degrees, 0.0, 0.0])?.x.to_radians())
            }
        };
        Ok(Self { translate: finite("translate", translate)?, rotate, scale })
    }

    pub(in crate::scene) fn position<T: Into<f64>>(&self, position: [T; 3]) -> [f64; 3] {
        self.point(DVec3::from_array(position.map(T::into))).to_array()
    }

    pub(in crate::scene) fn point(&self, point: DVec3) -> DVec3 {
        // Skips an identity rotation, which would round the result.
        let turned =
            if self.rotate == DQuat::IDENTITY { point * self.scale } else { self.rotate * (point * self.scale) };
        turned + self.translate
    }

    pub(in crate::scene) fn light(&self, mut light: Light) -> std::result::Result<Light, String> {
        if let LightKind::Spot { position, .. } | LightKind::Point { position } | LightKind::Virtual { position, .. } =
            &mut light.kind
        {
            *position = finite("placed light position", self.point(*position).to_array())?;
        }
        if let LightKind::Directional { direction }
        | LightKind::Spot { direction, .. }
        | LightKind::Virtual { normal: direction, .. } = &mut light.kind
        {
            *direction = self.rotate * *direction;
        }
        light.radius *= self.scale;
        Ok(light)
    }

    pub(in crate::scene) fn camera(&self, camera: &Camera) -> std::result::Result<Camera, String> {
        stage::camera(&CameraEntry {
            position: self.point(camera.position).to_array(),
            target: self.point(camera.target).to_array(),
            up: (self.rotate * camera.up).to_array(),
            fov_y_degrees: camera.fov_y_degrees,
        })
    }
}
