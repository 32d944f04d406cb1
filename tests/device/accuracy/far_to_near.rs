//! The order in which a picture blends casters, as sorted on the device: against its twin, against the host's order, and in pictures.

use crate::support::scenes::{self, Random};
use crate::support::{all, built, gpu_test, ran, some};
use glam::{DVec2, DVec3, Vec3};
use gobo::gpu::Context;
use gobo::reference::truth::{Casters, picture};
use gobo::reference::twin::far_to_near::{far_to_near as keys, order};
use gobo::scene::{Camera, Particle, Picture, Scene, Splat, Strand, View, far_to_near};
use gobo::shading::{FarToNear, Lighting, Renderer, Shading};
use gobo::world::World;
use std::time::Instant;

const SIZE: [u32; 2] = [64, 36];

fn view(scene: &Scene) -> View {
    View::camera(&scene.camera, scene, SIZE)
}

fn from(position: DVec3, target: DVec3) -> Camera {
    Camera { position, target, up: DVec3::new(0.1, 0.9, 0.3), fov_y_degrees: 40.0 }
}

/// Sorts a world's casters, and returns their order.
fn sorted(context: &Context, sorts: &FarToNear, world: &World, camera: &View) -> Vec<u32> {
    ran(context, |commands| sorts.record(commands, camera, world.caster_count()));
    sorts.sorted().read(world.caster_count() as usize).expect("read")
}

/// Returns the device's order of a scene.
fn of_scene(context: &Context, scene: &Scene) -> Vec<u32> {
    let world = World::new(context, scene).expect("room");
    sorted(context, &FarToNear::new(context, &world).expect("room"), &world, &view(scene))
}

/// Asserts that each caster occurs once, that none comes before a farther one except by rounding, and that identical casters are in index
/// order.
fn check(scene: &Scene, camera: &View, sorted: &[u32]) {
    let casters = scene.casters();
    let mut seen = sorted.to_vec();
    seen.sort_unstable();
    assert!(seen.into_iter().eq(0..casters.len() as u32), "{}: each once", scene.name);
    let middle = |i: u32| 0.5 * (casters[i as usize].start() + casters[i as usize].end());
    let far = |i: u32| (middle(i) - Vec3::from(camera.origin).as_dvec3()).abs().max_element();
    for pair in sorted.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let nearer = camera.project(middle(b)).1 - camera.project(middle(a)).1;
        let rounding = 8.0 * f64::from(f32::EPSILON) * far(a).max(far(b));
        assert!(nearer <= rounding, "{}: {a} comes before {b}, {nearer} farther", scene.name);
        let alike = casters[a as usize] == casters[b as usize];
        assert!(!alike || a < b, "{}: {pair:?} are alike", scene.name);
    }
}

/// Smoke, hair and splats are sorted far to near after camera and world have moved: seen from within, from far away, and far from the
/// origin.
#[test]
fn casters_come_far_to_near() {
    gpu_test("casters_come_far_to_near", |context| {
        let mut mixed = scenes::splats();
        mixed.particles.extend(scenes::random().particles);
        mixed.strands = scenes::strands().strands;
        let mut away = scenes::random();
        away.particles.iter_mut().for_each(|p| p.position[0] += 3e4);
        away.camera = from(DVec3::new(3e4, -5.0, 2.0), DVec3::new(3e4, 0.0, 0.0));
        for scene in [mixed, scenes::strands(), scenes::duplicates(), scenes::splats(), away] {
            let mut world = World::new(context, &scene).expect("room");
            let sorts = FarToNear::new(context, &world).expect("room");
            let mut fewer = scene.clone();
            fewer.particles.truncate(scene.particles.len() / 2);
            fewer.splats.truncate(scene.splats.len() / 2);
            for mut state in [scene.clone(), fewer] {
                world.replace(&state).expect("as many or fewer");
                let target = state.camera.target;
                for offset in [DVec3::new(4.0, 1.0, 2.0), DVec3::new(-3.0, 0.2, -5.0), DVec3::new(1e-3, 0.1, 0.0)] {
                    state.camera = from(target + offset, target);
                    let camera = view(&state);
                    check(&state, &camera, &sorted(context, &sorts, &world, &camera));
                }
            }
        }
    });
}

/// A camera at z = 10 that looks along −z, so that a caster's depth follows exactly from its z.
fn along_z(depths: impl Iterator<Item = f32>) -> Scene {
    let mut random = Random::new(5);
    let particle = |depth: f32| {
        let [x, y, _] = random.point(-1.0, 1.0);
        Particle { position: [x, y, 10.0 - depth], radius: 0.1, extinction: 1.0 }
    };
    let mut scene = scenes::directional("along z", [0.0, 0.0, -1.0], depths.map(particle).collect());
    scene.camera = Camera { position: 10.0 * DVec3::Z, target: DVec3::ZERO, up: DVec3::Y, fov_y_degrees: 40.0 };
    scene
}

