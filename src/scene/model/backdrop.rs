//! The background of presentation pictures: a sky with the scene's sun, into which the ground fades. Measured pictures have none. Twins:
//! glsl/shading/backdrop.glsl, reference::truth::backdrop.

use crate::scene::model::view::{across, some_up, vec};
use crate::scene::{LightKind, Mesh, Scene};
use glam::DVec3;

/// Sky colors at the horizon and at the zenith, linear RGB. `DAY` is for scenes with a sun, `NIGHT` for scenes without one.
const DAY: [[f32; 3]; 2] = [[0.15, 0.19, 0.26], [0.03, 0.055, 0.12]];
const NIGHT: [[f32; 3]; 2] = [[0.055, 0.065, 0.090], [0.008, 0.012, 0.025]];

/// A mesh counts as ground if its height is at most this fraction of its width.
const FLAT: f64 = 0.05;

/// The largest distance from the ground's centre at which the ground may begin to fade, as a fraction of its extent. If another mesh
/// extends farther out, the ground does not fade.
const LATEST: f64 = 0.9;

/// The smallest distance from the ground's centre at which the ground may begin to fade, as a fraction of its extent.
const EARLIEST: f64 = 0.7;

/// A sky, a sun and a ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Backdrop {
    /// Up direction, unit length.
    pub up: [f32; 3],
    /// Direction towards the sun, unit length.
    pub sun: [f32; 3],
    /// The sun's radiance; black if there is no sun.
    pub sunlight: [f32; 3],
    /// The sky's color at the horizon, linear RGB; the sky darkens below the horizon.
    pub horizon: [f32; 3],
    /// The sky's color at the zenith, linear RGB.
    pub zenith: [f32; 3],
    /// The ground's centre, in world units.
    pub middle: [f32; 3],
    /// Distances from the ground's centre at which it begins to fade and has faded entirely, in world units; both 0 if it does not fade.
    pub fade: [f32; 2],
    /// Half the ground's height: how far it extends above and below its centre, in world units.
    pub thick: f32,
}

impl Backdrop {
    /// Returns the backdrop of a scene: the first directional light is the sun, and up is the camera's up.
    pub fn of(scene: &Scene) -> Self {
        let up = scene.camera.up.normalize_or(DVec3::Z);
        // If each light is listed once per color, add up the sun's colors.
        let each = scene.lights.len() / scene.colors();
        let whole = |first: usize| {
            let its = scene.lights.iter().skip(first).step_by(each.max(1));
            its.fold([0.0; 3], |sum, light| [0, 1, 2].map(|i| sum[i] + light.radiance[i]))
        };
        let sun = scene.lights.iter().take(each).enumerate().find_map(|(i, light)| match light.kind {
            LightKind::Directional { direction } => Some((-direction.normalize_or(-up), whole(i))),
            _ => None,
        });
        let [horizon, zenith] = if sun.is_some() { DAY } else { NIGHT };
        let (sun, sunlight) = sun.unwrap_or((up, [0.0; 3]));
        let (middle, fade, thick) = ground(scene, up).unwrap_or((DVec3::ZERO, [0.0; 2], 0.0));
        let rounded = |v: DVec3| v.as_vec3().to_array();
        Self {
            up: rounded(up),
            sun: rounded(sun),
            sunlight,
            horizon,
            zenith,
            middle: rounded(middle),
            fade: fade.map(|radius| radius as f32),
            thick: thick as f32,
        }
    }
}

/// Returns the box around points, along the given axes: its centre and half-extents.
fn extent(points: impl Iterator<Item = DVec3>, axes: [DVec3; 3]) -> Option<(DVec3, DVec3)> {
    let along = |p: DVec3| DVec3::from_array(axes.map(|axis| axis.dot(p)));
    let bounds = points
        .map(along)
        .fold(None, |all: Option<(DVec3, DVec3)>, p| Some(all.map_or((p, p), |(low, high)| (low.min(p), high.max(p)))));
    let (low, high) = bounds?;
    let middle = 0.5 * (low + high);
    Some((axes[0] * middle.x + axes[1] * middle.y + axes[2] * middle.z, 0.5 * (high - low)))
}

/// Finds the ground, which is the widest flat mesh. Returns its centre, the two distances between which it fades, and half its height; or
/// None if another mesh is so far out that fading would hide it.
fn ground(scene: &Scene, up: DVec3) -> Option<(DVec3, [f64; 2], f64)> {
    let (right, forward) = across(up, some_up(up));
    let axes = [right, forward, up];
    let points = |mesh: &Mesh| mesh.positions.clone().into_iter().map(vec);
    let flat = scene.meshes.iter().enumerate().filter_map(|(i, mesh)| {
        let (middle, half) = extent(points(mesh), axes)?;
        (half.z <= FLAT * half.x.min(half.y) && half.x > 0.0).then_some((i, middle, half))
    });
    let (ground, middle, half) = flat.max_by(|a, b| a.2.x.total_cmp(&b.2.x))?;
    let end = half.x.min(half.y);
    let away = |p: DVec3| (p - middle - (p - middle).dot(up) * up).length();
    let others = scene.meshes.iter().enumerate().filter(|(i, _)| *i != ground);
    let farthest = others.flat_map(|(_, mesh)| points(mesh)).map(away).fold(0.0, f64::max);
    let begin = (1.02 * farthest).max(EARLIEST * end);
    // Slightly more than the ground's half height, to allow for rounding of positions.
    (begin <= LATEST * end).then_some((middle, [begin, end], half.z + 1e-3 * end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::{cube, mesh, on_the_axis};

    fn plate(half: f32) -> Mesh {
        let corners = vec![[-half, -half, 1.0], [half, -half, 1.0], [half, half, 1.0], [-half, half, 1.0]];
        mesh(corners, vec![[0, 1, 2], [0, 2, 3]])
    }

    /// A flat plate must fade as the ground, unless an object on it is too far out. An empty scene and a box have no ground, so nothing may
    /// fade.
    #[test]
    fn ground_fades_where_nothing_stands() {
        let mut scene = on_the_axis(&[]);
        let fade = |scene: &Scene| Backdrop::of(scene).fade;
        assert_eq!(fade(&scene), [0.0; 2]);
        scene.meshes = vec![cube([0.0; 3], 1.0)];
        assert_eq!(fade(&scene), [0.0; 2]);
        scene.meshes = vec![cube([0.0; 3], 1.0), plate(10.0)];
        assert_eq!(fade(&scene), [7.0, 10.0]);
        assert_eq!(Backdrop::of(&scene).middle, [0.0, 0.0, 1.0]);
        scene.meshes[0] = cube([4.5; 3], 1.0);
        let far = 1.02 * (2.0 * 5.5_f64.powi(2)).sqrt();
        assert!((f64::from(fade(&scene)[0]) - far).abs() < 1e-5, "{:?}", fade(&scene));
        scene.meshes[0] = cube([8.0; 3], 1.0);
        assert_eq!(fade(&scene), [0.0; 2]);
    }

    /// The sun must be in the direction that its light comes from; without a sun, the sky must have its night colors.
    #[test]
    fn the_sun_is_the_first_directional_light() {
        let mut scene = on_the_axis(&[]);
        let day = Backdrop::of(&scene);
        assert_eq!((day.sun, day.sunlight, day.horizon), ([0.0, 0.0, 1.0], [1.0; 3], DAY[0]));
        scene.lights[0].kind = LightKind::Point { position: DVec3::ZERO };
        let night = Backdrop::of(&scene);
        assert_eq!((night.sunlight, night.horizon), ([0.0; 3], NIGHT[0]));
    }
}
