//! Lights (KHR_lights_punctual) and cameras of glTF files.
//!
//! glTF intensities are in lux (directional) and candela (spot, point). A [`Light`] has the same radiance at any distance, and 1 fully
//! lights a white surface. So each light's radiance is its color times its illuminance at the centre of the file's meshes. Then all
//! radiances are scaled by one factor, so that the brightest channel is 1. The illuminance of a light among the meshes is computed as if
//! the light were at their outer radius; otherwise a lamp at the centre would outshine all others. A light with a range ends there, and its
//! illuminance is that at half the range.

use crate::scene::files::contents::Contents;
use crate::scene::files::stage::{self, CameraEntry, finite, unit};
use crate::scene::{Camera, Light, LightKind};
use glam::{DMat4, DVec3};
use gltf::khr_lights_punctual::Kind;

type Checked<T> = std::result::Result<T, String>;

/// The widest cone of a [`LightKind::Spot`], in degrees. glTF allows up to 180, which no single map can cover.
const WIDEST_CONE: f64 = 170.0;

/// Returns a node's light, with color × intensity as its radiance, before [`balance`]. It shines along the node's −z.
pub(in crate::scene) fn light(light: &gltf::khr_lights_punctual::Light, to_world: DMat4) -> Checked<Light> {
    let position = || finite("light position", to_world.w_axis.truncate().to_array());
    let direction = || direction(to_world, DVec3::NEG_Z).ok_or("light has no direction");
    let kind = match light.kind() {
        Kind::Directional => LightKind::Directional { direction: direction()? },
        Kind::Point => LightKind::Point { position: position()? },
        Kind::Spot { outer_cone_angle, .. } => {
            let cone_degrees = 2.0 * f64::from(outer_cone_angle).to_degrees();
            if !(stage::NARROWEST_DEGREES..181.0).contains(&cone_degrees) {
                let least = stage::NARROWEST_DEGREES;
                return Err(format!("light outerConeAngle {outer_cone_angle} is not half of {least:e} to 180 degrees"));
            }
            let cone_degrees = cone_degrees.min(WIDEST_CONE);
            LightKind::Spot { position: position()?, direction: direction()?, cone_degrees }
        }
    };
    let radiance = light.color().map(|channel| f64::from(channel) * f64::from(light.intensity()));
    // A range is not scaled by its node (KHR_lights_punctual). One of 0 or less says nothing.
    let radius =
        light.range().map(f64::from).filter(|range| *range > 0.0 && !matches!(kind, LightKind::Directional { .. }));
    Ok(Light { kind, radiance: stage::radiance(radiance)?, radius: radius.unwrap_or(f64::INFINITY) })
}

/// Returns whether a spot light fades from an inner cone to its outer one.
pub(in crate::scene) fn has_soft_edge(light: &gltf::khr_lights_punctual::Light) -> bool {
    matches!(light.kind(), Kind::Spot { inner_cone_angle, outer_cone_angle }
        if inner_cone_angle < outer_cone_angle)
}

/// Returns a node's perspective camera, if it has one. It looks along the node's −z, with +y up.
pub(in crate::scene) fn camera(
    document: &gltf::Document,
    node: &gltf::Node,
    to_world: DMat4,
) -> Checked<Option<Camera>> {
    // The glTF crate's own accessor assumes that the perspective data exist if the type declares them.
    let json = node.camera().and_then(|camera| document.as_json().cameras.get(camera.index()));
    let Some(perspective) = json.and_then(|camera| camera.perspective.as_ref()) else { return Ok(None) };
    let position = finite("camera position", to_world.w_axis.truncate().to_array())?;
    let forward = direction(to_world, DVec3::NEG_Z).ok_or("camera has no direction")?;
    let up = direction(to_world, DVec3::Y).ok_or("camera has no up")?;
    stage::camera(&CameraEntry {
        position: position.to_array(),
        // Far enough away to be distinct from the position in floating point.
        target: (position + forward * (1.0 + position.length())).to_array(),
        up: up.to_array(),
        fov_y_degrees: f64::from(perspective.yfov).to_degrees(),
    })
    .map(Some)
}

fn direction(to_world: DMat4, local: DVec3) -> Option<DVec3> {
    Some(to_world.transform_vector3(local)).filter(|vector| vector.is_finite()).and_then(unit)
}

/// Converts color × intensity to radiance, as described at the top of this file. Lights that are off are dropped. The contents are placed
/// at `scale`; distances count as they are in the file.
pub(in crate::scene) fn balance(contents: &mut Contents, scale: f64) {
    let (low, high) = contents.bounds().unwrap_or_default();
    let middle = (low + high) * 0.5;
    let reach = (high - low).length() * 0.5;
    let illuminance = |light: &Light| {
        let distance = light.position().map_or(1.0, |position| {
            let distance = position.distance(middle).max(reach) / scale;
            match light.radius {
                radius if radius.is_finite() => 0.5 * radius / scale,
                _ if distance > 0.0 => distance,
                _ => 1.0,
            }
        });
        light.radiance.map(|channel| f64::from(channel) / (distance * distance))
    };
    let brightest = contents.lights.iter().flat_map(illuminance).fold(0.0, f64::max);
    for light in &mut contents.lights {
        light.radiance = illuminance(light).map(|channel| (channel / brightest) as f32);
    }
    contents.lights.retain(|light| light.radiance.iter().any(|channel| *channel > 0.0));
}
