//! The built-in scene `hair`: a head with locks of curled hair over a floor.
//!
//! Only operations with results fixed by IEEE 754 are used (no `sin`), so the bytes are the same on every machine.

use crate::Result;
use crate::scene::model::time::{check_time, wave};
use crate::scene::{Camera, Light, LightKind, Mesh, Scene, Strand};
use glam::DVec3;
use rand::Rng;
use rand_pcg::Pcg32;

/// Number of locks in which hairs grow together, and number of hairs per lock.
const LOCKS: usize = 200;
const HAIRS_PER_LOCK: usize = 15;

/// Number of segments per hair, which makes 48,000 in total.
const SEGMENTS_PER_HAIR: usize = 16;

/// Half a hair's width. The hair is about 3 units across, so on a 256² map a hair is half a texel to one texel wide. The truth is sampled
/// at texel centres, most of which would miss a much thinner hair. A much wider one would be smooth over several texels, unlike hair.
const RADIUS_WORLD: f32 = 0.0045;

/// Hairs are translucent, since a texel or pixel covers both hair and the air beside it.
const OPACITY: f32 = 0.45;

/// Semi-axes of the head, which is a unit sphere while hair grows.
const HEAD_WORLD: DVec3 = DVec3::new(0.82, 0.94, 1.1);

/// Height of the floor.
const FLOOR_WORLD: f32 = -1.9;

/// Cosine and sine of the angle by which a curl turns per segment: two and a third turns per hair.
const CURL: [f64; 2] = [0.6, 0.8];

/// The time at which the moving light is at its rest position, in seconds.
const AT_REST_S: f64 = 20.0;

/// State and stream of the random numbers.
const SEED: [u64; 2] = [0x4a17, 1];

struct Random(Pcg32);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.next_u32()) / f64::from(u32::MAX)
    }

    /// Returns a random point in the unit ball, but not at its centre.
    fn in_ball(&mut self) -> DVec3 {
        loop {
            let point = DVec3::from([(); 3].map(|()| self.between(-1.0, 1.0)));
            if (1e-6..=1.0).contains(&point.length_squared()) {
                return point;
            }
        }
    }

    /// Returns a direction in which hair grows: not on the face, which looks along −y, and not on the neck.
    fn on_scalp(&mut self) -> DVec3 {
        loop {
            let out = self.in_ball().normalize();
            if out.z > -0.2 && (out.y > -0.3 || out.z > 0.66) {
                return out;
            }
        }
    }
}

/// Parameters shared by the hairs of a lock.
struct Lock {
    out: DVec3,
    segment: f64,
    curl_radius: f64,
    /// Cosine and sine of the angle at which the curl begins.
    phase: [f64; 2],
}

/// Returns the light, which sways around its direction at [`AT_REST_S`], so slowly that the map's texels crawl over the hairs.
///
/// # Errors
/// [`crate::Error::Usage`] if the time is out of range.
pub(crate) fn lights(time_s: f64) -> Result<Vec<Light>> {
    check_time("hair", time_s)?;
    let swing = |period_s: f64| wave((time_s - AT_REST_S) / period_s);
    let direction = DVec3::new(0.5 + 0.12 * swing(11.0), 0.58, -0.64 + 0.05 * swing(7.0));
    let kind = LightKind::Directional { direction: direction.normalize() };
    Ok(vec![Light { kind, radiance: [1.3; 3], radius: f64::INFINITY }])
}