/// With exact depths the order equals the twin's and the host's; ties are ordered by value or, in long runs, by index. Tested with few
/// depths and many, in front of the camera and behind it, rising, falling and all equal, in lists longer than the sort's blocks.
#[test]
fn the_order_is_the_twins_and_the_hosts() {
    gpu_test("the_order_is_the_twins_and_the_hosts", |context| {
        for count in some([1u32, 2, 127, 129, 1023, 1025, 5000, 70_000], if all() { 8 } else { 7 }) {
            let mut random = Random::new(u64::from(count));
            let scattered: Vec<f32> = (0..count).map(|_| 0.25 * random.between(-40.0, 400.0).floor() + 0.125).collect();
            let cases = [
                along_z(scattered.into_iter()),
                along_z((0..count).map(|i| (i % 3) as f32 + 0.5)),
                along_z((0..count).map(|i| 0.125 + 0.0625 * i as f32)),
                along_z((0..count).map(|i| 0.125 + 0.0625 * (count - i) as f32)),
                along_z((0..count).map(|_| 4.5)),
            ];
            for (case, scene) in cases.iter().enumerate() {
                let (is, camera) = (of_scene(context, scene), view(scene));
                let casters = scene.casters();
                let twin = order(&keys(&camera, &casters), &casters);
                assert!(is == twin, "{count} casters, case {case}: not the twin's");
                assert!(is == far_to_near(scene, &camera).casters, "{count} casters, case {case}: not the host's");
            }
        }
    });
}

/// From any camera, casters whose depths differ by a hundred times the rounding error are in the order of the f64 reference.
#[test]
fn what_is_apart_is_as_the_host_has_it() {
    gpu_test("what_is_apart_is_as_the_host_has_it", |context| {
        let mut random = Random::new(11);
        let rounds = if all() { 12 } else { 3 };
        for round in 0..rounds {
            let [eye, target] = [0, 1].map(|_| Vec3::from(random.point(-9.0, 9.0)).as_dvec3());
            let camera = from(eye, target);
            let mut scene = Scene { camera, ..scenes::directional("apart", [0.0, 0.0, -1.0], Vec::new()) };
            let mut depths: Vec<f64> = (0..3000).map(|i| 0.01 * f64::from(i) - 3.0).collect();
            for i in (1..depths.len()).rev() {
                depths.swap(i, random.between(0.0, i as f32) as usize);
            }
            let seen = view(&scene);
            let [right, up, forward] = [seen.right, seen.up, seen.forward].map(|axis| Vec3::from(axis).as_dvec3());
            for (i, depth) in depths.into_iter().enumerate() {
                let [x, y, w] = random.point(-3.0, 3.0).map(f64::from);
                let middle = eye + depth * forward + x * right + y * up;
                if i % 3 == 0 {
                    let half = w * right + 0.5 * y * forward;
                    let [start, end] = [middle - half, middle + half].map(|end| end.as_vec3().into());
                    scene.strands.push(Strand { start, radius: 0.1, end, opacity: 0.5 });
                } else {
                    let position = middle.as_vec3().into();
                    scene.particles.push(Particle { position, radius: 0.1, extinction: 1.0 });
                }
            }
            let order = of_scene(context, &scene);
            assert!(order == far_to_near(&scene, &view(&scene)).casters, "round {round}, {camera:?}");
        }
    });
}

