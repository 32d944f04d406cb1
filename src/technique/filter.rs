//! How a look-up averages texels, for all techniques with a map of texels. Twin: glsl/common/filter.glsl.

use super::{Key, Spec, Values};
use crate::scene::{LightKind, Scene, gutter_texels};
use crate::{Error, Result};

/// Which filter.
pub const FILTER: Key = Key {
    name: "filter",
    values: Values::OneOf(&["bilinear", "box", "gaussian"]),
    default: "bilinear",
    about: "how a look-up weighs texels: the nearest four, or all within a radius",
};

/// How far it reaches.
pub const RADIUS: Key = Key {
    name: "radius",
    values: Values::Number(1, 8),
    default: "2",
    about: "texels that the box and the Gaussian reach; the Gaussian's deviation is half of it",
};

/// FILTER and FILTER_RADIUS of glsl/common/filter.glsl.
///
/// # Errors
/// [`Error::Input`] where a point light's faces are too small for the filter.
pub fn constants(scene: &Scene, spec: &Spec) -> Result<[u32; 2]> {
    let filter = match spec.value("filter") {
        "box" => 1,
        "gaussian" => 2,
        _ => 0,
    };
    let (size, radius) = (spec.number("size"), spec.number("radius"));
    // One texel more than the filter reaches, against rounding.
    let needed = if filter == 0 { 1 } else { radius + 1 };
    let has_point_light = scene.lights.iter().any(|l| matches!(l.kind, LightKind::Point { .. }));
    if has_point_light && (size < 4 || needed > gutter_texels(size)) {
        let cause = "too small for this filter across the edges of a point light's faces";
        let least = if filter == 0 { 4 } else { 8 * needed };
        return Err(Error::input(
            format!("size={size}"),
            cause,
            format!("use size={least} or more, or a smaller radius="),
        ));
    }
    Ok([filter, radius])
}
