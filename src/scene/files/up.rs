//! Which axis of a file points up. Few formats say so; for the others it is as their main writers have it.

use crate::scene::files::input;
use glam::{DQuat, DVec3};
use std::path::Path;

/// The names of all axes.
const AXES: [(&str, DVec3); 6] = [
    ("x", DVec3::X),
    ("y", DVec3::Y),
    ("z", DVec3::Z),
    ("-x", DVec3::NEG_X),
    ("-y", DVec3::NEG_Y),
    ("-z", DVec3::NEG_Z),
];

/// Reads the name of an axis: `y`, `+y` or `-y`.
///
/// # Errors
/// A message if there is no such axis.
pub(crate) fn parse(text: &str) -> std::result::Result<DVec3, String> {
    let bare = text.trim().trim_start_matches('+').to_lowercase();
    let axis = AXES.into_iter().find(|(name, _)| *name == bare).map(|(_, axis)| axis);
    axis.ok_or_else(|| format!("up {text:?} is none of x, y, z, -x, -y and -z"))
}

/// Returns the axis of a file that points up.
///
/// glTF and SPZ define +y; Houdini writes OpenVDB and TressFX's exporters their format with +y up. Captures have the axes of their first
/// camera, which has −y up. All others: +z.
pub(in crate::scene) fn by_format(path: &Path, is_capture: bool) -> DVec3 {
    match input::ending(path).as_str() {
        "gltf" | "glb" | "spz" | "tfx" | "vdb" | "nvdb" => DVec3::Y,
        _ if is_capture => DVec3::NEG_Y,
        _ => DVec3::Z,
    }
}

/// Returns a note about the axis that was taken; none for formats that define it.
pub(in crate::scene) fn note(path: &Path, up: DVec3) -> Option<String> {
    let is_defined = ["gltf", "glb", "spz"].contains(&input::ending(path).as_str());
    let taken = format!("{}: {} is taken for up, unless `up` names another axis", input::file_name(path), name(up));
    (!is_defined).then_some(taken)
}

/// Returns an axis' name.
pub(crate) fn name(up: DVec3) -> &'static str {
    AXES.into_iter().find(|(_, axis)| *axis == up).map_or("no axis", |(name, _)| name)
}

/// Returns the axis nearest to a direction.
pub(in crate::scene) fn nearest(direction: DVec3) -> DVec3 {
    let nearer = |a: &(&str, DVec3), b: &(&str, DVec3)| a.1.dot(direction).total_cmp(&b.1.dot(direction));
    AXES.into_iter().max_by(nearer).map_or(DVec3::Z, |(_, axis)| axis)
}

/// Returns the rotation that turns one axis to another, about x where it can.
pub(in crate::scene) fn turn(from: DVec3, to: DVec3) -> DQuat {
    let about = match from.cross(to) {
        DVec3::ZERO if from == to => return DQuat::IDENTITY,
        DVec3::ZERO if from.x == 0.0 => DVec3::X,
        DVec3::ZERO => DVec3::Z,
        about => about,
    };
    DQuat::from_axis_angle(about, from.angle_between(to))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every axis turns to every other, and a y that turns to z leaves x in place.
    #[test]
    fn axes_turn() {
        for (from_name, from) in AXES {
            assert_eq!(parse(from_name), Ok(from));
            for (_, to) in AXES {
                assert!((turn(from, to) * from - to).length() < 1e-12, "{from} {to}");
            }
        }
        assert!((turn(DVec3::NEG_Y, DVec3::Z) * DVec3::X - DVec3::X).length() < 1e-12);
        assert_eq!(parse("+Y"), Ok(DVec3::Y));
        assert!(parse("north").expect_err("no axis").contains("north"));
        assert_eq!(nearest(DVec3::new(0.1, -0.9, 0.3)), DVec3::NEG_Y);
    }
}
