//! The shaded picture against its twin, and forward against deferred shading.

use super::built;
use crate::support::{gpu_test, scenes, spec};
use glam::DVec3;
use gobo::gpu::Context;
use gobo::measure::{Renderer, Shading, picture_error};
use gobo::reference::{Casters, picture};
use gobo::scene::{Camera, Picture, Scene, View};
use gobo::technique::{LightData, SceneData, map_size};

const SIZE: [u32; 2] = [96, 54];

/// The device's picture and the reference's.
fn pictures(context: &Context, scene: &Scene, text: &str, shading: Shading) -> (Picture, Picture) {
    let camera = View::camera(&scene.camera, scene, SIZE);
    let data = SceneData::new(context, scene).expect("room for the scene");
    let light = LightData::new(scene, map_size(&spec(text)));
    let renderer = Renderer::new(context, scene, &data, &light, &camera).expect("a renderer");
    let technique = built(context, scene, text);
    let (drawn, _) = renderer.picture(&technique.visibility(), shading).expect("drawn");
    (drawn, picture(&Casters::new(scene), scene, &camera))
}

fn largest_difference(a: &Picture, b: &Picture) -> f32 {
    a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// A camera that looks down on the middle of a ground larger than the picture: no pixel shows an edge of it.
fn looking_down(scene: Scene) -> Scene {
    let camera = Camera {
        position: DVec3::new(2.0, -3.0, 7.0),
        target: DVec3::new(0.0, 0.0, 0.5),
        up: DVec3::Z,
        fov_y_degrees: 35.0,
    };
    Scene { camera, ..scene }
}

/// Smoke over the ground, so thin that it takes no light but, at `albedo` nearly that of the sky's, is seen.
fn smoke_over_ground(extinction: f32) -> Scene {
    let mut scene = scenes::random();
    for particle in &mut scene.particles {
        particle.position[2] += 1.8;
        particle.extinction *= extinction;
    }
    scene.meshes.push(scenes::level(0.0, 20.0, [0.0, 0.0]));
    looking_down(scene)
}

/// Where no light is lost both shade the same points, so that every pixel must agree.
#[test]
fn shading_equals_its_twin() {
    gpu_test("shading_equals_its_twin", |context| {
        for scene in [smoke_over_ground(1e-4), scenes::spot([3.0, 2.0, 9.0], 120.0, smoke_over_ground(1e-4))] {
            let (drawn, reference) = pictures(context, &scene, "uncompressed:size=64", Shading::Forward);
            let difference = largest_difference(&drawn, &reference);
            println!("{:?}: largest difference {difference:.1e}", scene.light.kind);
            assert!(difference < 2e-3, "{:?}: {difference}", scene.light.kind);
            let sky = gobo::reference::SKY;
            assert!(reference.pixels.iter().all(|p| *p != sky), "the ground fills the picture");
        }
    });
}

/// Dense smoke: what is left is the map's resolution.
#[test]
fn the_picture_is_near_the_reference() {
    gpu_test("the_picture_is_near_the_reference", |context| {
        let scene = Scene::load("three-emitters", 20.0).expect("built in");
        let (drawn, reference) = pictures(context, &scene, "uncompressed:size=400", Shading::Forward);
        let error = picture_error(&drawn, &reference);
        println!("three-emitters: {error:?}");
        assert!(error.rmse < 0.01, "{error:?}");

        // The same picture without shadows is far off: the bound above means something.
        let mut thin = scene.clone();
        thin.particles.iter_mut().for_each(|p| p.extinction *= 1e-4);
        let (unshadowed, _) = pictures(context, &thin, "uncompressed:size=400", Shading::Forward);
        let without = picture_error(&unshadowed, &reference);
        assert!(without.rmse > 5.0 * error.rmse.max(0.01), "{without:?}");
    });
}

/// Deferred shading rebuilds the position from z, off by rounding alone, and covers the same pixels with the same vertex
/// shader: the pictures agree everywhere, silhouettes included.
#[test]
fn forward_and_deferred_agree() {
    gpu_test("forward_and_deferred_agree", |context| {
        let mut scene = smoke_over_ground(1.0);
        scene.meshes.push(scenes::level(1.0, 0.6, [0.4, 0.3]));
        for scene in [scene.clone(), scenes::spot([3.0, 2.0, 9.0], 120.0, scene)] {
            for text in ["uncompressed:size=64", "avsm:size=64,path=two-pass"] {
                let (forward, reference) = pictures(context, &scene, text, Shading::Forward);
                let (deferred, _) = pictures(context, &scene, text, Shading::Deferred);
                let difference = largest_difference(&forward, &deferred);
                println!("{text}, {:?}: largest difference {difference:.1e}", scene.light.kind);
                assert!(difference <= 1e-3, "{text}, {:?}: {difference}", scene.light.kind);
                let error = picture_error(&deferred, &reference);
                assert!(error.rmse < 0.05, "{text}: both may be wrong alike: {error:?}");
            }
        }
    });
}
