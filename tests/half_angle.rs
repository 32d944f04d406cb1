//! Half-angle slicing: the picture against its CPU twin, for cameras before and behind the smoke, and what it comes to with more slices.

#![cfg(feature = "program")]

mod support;

use glam::DVec3;
use gobo::consume::{Lighting, Renderer, Shading};
use gobo::gpu::Context;
use gobo::measure::picture_error;
use gobo::reference::truth::{Casters, picture as truth};
use gobo::reference::twin::half_angle;
use gobo::scene::{Camera, Particle, Picture, Scene, View};
use gobo::technique::{answers_in_space, open};
use gobo::world::World;
use support::scenes::Random;
use support::{gpu_test, scenes, some, spec};

const PIXELS: [u32; 2] = [48, 32];

/// The picture of a technique, the camera, and the light's map where there is one.
fn painted(context: &Context, scene: &Scene, text: &str) -> (Picture, View, Option<View>) {
    let world = World::new(context, scene).expect("room for the scene");
    let mut opened = support::opened(open(context, &world, &spec(text)), text);
    opened.build(&world).expect(text);
    let camera = View::camera(&scene.camera, scene, PIXELS);
    let renderer = Renderer::new(context, &world, &camera).expect("room for the picture");
    let technique = opened.technique.as_ref();
    let first = renderer.picture_of(technique, Shading::Forward, Lighting::Fragment).expect(text);
    let again = renderer.picture_of(technique, Shading::Forward, Lighting::Fragment).expect(text);
    assert!(first == again, "{text}: the second picture differs");
    (first, camera, technique.maps().first().map(|map| map.volume))
}

/// Seen along the light, against it and across.
fn cameras() -> [Camera; 3] {
    let at = |x, y, z| Camera { position: DVec3::new(x, y, z), target: DVec3::ZERO, up: DVec3::Y, fov_y_degrees: 40.0 };
    [at(1.0, 0.5, 6.0), at(-1.0, 0.7, -6.0), at(6.0, 0.5, 0.4)]
}

/// The largest difference of any channel.
fn largest(a: &Picture, b: &Picture) -> f32 {
    let channels = |p: &Picture| p.pixels.concat();
    channels(a).into_iter().zip(channels(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn pictures_equal_their_twins() {
    gpu_test("pictures_equal_their_twins", |context| {
        let smoke = scenes::directional("smoke", [0.1, 0.2, -1.0], scenes::random().particles);
        let spot = scenes::spot([0.3, 0.2, 6.0], 80.0, smoke.clone());
        let mut hair = scenes::strands();
        hair.particles = smoke.particles.clone();
        for scene in some(vec![smoke, spot, hair], 2) {
            for camera in cameras() {
                let scene = Scene { camera, ..scene.clone() };
                for (slices, storage) in [(32, "r32f"), (64, "r16f")] {
                    let text = format!("half-angle:slices={slices},storage={storage},size=24");
                    if !support::runs("pictures_equal_their_twins", context, &text) {
                        continue;
                    }
                    let (painted, camera, view) = painted(context, &scene, &text);
                    let view = view.expect("a map");
                    let twin = half_angle::picture(&Casters::new(&scene), &scene, &camera, &view, slices);
                    let error = picture_error(&painted, &twin);
                    let what = format!("{} {text} from {:?}", scene.name, scene.camera.position);
                    println!("{what}: RMSE {}, largest {}", error.rmse, largest(&painted, &twin));
                    assert!(error.rmse < if storage == "r32f" { 1e-4 } else { 1e-3 }, "{what}: {error:?}");
                }
            }
        }
    });
}

/// Many small spheres, so that a slice of a 128th has more than one.
fn fine() -> Vec<Particle> {
    let mut random = Random::new(34);
    (0..2000).map(|_| Particle { position: random.point(-1.0, 1.0), radius: 0.12, extinction: 0.8 }).collect()
}

/// The more slices, the nearer to the truth: from whichever side it is seen.
#[test]
fn more_slices_are_nearer_to_the_truth() {
    gpu_test("more_slices_are_nearer_to_the_truth", |context| {
        for camera in cameras() {
            let scene = Scene { camera, ..scenes::directional("smoke", [0.1, 0.2, -1.0], fine()) };
            let view = View::camera(&scene.camera, &scene, PIXELS);
            let reference = truth(&Casters::new(&scene), &scene, &view);
            let errors = [32, 64, 128].map(|slices| {
                let (painted, ..) = painted(context, &scene, &format!("half-angle:slices={slices},size=64"));
                picture_error(&painted, &reference).rmse
            });
            let (none, ..) = painted(context, &scene, "none");
            let none = picture_error(&none, &reference).rmse;
            println!("from {:?}: {errors:?}, without shadows {none}", scene.camera.position);
            assert!(errors[0] > errors[1] && errors[1] > errors[2], "{errors:?}");
            assert!(errors[2] < 0.2 * none, "{errors:?} of {none}");
        }
    });
}

/// What it has no answer for is refused by name.
#[test]
fn what_it_cannot_answer_is_refused() {
    gpu_test("what_it_cannot_answer_is_refused", |context| {
        let mut scene = scenes::random();
        let world = World::new(context, &scene).expect("room for the scene");
        let opened = support::opened(open(context, &world, &spec("half-angle:size=16")), "half-angle");
        let error = answers_in_space(opened.technique.as_ref()).expect_err("it paints").to_string();
        assert!(error.contains("paints the picture") && error.lines().count() == 1, "{error}");
        scene.lights.push(scene.lights[0]);
        let world = World::new(context, &scene).expect("room for the scene");
        let error = open(context, &world, &spec("half-angle")).map(|_| ()).expect_err("two lights").to_string();
        assert!(error.contains("one light"), "{error}");
    });
}
