//! The built-in scene `fountain`: particles simulated on the device, over a bowl, between steps and columns.

use crate::Result;
use crate::scene::built_in::emitters::ground;
use crate::scene::built_in::fountain_law::Fountain;
use crate::scene::built_in::fountain_steps;
use crate::scene::built_in::town_shapes::{Place, block, empty, fan, loft, tube};
use crate::scene::model::time::check_time;
use crate::scene::{Camera, Light, LightKind, Mesh, Particle, Scene};
use glam::{DVec2, DVec3};

/// Half the side of the ground, slightly less than half the grid's.
const GROUND_HALF_WORLD: f32 = 3.9;

/// The bowl's profile from its foot up, over its rim and down inside: distance from the axis, height.
const BOWL: [[f64; 2]; 7] =
    [[0.28, 1.1], [0.75, 1.22], [1.15, 1.62], [1.02, 1.66], [0.66, 1.38], [0.3, 1.3], [0.1, 1.28]];

/// Number of sides of round shapes.
const SIDES: u32 = 32;

/// Columns: x, y, height.
const COLUMNS: [[f64; 3]; 4] = [[-2.2, 1.2, 2.6], [-1.1, 2.4, 3.2], [1.1, 2.4, 3.2], [2.2, 1.2, 2.6]];

/// Returns the particles at a given time, bit-identical to the device's.
pub(crate) fn particles(fountain: &Fountain, time_s: f64) -> Result<Vec<Particle>> {
    check_time("fountain", time_s)?;
    Ok(fountain_steps::particles(fountain, &meshes(), fountain.step_at(time_s)))
}

/// Builds the scene at a given time, with `particles` particles, in units of about a metre, z up.
///
/// # Errors
/// [`Error::Usage`](crate::Error::Usage) if `time_s` is not in [0, 3600].
pub(in crate::scene) fn fountain(name: &str, particles: u32, time_s: f64) -> Result<Scene> {
    let fountain = Fountain::new(particles);
    Ok(Scene {
        name: name.into(),
        reserve: fountain.reserve(),
        particles: crate::scene::built_in::fountain::particles(&fountain, time_s)?,
        meshes: meshes(),
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::new(0.52, 0.36, -0.78).normalize() },
            radiance: [1.0, 0.97, 0.9],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: DVec3::new(2.4, -10.2, 5.6),
            target: DVec3::new(-0.15, -0.1, 1.2),
            up: DVec3::Z,
            fov_y_degrees: 37.0,
        },
        ..Scene::default()
    })
}

/// Builds the static meshes: a ground, and closed shapes on it.
fn meshes() -> Vec<Mesh> {
    let world = Place { origin: DVec3::ZERO, along: DVec2::X };
    let mut bowl = empty("bowl", [0.62, 0.6, 0.56]);
    let ring = |radius: f64, height: f64| -> Vec<DVec3> {
        let turn = |i: u32| crate::scene::built_in::emitters::direction(f64::from(i) / f64::from(SIDES));
        (0..SIDES).map(|i| (radius * turn(i)).extend(height)).collect()
    };
    loft(&mut bowl, &BOWL.map(|[radius, height]| ring(radius, height)), &fan(SIDES));
    let upright = |[x, y]: [f64; 2], low: f64, high: f64, radius: f64| {
        [low, high].map(|height| (DVec3::new(x, y, height), radius))
    };
    tube(&mut bowl, &upright([0.0, 0.0], 0.0, 1.15, 0.24), SIDES);
    let mut columns = empty("columns", [0.66, 0.62, 0.52]);
    for [x, y, height] in COLUMNS {
        tube(&mut columns, &upright([x, y], 0.0, height, 0.16), SIDES);
        block(&mut columns, &world, [x - 0.24, y - 0.24, height - 0.05], [x + 0.24, y + 0.24, height + 0.15]);
    }
    // Steps to the left of the bowl, each a quarter of a unit higher than the previous one.
    let mut steps = empty("steps", [0.5, 0.52, 0.56]);
    for i in 0..4 {
        let (rise, left) = (0.25 * f64::from(i + 1), -1.9 - 0.4 * f64::from(i));
        block(&mut steps, &world, [left - 0.4, -1.6, 0.0], [left, 0.3, rise]);
    }
    let mut rim = empty("rim", [0.56, 0.53, 0.5]);
    for (low, high) in
        [([-3.4, -3.4], [3.4, -3.2]), ([-3.4, 3.2], [3.4, 3.4]), ([-3.4, -3.2], [-3.2, 3.2]), ([3.2, -3.2], [3.4, 3.2])]
    {
        block(&mut rim, &world, [low[0], low[1], 0.0], [high[0], high[1], 0.3]);
    }
    // The ground is darker than the particles that fall on it.
    let ground = Mesh { albedo: [0.3, 0.33, 0.36], ..ground(GROUND_HALF_WORLD) };
    vec![ground, bowl, columns, steps, rim]
}
