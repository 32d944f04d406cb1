//! The shaded picture against its twin, and forward against deferred shading.

use crate::support::{built, gpu_test, is_left_out, scenes, some};
use glam::DVec3;
use gobo::bench::picture_error;
use gobo::gpu::{Context, PassTime};
use gobo::reference::truth::{Casters, picture};
use gobo::scene::{Camera, Picture, SKY, Scene, Strand, View};
use gobo::shading::{Lighting, Renderer, Shading};
use gobo::world::World;

const SIZE: [u32; 2] = [96, 54];

/// Returns the device's picture.
fn drawn(context: &Context, scene: &Scene, text: &str, shading: Shading) -> Picture {
    let camera = View::camera(&scene.camera, scene, SIZE);
    let world = World::new(context, scene).expect("room for the scene");
    let renderer = Renderer::new(context, &world, &camera).expect("a renderer");
    let technique = built(context, scene, text);
    renderer.picture(&technique.answer(), shading, Lighting::Fragment).expect("drawn")
}

/// Returns the reference's picture.
fn reference(scene: &Scene) -> Picture {
    picture(&Casters::new(scene), scene, &View::camera(&scene.camera, scene, SIZE))
}

fn largest_difference(a: &Picture, b: &Picture) -> f32 {
    a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// A camera looking down at the middle of a ground larger than the picture: no pixel shows its edge.
fn looking_down(scene: Scene) -> Scene {
    let camera = Camera {
        position: DVec3::new(2.0, -3.0, 7.0),
        target: DVec3::new(0.0, 0.0, 0.5),
        up: DVec3::Z,
        fov_y_degrees: 35.0,
    };
    Scene { camera, ..scene }
}

/// Smoke over the ground, so thin that it absorbs no light, yet visible because its `albedo` is nearly the sky's.
fn smoke_over_ground(extinction: f32) -> Scene {
    let mut scene = scenes::random();
    for particle in &mut scene.particles {
        particle.position[2] += 1.8;
        particle.extinction *= extinction;
    }
    scene.meshes.push(scenes::level(0.0, 20.0, [0.0, 0.0]));
    looking_down(scene)
}

/// Without absorption the device and the reference shade the same points, so every pixel must agree.
#[test]
fn shading_equals_its_twin() {
    gpu_test("shading_equals_its_twin", |context| {
        let [one, spot, point] = [
            smoke_over_ground(1e-4),
            scenes::spot([3.0, 2.0, 9.0], 120.0, smoke_over_ground(1e-4)),
            scenes::point([-1.0, 0.5, 3.0], smoke_over_ground(1e-4)),
        ];
        // Different colors, so that mistaking one light for another shows.
        let mut three = one.clone();
        three.lights = [&one, &spot, &point].map(|s| s.lights[0]).to_vec();
        let shines = [([0.5, 0.1, 0.0], f64::INFINITY), ([0.0, 0.6, 0.2], 11.0), ([0.3, 0.0, 0.7], 4.0)];
        for (light, shines) in three.lights.iter_mut().zip(shines) {
            (light.radiance, light.radius) = shines;
        }
        for scene in [one, spot, point, three] {
            let drawn = drawn(context, &scene, "uncompressed:size=64", Shading::Forward);
            let reference = reference(&scene);
            let difference = largest_difference(&drawn, &reference);
            println!("{:?}: largest difference {difference:.1e}", scene.lights);
            assert!(difference < 2e-3, "{:?}: {difference}", scene.lights);
            assert!(reference.pixels.iter().all(|p| *p != SKY), "the ground fills the picture");
        }
    });
}

/// A layer of strands across the light: none shadows another, so pictures differ only where rounding decides whether a pixel's ray hits a
/// ribbon.
#[test]
fn strands_are_drawn_where_the_reference_has_them() {
    gpu_test("strands_are_drawn_where_the_reference_has_them", |context| {
        let mut random = scenes::Random::new(21);
        let mut scene = looking_down(scenes::directional("layer", [0.0, 0.0, -1.0], Vec::new()));
        for _ in 0..150 {
            let [x, y, dx] = random.point(-1.5, 1.5);
            let dy = random.between(-1.5, 1.5);
            let opacity = random.between(0.2, 1.0);
            scene.strands.push(Strand { start: [x, y, 1.0], radius: 0.04, end: [x + dx, y + dy, 1.0], opacity });
        }
        let drawn = drawn(context, &scene, "uncompressed:size=64", Shading::Forward);
        let reference = reference(&scene);
        let apart = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).any(|i| (a[i] - b[i]).abs() > 2e-3);
        let differing = drawn.pixels.iter().zip(&reference.pixels).filter(|p| apart(*p)).count();
        let covered = reference.pixels.iter().filter(|p| **p != SKY).count();
        println!("{differing} pixels differ of {covered} that are covered");
        assert!(covered > 1000, "{covered} pixels are covered");
        assert!(differing <= 2, "{differing} of {covered} pixels differ");
        // Fully lit: a strand does not shadow itself.
        let brightest = drawn.pixels.iter().map(|p| p[0]).fold(0.0, f32::max);
        assert!((brightest - 0.70 * 1.10).abs() < 0.03, "{brightest}");
    });
}

