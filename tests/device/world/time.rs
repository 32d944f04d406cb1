//! Time: a world that was moved to a time is a world that began then.

use crate::support::{ask, gpu_test, scenes, some, spec};
use crate::world::{build, names, opened, points, world};
use gobo::scene::{LightKind, Scene};
use gobo::world::Generations;

/// From few particles to more and back; lights of `lantern` move with them.
#[test]
fn moved_to_a_time_is_begun_then() {
    gpu_test("moved_to_a_time_is_begun_then", |context| {
        for name in ["three-emitters", "lantern"] {
            let scene = Scene::load(name, 0.5).expect("in range");
            for text in some(["avsm:path=binned,size=24", "psm:path=fused,size=16,slices=32"], 1) {
                let mut world = world(context, &scene);
                let mut moved = opened(context, &world, &spec(text));
                build(&mut moved, &world, text);
                for time_s in [3.0, 1.0] {
                    let before = world.generations().clone();
                    let took = world.move_to(time_s).expect("in range");
                    assert!(world.generations().particles > before.particles && took.host_ns > 0.0);
                    let timed = context.features().timestamp_valid_bits > 0;
                    assert_eq!(took.pass.map(|p| p.name), timed.then(|| "world.move".to_owned()));
                    let then = Scene::load(name, time_s).expect("in range");
                    assert_eq!(world.scene().expect("of a scene"), &then, "{name}, {time_s} s");
                    build(&mut moved, &world, text);
                    let new_world = self::world(context, &then);
                    let mut fresh = opened(context, &new_world, &spec(text));
                    build(&mut fresh, &new_world, text);
                    for light in 0..then.lights.len() {
                        let asked = [&moved, &fresh].map(|o| ask(context, o.technique.as_ref(), light, &points()));
                        assert!(asked[0] == asked[1], "{name}, {text}, {time_s} s, light {light}");
                        assert!(asked[0].iter().any(|v| *v < 1.0), "{name}, {text}, {time_s} s: no shadow");
                    }
                }
            }
        }
    });
}

/// What has no motion stays what it is, whatever the time; what has moves by its own means alone.
#[test]
fn what_stands_still_is_not_moved() {
    gpu_test("what_stands_still_is_not_moved", |context| {
        let mut world = world(context, &scenes::random());
        let mut avsm = opened(context, &world, &spec("avsm:size=16"));
        build(&mut avsm, &world, "first");
        let took = world.move_to(f64::NAN).expect("nothing to do");
        assert_eq!((took.pass, took.host_ns), (None, 0.0));
        assert_eq!(*world.generations(), Generations { lights: vec![0], ..Generations::default() });
        assert!(names(&build(&mut avsm, &world, "again").passes).is_empty());
    });
    let mut scene = Scene::load("lantern", 20.0).expect("in range");
    scene.camera.fov_y_degrees = 11.0;
    let later = scene.at(21.0).expect("in range");
    assert_eq!((later.camera, &later.meshes, later.most_casters()), (scene.camera, &scene.meshes, 1500));
    assert!(later.lights.iter().zip(&scene.lights).all(|(a, b)| a.kind != b.kind && a.radiance == b.radiance));
    // No further in a hundredth of a second than a lantern swings.
    let near = scene.at(20.01).expect("in range");
    for (a, b) in near.lights.iter().zip(&scene.lights) {
        if let (LightKind::Point { position: a }, LightKind::Point { position: b }) = (a.kind, b.kind) {
            assert!((a - b).length() < 0.02, "{a} and {b}");
        }
    }
    assert!(scene.at(-1.0).is_err() && scene.at(f64::NAN).is_err());
}
