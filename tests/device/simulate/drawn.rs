//! Drawing simulated particles: the right number of triangles in the right places, in the colors of their speeds, in front of and behind
//! meshes.

use crate::support::{ask, built, gpu_test, runs, scenes, scenes::Random};
use glam::{DVec2, DVec3};
use gobo::gpu::{Buffer, Context};
use gobo::scene::{Body, Mesh, Picture, Scene, View};
use gobo::shading::{Colors, Lighting, Renderer, Shading};
use gobo::technique::Technique;
use gobo::world::World;

const SIZE: [u32; 2] = [96, 64];
const FASTEST: f32 = 0.2;
const TECHNIQUE: &str = "beer-shadow-map:path=binned,size=32";

/// Distance from an edge, in pixels, within which a pixel's coverage is undecided: rasterizers have as few as four subpixel bits.
const EDGE: f64 = 0.15;

/// Smoke over a plate that hides everything below it.
fn scene() -> Scene {
    let mut scene = scenes::random();
    scene.meshes = vec![Mesh {
        name: "plate".into(),
        positions: vec![[-0.8, -0.8, 0.1], [0.8, -0.8, 0.1], [0.8, 0.8, 0.1], [-0.8, 0.8, 0.1]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        albedo: [0.5; 3],
        solid: false,
        alpha: None,
    }];
    scene
}

fn bodies(count: usize, radius: [f32; 2]) -> Vec<Body> {
    let mut random = Random::new(count as u64);
    let mut body = || {
        let [x, y, z] = random.point(-1.2, 1.2);
        let [u, v, w] = random.point(-0.12, 0.12);
        Body { place: [x, y, z, random.between(radius[0], radius[1])], speed: [u, v, w, 1.0] }
    };
    (0..count).map(|_| body()).collect()
}

/// Returns the picture and the counts.
fn drawn(
    context: &Context,
    scene: &Scene,
    lit: &dyn Technique,
    bodies: &[Body],
    colors: Colors,
) -> (Picture, Vec<f32>) {
    let world = World::new(context, scene).expect("room");
    let buffer = Buffer::with_data(context, "bodies", bodies).expect("room");
    let renderer = Renderer::new(context, &world, &View::camera(&scene.camera, scene, SIZE)).expect("room");
    let answer = lit.answer();
    let kernels = renderer.kernels(&answer, Shading::Forward, Lighting::Fragment).expect("kernels");
    let points = renderer.points(&answer, &buffer, bodies.len() as u32, colors).expect("kernels");
    renderer.draw_points(&kernels, &points).expect("drawn");
    (renderer.read().expect("read"), renderer.counts(&points).expect("read"))
}

/// Returns whether a body's triangle of this size covers a pixel's centre, `None` if that is undecided near its edge, and the triangle's z.
fn covers(camera: &View, body: &Body, size: f64, pixel: DVec2) -> (Option<bool>, f64) {
    let vec = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let [x, y, z, radius] = body.place;
    let corner = |turn: [f64; 2]| {
        let across = vec(camera.right) * turn[0] + vec(camera.up) * turn[1];
        camera.project(vec([x, y, z]) + size * f64::from(radius) * across)
    };
    let half = 0.75f64.sqrt();
    let [(a, depth), (b, _), (c, _)] = [[0.0, 1.0], [-half, -0.5], [half, -0.5]].map(corner);
    let inside = |from: DVec2, to: DVec2| (to - from).perp_dot(pixel - from) / (to - from).length();
    let turn = (b - a).perp_dot(c - a).signum();
    let least = [inside(a, b), inside(b, c), inside(c, a)].map(|d| d * turn).into_iter().fold(f64::INFINITY, f64::min);
    ((least.abs() > EDGE).then_some(least > 0.0), depth)
}

/// Returns the plate's z at a pixel, infinity beside the plate, or `None` near its edges.
fn plate(camera: &View, pixel: DVec2) -> Option<f64> {
    let ray = camera.ray(pixel);
    let z = (f64::from(0.1f32) - ray.origin.z) / ray.direction.z;
    let at = ray.at(z);
    match at.x.abs().max(at.y.abs()) {
        far if far < 0.77 => Some(z),
        far if far > 0.83 => Some(f64::INFINITY),
        _ => None,
    }
}

#[test]
fn as_many_are_counted_as_cover_a_pixel() {
    gpu_test("as_many_are_counted_as_cover_a_pixel", |context| {
        if !runs("as_many_are_counted_as_cover_a_pixel", context, TECHNIQUE) {
            return;
        }
        let scene = scene();
        let lit = built(context, &scene, TECHNIQUE);
        let camera = View::camera(&scene.camera, &scene, SIZE);
        let bodies = bodies(120, [0.1, 0.5]);
        let (picture, counts) = drawn(context, &scene, lit.as_ref(), &bodies, Colors::Density { many: 4.0 });
        let (_, none) = drawn(context, &scene, lit.as_ref(), &[], Colors::Density { many: 4.0 });
        assert!(none.iter().all(|count| *count == 0.0) && none.len() == counts.len());
        let (mut checked, mut most, mut hidden) = (0, 0, 0);
        for (i, count) in counts.iter().enumerate() {
            let pixel = DVec2::new((i % 96) as f64 + 0.5, (i / 96) as f64 + 0.5);
            let Some(mesh) = plate(&camera, pixel) else { continue };
            let all: Vec<_> = bodies.iter().map(|body| covers(&camera, body, 1.0, pixel)).collect();
            // Pixels are skipped where a body's coverage is undecided, or where its depth is too close to the plate's.
            if all.iter().any(|(covers, z)| *covers != Some(false) && (covers.is_none() || (z - mesh).abs() < 1e-3)) {
                continue;
            }
            let covering = all.iter().filter(|(covers, _)| *covers == Some(true));
            let seen = covering.clone().filter(|(_, z)| *z < mesh).count();
            assert_eq!(*count, seen as f32, "at {pixel}");
            (checked, most, hidden) = (checked + 1, most.max(seen), hidden + covering.count() - seen);
        }
        assert!(checked > 1500 && most > 5 && hidden > 50, "{checked} checked, {most} at most, {hidden} hidden");
        assert!(picture.pixels.iter().flatten().all(|c| (0.0..=1.0).contains(c)));
    });
}

/// Returns the shader's color, from slow to fast.
fn ramp(share: f64) -> [f64; 3] {
    let ramp = [[0.02, 0.10, 0.45], [0.03, 0.55, 0.65], [0.95, 0.80, 0.25], [1.0, 0.22, 0.06]];
    let at = 3.0 * share.min(1.0);
    let first = (at as usize).min(2);
    let part = at - first as f64;
    [0, 1, 2].map(|i| ramp[first][i] * (1.0 - part) + ramp[first + 1][i] * part)
}

#[test]
fn the_nearest_has_the_color_of_its_speed() {
    gpu_test("the_nearest_has_the_color_of_its_speed", |context| {
        if !runs("the_nearest_has_the_color_of_its_speed", context, TECHNIQUE) {
            return;
        }
        let scene = scene();
        let lit = built(context, &scene, TECHNIQUE);
        let camera = View::camera(&scene.camera, &scene, SIZE);
        let bodies = bodies(60, [0.5, 1.4]);
        let (picture, _) = drawn(context, &scene, lit.as_ref(), &bodies, Colors::Speed { fastest: FASTEST });
        let (empty, _) = drawn(context, &scene, lit.as_ref(), &[], Colors::Speed { fastest: FASTEST });
        let middles: Vec<_> = bodies.iter().map(|b| [b.place[0], b.place[1], b.place[2]]).collect();
        let visible = ask(context, lit.as_ref(), 0, &middles);
        let (mut colored, mut free) = (0, 0);
        for (i, color) in picture.pixels.iter().enumerate() {
            let pixel = DVec2::new((i % 96) as f64 + 0.5, (i / 96) as f64 + 0.5);
            let Some(mesh) = plate(&camera, pixel) else { continue };
            let all: Vec<_> = bodies.iter().map(|body| covers(&camera, body, 0.5, pixel)).collect();
            if all.iter().any(|(covers, z)| *covers != Some(false) && (covers.is_none() || (z - mesh).abs() < 1e-3)) {
                continue;
            }
            let covering = all.iter().enumerate().filter(|(_, (covers, z))| *covers == Some(true) && *z < mesh);
            let Some((nearest, (_, z))) = covering.clone().min_by(|a, b| a.1.1.total_cmp(&b.1.1)) else {
                assert_eq!(*color, empty.pixels[i], "nothing is before {pixel}");
                free += 1;
                continue;
            };
            // A depth near 1 has 24 bits: the nearer of two is undecided if they differ by only a few steps.
            let step = z * z / f64::from(camera.near) * (0.5f64).powi(24);
            if covering.filter(|(_, (_, other))| other - z < 8.0 * step).count() > 1 {
                continue;
            }
            let speed = bodies[nearest].speed[..3].iter().map(|s| f64::from(*s).powi(2)).sum::<f64>().sqrt();
            let ambient = [0.10, 0.12, 0.15];
            for c in 0..3 {
                let expected = ramp(speed / f64::from(FASTEST))[c] * (ambient[c] + f64::from(visible[nearest]));
                let off = (f64::from(color[c]) - expected).abs();
                assert!(off < 2e-3 * expected.max(0.1), "{pixel}: {color:?}, {expected} of {nearest}");
            }
            colored += 1;
        }
        assert!(colored > 300 && free > 500, "{colored} colored, {free} free");
    });
}
