//! The built-in scene `ink`: drops of ink that sink through clear water past a post, over a pale ground. The ink absorbs most red light and
//! little blue, so that its shadow is blue where the ink is thin; the shadow of the post is grey. `ink:inks=2` has a second ink in every
//! other drop, which absorbs most blue light and little red.

use crate::Result;
use crate::scene::{Camera, ExtinctionGroup, Light, LightKind, Mesh, Particle, Random, Scene};
use glam::DVec3;
use std::f64::consts::TAU;

/// Extinction of red, green and blue light, as factors of a particle's extinction.
const RATIO: [f32; 3] = [1.0, 0.55, 0.2];

/// The same factors for the second ink.
const SECOND_RATIO: [f32; 3] = [0.2, 0.6, 1.0];

/// State and stream of the random numbers.
const SEED: [u64; 2] = [0x1a4b, 1];

/// The rings into which drops have opened: centre, radius, and radius of the tube, in world units.
const RINGS: [([f64; 3], f64, f64); 4] = [
    ([0.0, 0.0, 1.0], 0.75, 0.2),
    ([0.1, 0.05, 1.75], 0.5, 0.17),
    ([-1.15, 0.5, 1.35], 0.4, 0.14),
    ([1.0, -0.55, 2.1], 0.3, 0.12),
];

/// Number of particles per ring, and per thread of ink from which a ring hangs.
const RING: usize = 600;
const THREAD: usize = 200;

/// Height of the threads' upper ends.
const TOP_WORLD: f64 = 3.1;

/// Optical depth of red light through a particle's centre: in a ring, and in a thread.
const DENSE: [f64; 2] = [0.35, 0.2];

/// Builds four rings with their threads under a slanted directional light, with one ink or two alternating inks. The result is
/// bit-identical on every call and machine.
///
/// # Errors
/// Same as [`Scene::with_inks`].
pub(in crate::scene) fn ink(title: &str, inks: u32) -> Result<Scene> {
    let mut random = Random::new(SEED);
    let particles = RINGS.iter().flat_map(|ring| drop(&mut random, *ring)).collect();
    let scene = Scene {
        name: title.into(),
        particles,
        meshes: vec![
            slab("ground", DVec3::new(-2.6, -2.2, -0.1), DVec3::new(3.4, 2.8, 0.0), [0.85, 0.85, 0.82]),
            slab("post", DVec3::new(-0.75, -1.25, 0.0), DVec3::new(-0.55, -1.05, 2.3), [0.6, 0.58, 0.55]),
        ],
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::new(0.45, 0.3, -0.84).normalize() },
            radiance: [1.0; 3],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: DVec3::new(2.8, -7.2, 4.4),
            target: DVec3::new(0.25, 0.15, 0.95),
            up: DVec3::Z,
            fov_y_degrees: 36.0,
        },
        ..Scene::default()
    };
    let ratios = if inks == 1 { [RATIO; 2] } else { [RATIO, SECOND_RATIO] };
    let of_drops: Vec<_> =
        (0..RINGS.len()).map(|i| ExtinctionGroup { casters: RING + THREAD, ratio: ratios[i % 2] }).collect();
    scene.with_inks(&of_drops)
}

/// Returns the particles of a ring and its thread.
fn drop(random: &mut Random, (middle, radius, tube): ([f64; 3], f64, f64)) -> Vec<Particle> {
    let middle = DVec3::from(middle);
    let ring = (0..RING).map(|_| {
        let around = random.between(0.0, TAU);
        let out = DVec3::new(around.cos(), around.sin(), 0.0);
        let in_tube = tube * random.in_ball();
        // The ring has begun to break up: it sags in three places.
        let low = 0.3 * radius * (3.0 * around).sin();
        particle(middle + (radius - 0.2 * low) * out + in_tube - low * DVec3::Z, 0.45 * tube, DENSE[0])
    });
    let ring: Vec<_> = ring.collect();
    let height = TOP_WORLD - middle.z;
    let thread = (0..THREAD).map(|_| {
        // Near the ring the thread is denser, and widens to the ring's width.
        let up = random.between(0.0, 1.0) * random.between(0.0, 1.0);
        let open = (1.0 - up) * (1.0 - up);
        let wide = radius * open * open * open + 0.25 * tube;
        let in_thread = random.in_ball() * DVec3::new(wide, wide, 0.0);
        let bent = 0.1 * DVec3::new((5.0 * up).sin(), (4.0 * up).cos(), 0.0);
        particle(middle + in_thread + up * bent + (up * height + 0.5 * tube) * DVec3::Z, 0.4 * tube, DENSE[1])
    });
    ring.into_iter().chain(thread.collect::<Vec<_>>()).collect()
}

fn particle(position: DVec3, radius: f64, optical_depth: f64) -> Particle {
    Particle {
        position: position.as_vec3().into(),
        radius: radius as f32,
        extinction: (optical_depth / (2.0 * radius)) as f32,
    }
}

/// Builds a closed box.
fn slab(name: &str, low: DVec3, high: DVec3, albedo: [f32; 3]) -> Mesh {
    let corner = |i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] } as f32);
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Mesh { name: name.into(), positions: (0..8).map(corner).collect(), triangles, albedo, solid: false, alpha: None }
}
