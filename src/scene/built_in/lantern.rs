//! The built-in scene `lantern`: three kinds of light at once.

use crate::Result;
use crate::scene::built_in::emitters::{Emitter, Smoke, ground, most, smoke_after};
use crate::scene::model::time::wave;
use crate::scene::{Camera, Light, LightKind, Mesh, Particle, Reserve, Scene};
use glam::DVec3;

/// Half the side of the ground.
const GROUND_HALF_WORLD: f32 = 6.0;

/// Position of the lantern's flame at rest.
const FLAME: DVec3 = DVec3::new(0.0, 0.0, 1.25);

/// Posts around the flame: x and y of each.
const POSTS: [[f32; 2]; 3] = [[0.9, 0.5], [-0.85, 0.6], [0.05, -1.05]];

/// Half width and height of a post.
const POST_WORLD: [f32; 2] = [0.07, 2.0];

/// Smouldering heaps around the lantern: 1,500 particles from 8 s on.
const HEAPS: [Emitter; 3] =
    [heap([0x1a7e_0001, 41], [1.5, -0.5]), heap([0x1a7e_0002, 42], [-0.5, 1.4]), heap([0x1a7e_0003, 43], [-1.4, -0.9])];

const fn heap(seed: [u64; 2], [x, y]: [f64; 2]) -> Emitter {
    Emitter {
        seed,
        capacity: 500,
        lifetime_s: 8.0,
        position: DVec3::new(x, y, 0.2),
        nozzle_radius_world: 0.3,
        velocity: DVec3::new(0.0, 0.0, 0.3),
        velocity_spread: 0.2,
        rise: [0.42, 0.2],
        drag: 1.5,
        swirl: 0.16,
        drift: 0.08,
        radius_world: [0.14, 0.4],
        optical_depth: 0.16,
    }
}

/// The time at which all lights have the positions given by the constants. It is the default time.
const AT_REST_S: f64 = 20.0;

/// Returns the smoke at a given time.
///
/// # Errors
/// Same as [`smoke_after`].
pub(crate) fn particles(time_s: f64, before: &mut Smoke) -> Result<Vec<Particle>> {
    smoke_after("lantern", &HEAPS, time_s, before)
}

/// Returns the lights at a given time: the lantern swings on its chain, the spot light sweeps, and the moon moves.
pub(crate) fn lights(time_s: f64) -> Vec<Light> {
    let swing = |period_s: f64| wave((time_s - AT_REST_S) / period_s);
    let flame = FLAME + DVec3::new(0.3 * swing(2.9), 0.2 * swing(3.7), 0.05 * swing(1.3));
    let spot = DVec3::new(-4.5, -3.0, 4.5);
    let target = DVec3::new(0.9 * swing(7.0), 0.3 + 0.6 * swing(9.0), 0.8);
    let moon = DVec3::new(-0.35 + 0.2 * swing(40.0), 0.4, -0.85);
    vec![
        Light { kind: LightKind::Point { position: flame }, radiance: [1.0, 0.62, 0.28], radius: f64::INFINITY },
        Light {
            kind: LightKind::Spot { position: spot, direction: (target - spot).normalize(), cone_degrees: 42.0 },
            radiance: [0.2, 0.38, 0.75],
            radius: f64::INFINITY,
        },
        Light {
            kind: LightKind::Directional { direction: moon.normalize() },
            radiance: [0.14, 0.15, 0.17],
            radius: f64::INFINITY,
        },
    ]
}

/// Builds a warm point light between smoking heaps and posts, a cold spot light from the side and a dim directional light from above, after
/// `time_s` seconds; in units of about a metre, z up.
///
/// # Errors
/// Same as [`smoke_after`].
pub(in crate::scene) fn lantern(time_s: f64) -> Result<Scene> {
    Ok(Scene {
        name: "lantern".into(),
        reserve: Reserve { particles: most(&HEAPS), ..Reserve::default() },
        particles: particles(time_s, &mut Smoke::default())?,
        meshes: std::iter::once(ground(GROUND_HALF_WORLD)).chain(POSTS.map(post)).collect(),
        lights: lights(time_s),
        camera: Camera {
            position: DVec3::new(3.2, -9.5, 4.6),
            target: DVec3::new(0.0, 0.1, 1.0),
            up: DVec3::Z,
            fov_y_degrees: 38.0,
        },
        ..Scene::default()
    })
}

/// Builds a box that stands on the ground.
fn post([x, y]: [f32; 2]) -> Mesh {
    let [half, height] = POST_WORLD;
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 1 { half } else { -half };
        [x + side(0), y + side(1), if i & 4 == 4 { height } else { 0.0 }]
    };
    // Two triangles per side, except the bottom, which is left open; triangles cast shadows from both sides.
    let quads = [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [4, 5, 7, 6]];
    Mesh {
        name: "post".into(),
        positions: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect(),
        albedo: [0.45, 0.36, 0.3],
        solid: false,
        alpha: None,
    }
}