fn largest_difference(a: &Picture, b: &Picture) -> f32 {
    a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// A row of dense balls, each of a single color, lit by the sky alone so that none shadows another.
fn colored_row() -> Scene {
    let mut scene = scenes::directional("row", [0.2, 0.1, -1.0], Vec::new());
    scene.lights[0].radiance = [0.0; 3];
    for i in 0..12u8 {
        let place = f32::from(i * 7 % 12);
        let color = [f32::from(i % 2), f32::from(i / 2 % 2), f32::from(i / 4 % 2)];
        let position = [0.3 * place - 1.7, 0.05 * place, 0.02 * place];
        let rotation = [1.0, 0.0, 0.0, 0.0];
        scene.splats.push(Splat { position, deviations: [0.3; 3], rotation, opacity: 0.9, color });
    }
    scene
}

/// Returns an error bound on a pixel's color against the reference's. On the device a ball ends at 3 deviations, with correspondingly more
/// extinction within (SPLAT_WHOLE in glsl/world/splat.glsl); in the reference it ends at 5. The color is linear in each ball's
/// transmittance.
fn ends(scene: &Scene, camera: &View, pixel: usize, brightest: f32) -> f32 {
    const WHOLE: f64 = 1.011_234_52;
    let at = DVec2::new((pixel % SIZE[0] as usize) as f64 + 0.5, (pixel / SIZE[0] as usize) as f64 + 0.5);
    let ray = camera.ray(at);
    let differ = scene.splats.iter().map(|ball| {
        let to = DVec3::from(ball.position.map(f64::from)) - ray.origin;
        let beside = to.reject_from(ray.direction).length() / f64::from(ball.deviations[0]);
        let depth = -(1.0 - f64::from(ball.opacity)).ln() * (-0.5 * beside * beside).exp();
        let through = |depth: f64| (-depth).exp();
        let [inside, outside] = [through(depth) - through(WHOLE * depth), 1.0 - through(depth)];
        if beside < 2.99 { inside } else { inside.max(outside) }
    });
    differ.sum::<f64>() as f32 * brightest
}

/// Moves the camera around a row of balls of many colors with one renderer: each picture equals a new renderer's to the bit, and the
/// reference up to rounding. Colors differ from one end of the row to the other, so a wrong order would show. The sort runs only if
/// something has moved.
#[test]
fn a_moving_camera_sees_them_in_order() {
    gpu_test("a_moving_camera_sees_them_in_order", |context| {
        let scene = colored_row();
        let at = |camera: Camera| Scene { camera, ..scene.clone() };
        let technique = built(context, &scene, "none");
        let answer = technique.answer();
        let mut world = World::new(context, &scene).expect("room");
        let mut renderer = Renderer::new(context, &world, &view(&scene)).expect("a renderer");
        let kernels = renderer.kernels(&answer, Shading::Forward, Lighting::Fragment).expect("kernels");
        let mut drawn = |world: &World, state: &Scene, sorts: bool| {
            renderer.look(world, &view(state)).expect("the next frame");
            for sorts in [sorts, false] {
                let passes = renderer.draw(&kernels).expect("drawn");
                let is_sorted = passes.iter().any(|pass| pass.name == "shading.far_to_near");
                assert!(passes.is_empty() || is_sorted == sorts, "{passes:?}");
            }
            renderer.read().expect("read")
        };
        let fresh = |world: &World, state: &Scene| {
            let renderer = Renderer::new(context, world, &view(state)).expect("a renderer");
            renderer.picture(&answer, Shading::Forward, Lighting::Fragment).expect("drawn")
        };
        let mut pictures = Vec::new();
        for turn in 0..9 {
            let angle = std::f64::consts::TAU * f64::from(turn) / 8.0 + 0.1;
            let state = at(from(DVec3::new(6.0 * angle.cos(), 6.0 * angle.sin(), 1.0), DVec3::ZERO));
            let is = drawn(&world, &state, true);
            assert!(is == fresh(&world, &state), "turn {turn}: another picture than that of a new renderer");
            let truth = picture(&Casters::new(&state), &state, &view(&state));
            let brightest = truth.pixels.iter().flatten().copied().fold(0.0, f32::max);
            // If the device cannot blend floats, each ball is blended into a half float.
            let blended = state.splats.len() as f32 * brightest / 2048.0;
            let rounding = if context.features().float32_blend { 1e-5 } else { blended };
            let mut certain = 0;
            for (i, (is, truth)) in is.pixels.iter().zip(&truth.pixels).enumerate() {
                let off = is.iter().zip(truth).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                let ends = ends(&state, &view(&state), i, brightest);
                certain += usize::from(ends < 0.02);
                assert!(off < ends + rounding, "turn {turn}: pixel {i} is off by {off}, {ends} of it for ends");
            }
            assert!(certain > is.pixels.len() / 2, "turn {turn}: {certain} pixels are held closely");
            pictures.push(is);
        }
        assert!(largest_difference(&pictures[0], &pictures[8]) < 2e-3, "all the way round");
        assert!(largest_difference(&pictures[0], &pictures[4]) > 0.05, "both ends look alike");
        // The world moves while the camera does not.
        let mut state = at(from(DVec3::new(6.0, 1.0, 1.0), DVec3::ZERO));
        world.replace(&state).expect("the same casters");
        let before = drawn(&world, &state, true);
        assert!(drawn(&world, &state, false) == before, "nothing has moved");
        state.splats.reverse();
        let half = state.splats.len() / 2;
        state.splats.iter_mut().for_each(|g| g.position[0] *= -1.0);
        state.splats.truncate(half);
        world.replace(&state).expect("fewer casters");
        let is = drawn(&world, &state, true);
        assert!(is == fresh(&world, &state), "after the world has moved");
        assert!(largest_difference(&is, &before) > 0.05, "as before it moved");
    });
}

/// Prints the time that the host and the device take to sort splats for a camera.
#[test]
#[ignore = "measures"]
fn how_long_sorting_takes() {
    gpu_test("how_long_sorting_takes", |context| {
        for count in [6_000, 150_000, 1_000_000] {
            let scene = Scene::load(&format!("splats:count={count}"), 0.0).expect("built in");
            let (world, camera) = (World::new(context, &scene).expect("room"), view(&scene));
            let sorts = FarToNear::new(context, &world).expect("room");
            let least = |run: &dyn Fn() -> f64| (0..5).map(|_| run()).fold(f64::INFINITY, f64::min);
            let host_ms = least(&|| {
                let start = Instant::now();
                assert_eq!(far_to_near(&scene, &camera).casters.len(), count);
                1e3 * start.elapsed().as_secs_f64()
            });
            let device_ms = least(&|| {
                let passes = context.submit(|commands| sorts.record(commands, &camera, count as u32)).expect("sorted");
                passes.last().map_or(f64::NAN, |last| 1e-6 * last.end_ns)
            });
            println!("{count} splats: host {host_ms:.2} ms, device {device_ms:.2} ms");
        }
    });
}