/// Builds 48,000 segments of 3,000 hairs on an ellipsoid, under a swaying directional light from the front left. The result is
/// bit-identical on every call and machine.
///
/// # Errors
/// Same as [`lights`].
pub(in crate::scene) fn hair(time_s: f64) -> Result<Scene> {
    let lights = lights(time_s)?;
    let mut random = Random(Pcg32::new(SEED[0], SEED[1]));
    let mut strands = Vec::with_capacity(LOCKS * HAIRS_PER_LOCK * SEGMENTS_PER_HAIR);
    for _ in 0..LOCKS {
        let out = random.on_scalp();
        let start = random.in_ball().with_z(0.0).normalize_or(DVec3::X);
        let lock = Lock {
            out,
            segment: random.between(0.10, 0.14),
            curl_radius: random.between(0.03, 0.08),
            phase: [start.x, start.y],
        };
        let guide = grow(&lock, out, 0.1);
        for _ in 0..HAIRS_PER_LOCK {
            let root = (out + 0.16 * random.in_ball()).normalize();
            let hair = grow(&lock, root, random.between(0.02, 0.16));
            let points: Vec<_> =
                curl(&lock, &guide, &hair).iter().map(|p| (*p * HEAD_WORLD).as_vec3().to_array()).collect();
            let strand =
                |ends: &[[f32; 3]]| Strand { start: ends[0], radius: RADIUS_WORLD, end: ends[1], opacity: OPACITY };
            strands.extend(points.windows(2).map(strand));
        }
    }
    Ok(Scene {
        name: "hair".into(),
        strands,
        meshes: vec![head(), floor()],
        lights,
        camera: Camera {
            position: DVec3::new(1.9, -6.2, 0.9),
            target: DVec3::new(0.0, 0.0, -0.32),
            up: DVec3::Z,
            fov_y_degrees: 32.0,
        },
        ..Scene::default()
    })
}

/// Returns the points of a hair from `root` on, before it curls. It grows out of the skin, is combed to the sides and back, then hangs
/// down, but never closer to the skin than `layer`.
fn grow(lock: &Lock, root: DVec3, layer: f64) -> [DVec3; SEGMENTS_PER_HAIR + 1] {
    let comb = DVec3::new(if lock.out.x < 0.0 { -0.5 } else { 0.5 }, 0.35, -0.5);
    let mut points = [root; SEGMENTS_PER_HAIR + 1];
    let mut direction = (root + 0.5 * comb).normalize();
    for i in 1..points.len() {
        let point = points[i - 1] + lock.segment * direction;
        let above = 1.0 + layer.min(0.04 * i as f64);
        points[i] = if point.length() < above { above * point.normalize() } else { point };
        let down = DVec3::new(0.0, 0.0, -1.0);
        direction = (direction + if i < 4 { 0.4 * comb } else { 0.45 * down }).normalize();
    }
    points
}

/// Pulls a hair towards its lock's centre line and winds it; both effects grow with the distance from the root.
fn curl(lock: &Lock, guide: &[DVec3], hair: &[DVec3]) -> Vec<DVec3> {
    let [mut cosine, mut sine] = lock.phase;
    let last = (hair.len() - 1) as f64;
    let mut points = Vec::with_capacity(hair.len());
    for (i, (middle, point)) in guide.iter().zip(hair).enumerate() {
        let along = i as f64 / last;
        let wound = lock.curl_radius * (2.0 * along).min(1.0) * DVec3::new(cosine, sine, 0.0);
        let point = *point + 0.6 * along * (*middle - *point) + wound;
        points.push(if point.length() < 1.01 { 1.01 * point.normalize() } else { point });
        [cosine, sine] = [cosine * CURL[0] - sine * CURL[1], cosine * CURL[1] + sine * CURL[0]];
    }
    points
}

/// Builds the head's ellipsoid: an octahedron whose triangles are divided into four, four times over.
fn head() -> Mesh {
    let sign = |octant: i32, axis: DVec3, bit: i32| if octant & bit == 0 { -axis } else { axis };
    let octant = |i| [sign(i, DVec3::X, 1), sign(i, DVec3::Y, 2), sign(i, DVec3::Z, 4)];
    let mut triangles: Vec<[DVec3; 3]> = (0..8).map(octant).collect();
    for _ in 0..4 {
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let positions: Vec<_> = triangles.iter().flatten().map(|p| (*p * HEAD_WORLD).as_vec3().to_array()).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh { name: "head".into(), positions, triangles, albedo: [0.72, 0.52, 0.42], solid: false, alpha: None }
}

fn floor() -> Mesh {
    let corner = |x: f32, y: f32| [6.0 * x, 6.0 * y, FLOOR_WORLD];
    Mesh {
        name: "floor".into(),
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        albedo: [0.55; 3],
        solid: false,
        alpha: None,
    }
}