/// Dense smoke: the remaining error is the map's resolution.
#[test]
fn the_picture_is_near_the_reference() {
    let name = "the_picture_is_near_the_reference";
    if is_left_out(name) {
        return;
    }
    gpu_test(name, |context| {
        let scene = Scene::load("three-emitters", 20.0).expect("built in");
        let reference = reference(&scene);
        let error = picture_error(&drawn(context, &scene, "uncompressed:size=400", Shading::Forward), &reference);
        println!("three-emitters: {error:?}");
        assert!(error.rmse < 0.01, "{error:?}");

        // The same picture without shadows is far off, so the bound above is meaningful.
        let mut thin = scene.clone();
        thin.particles.iter_mut().for_each(|p| p.extinction *= 1e-4);
        let unshadowed = drawn(context, &thin, "uncompressed:size=400", Shading::Forward);
        let without = picture_error(&unshadowed, &reference);
        assert!(without.rmse > 5.0 * error.rmse.max(0.01), "{without:?}");
    });
}

/// Forward and deferred shade exactly the point where a pixel's ray hits the triangle (glsl/shading/surface.glsl), for the same pixels: the
/// pictures agree everywhere, including silhouettes and shadow edges, up to the rounding of sums.
#[test]
fn forward_and_deferred_agree() {
    if crate::support::is_costly("forward_and_deferred_agree") {
        return;
    }
    gpu_test("forward_and_deferred_agree", |context| {
        let mut scene = smoke_over_ground(1.0);
        scene.meshes.push(scenes::level(1.0, 0.6, [0.4, 0.3]));
        let spot = scenes::spot([3.0, 2.0, 9.0], 120.0, scene.clone());
        let point = scenes::point([-1.0, 0.5, 3.0], scene.clone());
        let mut three = scene.clone();
        three.lights = [&scene, &spot, &point].map(|s| s.lights[0]).to_vec();
        for scene in some([three, scene, spot, point], 1) {
            let reference = reference(&scene);
            for text in ["uncompressed:size=64", "avsm:size=64,path=two-pass"] {
                let deferred = drawn(context, &scene, text, Shading::Deferred);
                let difference = largest_difference(&drawn(context, &scene, text, Shading::Forward), &deferred);
                println!("{text}, {:?}: largest difference {difference:.1e}", scene.lights[0].kind);
                assert!(difference <= 1e-5, "{text}, {:?}: {difference}", scene.lights[0].kind);
                let error = picture_error(&deferred, &reference);
                assert!(error.rmse < 0.05, "{text}: both may be wrong alike: {error:?}");
            }
        }
    });
}

/// A picture drawn a few casters at a time, as slow pictures are on a GPU, equals one drawn in a single submission.
#[test]
fn a_picture_in_parts_is_the_same() {
    gpu_test("a_picture_in_parts_is_the_same", |context| {
        let smoke = smoke_over_ground(1.0);
        // Particles in front of and behind a volume, and a volume alone.
        let cloud = looking_down(Scene::load("cloud:samples=8", 0.0).expect("built in"));
        let both = Scene { particles: smoke.particles.clone(), ..cloud.clone() };
        let lit = scenes::point([-1.0, 0.5, 3.0], smoke.clone());
        let mut two = smoke.clone();
        two.lights.extend(lit.lights);
        let cases = [
            (two, "uncompressed:size=64"),
            (both, "beer-shadow-map:size=32"),
            (Scene::load("ink", 0.0).expect("built in"), "beer-shadow-map:size=32"),
            (cloud, "beer-shadow-map:size=32"),
            (smoke, "half-angle:size=32"),
        ];
        for (scene, spec) in some(cases, 2) {
            let camera = View::camera(&scene.camera, &scene, SIZE);
            let world = World::new(context, &scene).expect("room for the scene");
            let renderer = Renderer::new(context, &world, &camera).expect("a renderer");
            let technique = built(context, &scene, spec);
            for shading in [Shading::Forward, Shading::Deferred, Shading::Interleaved] {
                let kernels = renderer.kernels_of(&*technique, shading, Lighting::Fragment).expect("kernels");
                // A GPU may draw the first picture in parts, and the second in one.
                let [_, whole] = [(); 2].map(|()| renderer.draw(&kernels).expect("drawn"));
                let picture = renderer.read().expect("read");
                assert!(picture.pixels.iter().any(|p| *p != SKY && *p != picture.pixels[0]), "{spec} shows something");
                for count in [1, 5, 100_000] {
                    let times = renderer.draw_in_parts(&kernels, count).expect("drawn");
                    assert!(renderer.read().expect("read") == picture, "{spec}, {shading:?}, {count} at first");
                    assert!(times.windows(2).all(|pair| pair[0].end_ns <= pair[1].start_ns), "one after the other");
                    let passes = |times: &[PassTime]| times.iter().filter(|pass| pass.name == "shading.caster").count();
                    let is_part = passes(&whole) > 0 && count < 100_000 && !scene.particles.is_empty();
                    assert_eq!(passes(&times) > passes(&whole), is_part, "{spec}, {count}");
                }
            }
        }
    });
}
