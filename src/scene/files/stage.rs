//! Lights and cameras as described in files, and the checks they must pass.

use crate::scene::{Camera, Light, LightKind};
use glam::DVec3;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// The sine of the angle below which `up` counts as parallel to the view, because the picture's roll would be rounding noise.
const MIN_UP_SINE: f64 = 1e-6;

/// The narrowest cone of a spot light, and the narrowest camera angle. Narrower ones have no usable tangent in f32.
pub(in crate::scene) const NARROWEST_DEGREES: f64 = 1e-6;

/// A light in a scene file.
#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub(in crate::scene) enum LightEntry {
    Directional {
        direction: [f64; 3],
        #[serde(default = "white")]
        radiance: [f64; 3],
    },
    Spot {
        position: [f64; 3],
        target: [f64; 3],
        cone_degrees: f64,
        #[serde(default = "white")]
        radiance: [f64; 3],
        #[serde(default = "endless")]
        radius: f64,
    },
    Point {
        position: [f64; 3],
        #[serde(default = "white")]
        radiance: [f64; 3],
        #[serde(default = "endless")]
        radius: f64,
    },
}

/// Reads a table or an array of tables. An untagged enum could do this too, but its errors would not describe what is wrong.
pub(in crate::scene) fn one_or_more<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> std::result::Result<Option<Vec<LightEntry>>, D::Error> {
    struct Lights;
    impl<'de> Visitor<'de> for Lights {
        type Value = Vec<LightEntry>;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            f.write_str("[light] or [[light]]")
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<Self::Value, A::Error> {
            Ok(vec![LightEntry::deserialize(MapAccessDeserializer::new(map))?])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> std::result::Result<Self::Value, A::Error> {
            Vec::deserialize(SeqAccessDeserializer::new(sequence))
        }
    }
    deserializer.deserialize_any(Lights).map(Some)
}

/// A camera in a scene file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::scene) struct CameraEntry {
    pub position: [f64; 3],
    pub target: [f64; 3],
    pub up: [f64; 3],
    pub fov_y_degrees: f64,
}

fn white() -> [f64; 3] {
    [1.0; 3]
}

fn endless() -> f64 {
    f64::INFINITY
}

/// Checks a light; the error describes what is wrong.
pub(in crate::scene) fn light(entry: &LightEntry) -> std::result::Result<Light, String> {
    let (kind, radiance, radius) = match *entry {
        LightEntry::Directional { direction, radiance } => {
            let direction = unit(finite("light direction", direction)?).ok_or("light direction has no length")?;
            (LightKind::Directional { direction }, radiance, endless())
        }
        LightEntry::Spot { position, target, cone_degrees, radiance, radius } => {
            let position = finite("light position", position)?;
            let target = finite("light target", target)?;
            let direction = unit(target - position).ok_or("light position and target are the same point")?;
            if !(NARROWEST_DEGREES..=170.0).contains(&cone_degrees) {
                return Err(format!("light cone_degrees {cone_degrees} is not in [{NARROWEST_DEGREES:e}, 170]"));
            }
            (LightKind::Spot { position, direction, cone_degrees }, radiance, radius)
        }
        LightEntry::Point { position, radiance, radius } => {
            (LightKind::Point { position: finite("light position", position)? }, radiance, radius)
        }
    };
    if !(radius > 0.0 && (1.0 / (radius * radius)).is_finite()) {
        return Err(format!("light radius {radius} is not greater than 0"));
    }
    Ok(Light { kind, radiance: crate::scene::files::stage::radiance(radiance)?, radius })
}

/// Checks a radiance and converts it to f32; the error describes what is wrong.
pub(in crate::scene) fn radiance(radiance: [f64; 3]) -> std::result::Result<[f32; 3], String> {
    let radiance = radiance.map(|value| value as f32);
    if !radiance.iter().all(|value| value.is_finite() && *value >= 0.0) {
        return Err(format!("light radiance {radiance:?} is not finite and at least 0"));
    }
    Ok(radiance)
}

/// Checks a camera; the error describes what is wrong.
pub(in crate::scene) fn camera(entry: &CameraEntry) -> std::result::Result<Camera, String> {
    let position = finite("camera position", entry.position)?;
    let target = finite("camera target", entry.target)?;
    let up = finite("camera up", entry.up)?;
    let view = unit(target - position).ok_or("camera position and target are the same point")?;
    let unit_up = unit(up).ok_or("camera up has no length")?;
    if view.cross(unit_up).length() < MIN_UP_SINE {
        return Err("camera up is parallel to the view".into());
    }
    let fov_y_degrees = entry.fov_y_degrees;
    if !(NARROWEST_DEGREES..180.0).contains(&fov_y_degrees) {
        return Err(format!("camera fov_y_degrees {fov_y_degrees} is not in [{NARROWEST_DEGREES:e}, 180)"));
    }
    Ok(Camera { position, target, up, fov_y_degrees })
}

/// The largest allowed coordinate and radius. All values are converted to f32 at some point, and squared distances must stay finite there.
pub(in crate::scene) const MAX_COORDINATE: f64 = 1e18;

/// Returns whether all these coordinates or radii are in range.
pub(in crate::scene) fn in_range(values: &[f32]) -> bool {
    values.iter().all(|value| f64::from(value.abs()) <= MAX_COORDINATE)
}

/// Checks that a vector is in range; `name` identifies it in the error.
pub(in crate::scene) fn finite(name: &str, values: [f64; 3]) -> std::result::Result<DVec3, String> {
    if values.iter().all(|value| value.abs() <= MAX_COORDINATE) {
        return Ok(DVec3::from_array(values));
    }
    Err(format!("{name} {values:?} is not finite or exceeds {MAX_COORDINATE:e}"))
}

/// Returns the vector at unit length; `None` if its length is 0. It is scaled first, so that tiny vectors keep their direction.
pub(in crate::scene) fn unit(vector: DVec3) -> Option<DVec3> {
    let largest = vector.abs().max_element();
    if largest == 0.0 {
        return None;
    }
    (vector / largest).try_normalize()
}
