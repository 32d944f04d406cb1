//! Built-in scenes made from embedded data: `plume_8k`, `plume_64k`, `terrain`, `mohawk`. `data/README.md` gives the data's origin and
//! packing.

use crate::scene::files::contents::Contents;
use crate::scene::model::random::Random;
use crate::scene::{Camera, Light, LightKind, Mesh, Particle, Scene, Strand, files::default_view, files::stage};
use crate::{Error, Result};
use glam::{DVec3, Vec3};

const PLUME: &[u8] = include_bytes!("data/plume_8k.bin");
const TERRAIN: &[u8] = include_bytes!("data/terrain.bin");
const MOHAWK: &[u8] = include_bytes!("data/mohawk.bin");
pub(in crate::scene) const GROUND: &[u8] = include_bytes!("data/ground.bin");
pub(in crate::scene) const HOUSES: &[u8] = include_bytes!("data/houses.bin");

/// Radius and extinction of a part, relative to its particle: `plume_64k` divides each particle into eight parts. The eight parts together
/// are as dark as the particle.
const PART: [f32; 2] = [8.0 / 13.0, 2197.0 / 4096.0];

/// The maximum distance of a part's centre from the particle's, as a fraction of its radius: the parts together fill the particle's volume.
const APART: f32 = 0.788;

/// State and stream of the random numbers.
const SEED: [u64; 2] = [0x64, 8];

/// Number of vertices per side of the terrain.
const SIDE: u32 = 52;

/// Number of points per hair, and bytes per hair: the first point, the length of a step, then three step counts for each further point.
const POINTS: usize = 32;
const HAIR_BYTES: usize = 16 + 3 * (POINTS - 1);

/// Half a hair's width, as a fraction of the longest side of the box around all hair; and a hair's opacity. Both match a TressFX file without
/// thickness; that format has no opacity.
const RADIUS: f32 = 1.0 / 800.0;
const OPACITY: f32 = 0.5;

/// Decodes vectors of three little-endian floats.
pub(in crate::scene) fn vectors(bytes: &[u8]) -> Vec<[f32; 3]> {
    bytemuck::pod_collect_to_vec(bytes)
}

/// Returns a white directional light, with its direction rounded as in a scene file.
pub(in crate::scene) fn sun(direction: DVec3) -> Light {
    let direction = stage::unit(direction).unwrap_or(DVec3::NEG_Z);
    Light { kind: LightKind::Directional { direction }, radiance: [1.0; 3], radius: f64::INFINITY }
}

/// Builds the smoke of three emitters, taken from a simulation. z is up; a world unit is a cell of that simulation.
pub(in crate::scene) fn plume_8k() -> Scene {
    plume("plume_8k", bytemuck::pod_collect_to_vec(PLUME))
}

/// Builds the smoke of [`plume_8k`], with each particle divided into eight smaller ones.
pub(in crate::scene) fn plume_64k() -> Scene {
    let mut random = Random::new(SEED);
    let whole = plume_8k().particles;
    let parts = whole.iter().flat_map(|whole| {
        [(); 8].map(|()| Particle {
            position: (Vec3::from(whole.position) + APART * whole.radius * random.in_ball().as_vec3()).to_array(),
            radius: PART[0] * whole.radius,
            extinction: PART[1] * whole.extinction,
        })
    });
    plume("plume_64k", parts.collect())
}

fn plume(name: &str, particles: Vec<Particle>) -> Scene {
    Scene {
        name: name.into(),
        particles,
        lights: vec![sun(DVec3::new(0.5, 0.3, -0.81))],
        camera: Camera {
            position: DVec3::new(150.0, -110.0, 75.0),
            target: DVec3::new(40.0, 40.0, 55.0),
            up: DVec3::Z,
            fov_y_degrees: 38.0,
        },
        ..Scene::default()
    }
}

/// Builds mountains as an open mesh, 2 units per side, y up.
pub(in crate::scene) fn terrain() -> Result<Scene> {
    let place = |i: u32| -1.0 + 2.0 / (SIDE - 1) as f32 * i as f32;
    let heights = bytemuck::pod_collect_to_vec::<u8, f32>(TERRAIN);
    let position = |(i, height): (u32, &f32)| [place(i % SIDE), *height, place(i / SIDE)];
    let squares = (0..SIDE - 1).flat_map(|z| (0..SIDE - 1).map(move |x| SIDE * z + x));
    let halves = |a: u32| [[a + SIDE, a + SIDE + 1, a + 1], [a + SIDE, a + 1, a]];
    let mesh = Mesh {
        name: "Terrain".into(),
        positions: (0..).zip(&heights).map(position).collect(),
        triangles: squares.flat_map(halves).collect(),
        albedo: [0.8; 3],
        solid: false,
        alpha: None,
    };
    under_a_fitted_light("terrain", Contents { meshes: vec![mesh], ..Contents::default() })
}

/// Builds 2,228 hairs of 31 segments, from real data, y up.
pub(in crate::scene) fn mohawk() -> Result<Scene> {
    let hairs: Vec<Vec<[f32; 3]>> = MOHAWK.chunks_exact(HAIR_BYTES).map(hair).collect();
    let points = || hairs.iter().flatten().map(|point| Vec3::from(*point));
    let low = points().fold(Vec3::INFINITY, Vec3::min);
    let high = points().fold(Vec3::NEG_INFINITY, Vec3::max);
    let radius = RADIUS * (high - low).max_element();
    let pairs = hairs.iter().flat_map(|hair| hair.windows(2));
    let strands = pairs.map(|pair| Strand { start: pair[0], radius, end: pair[1], opacity: OPACITY });
    let strands = strands.filter(|strand| strand.start != strand.end).collect();
    under_a_fitted_light("mohawk", Contents { strands, ..Contents::default() })
}

/// Returns the points of a packed hair.
fn hair(bytes: &[u8]) -> Vec<[f32; 3]> {
    let (floats, steps) = bytes.split_at(16);
    let floats: Vec<f32> = bytemuck::pod_collect_to_vec(floats);
    let mut at = [0, 1, 2].map(|axis| f64::from(floats[axis]));
    let mut points = vec![at.map(|along| along as f32)];
    for step in steps.chunks_exact(3) {
        for axis in 0..3 {
            at[axis] += f64::from(step[axis] as i8) * f64::from(floats[3]);
        }
        points.push(at.map(|along| along as f32));
    }
    points
}

fn under_a_fitted_light(name: &str, contents: Contents) -> Result<Scene> {
    let camera = default_view::camera(&contents, DVec3::Y);
    let camera = camera.map_err(|cause| Error::input(name, cause, "report this as a bug"))?;
    Ok(contents.scene(name.into(), vec![default_view::light(DVec3::Y)], camera))
}

// The data is used without byte swapping.
const _: () = assert!(cfg!(target_endian = "little"), "the data is little-endian");
