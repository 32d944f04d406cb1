//! Time: a world moved to a time equals a world created at that time.

use crate::support::{ask, gpu_test, scenes, some, spec};
use crate::world::{build, names, opened, points, world};
use glam::DVec3;
use gobo::animate::{Animated, AnimatedScene, SceneParts};
use gobo::scene::{Light, LightKind, Mesh, Particle, Scene};
use gobo::world::Generations;

/// In a world moved from few particles to more and back, look-ups equal those in a world created at that time, also for the moving lights
/// of `lantern`.
#[test]
fn moved_to_a_time_is_begun_then() {
    gpu_test("moved_to_a_time_is_begun_then", |context| {
        for name in ["three-emitters", "lantern"] {
            let scene = AnimatedScene::load(name, 0.5).expect("in range");
            for text in some(["avsm:path=binned,size=24", "psm:path=fused,size=16,slices=32"], 1) {
                let mut world = world(context, &scene.scene);
                let mut moved = opened(context, &world, &spec(text));
                build(&mut moved, &world, text);
                for time_s in [3.0, 1.0] {
                    let before = world.generations().clone();
                    let took = scene.move_world(&mut world, time_s).expect("in range");
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

/// Scenes without motion stay the same at any time; those with motion change only their moving parts.
#[test]
fn what_stands_still_is_not_moved() {
    gpu_test("what_stands_still_is_not_moved", |context| {
        let still = AnimatedScene::from(scenes::random());
        let mut world = world(context, &still.scene);
        let mut avsm = opened(context, &world, &spec("avsm:size=16"));
        build(&mut avsm, &world, "first");
        let took = still.move_world(&mut world, f64::NAN).expect("nothing to do");
        assert_eq!((took.pass, took.host_ns), (None, 0.0));
        assert_eq!(*world.generations(), Generations { lights: vec![0], ..Generations::default() });
        assert!(names(&build(&mut avsm, &world, "again").passes).is_empty());
    });
    let mut lantern = AnimatedScene::load("lantern", 20.0).expect("in range");
    lantern.scene.camera.fov_y_degrees = 11.0;
    let later = lantern.at(21.0).expect("in range");
    let scene = &lantern.scene;
    assert_eq!((later.camera, &later.meshes, later.most_casters()), (scene.camera, &scene.meshes, 1500));
    assert!(later.lights.iter().zip(&scene.lights).all(|(a, b)| a.kind != b.kind && a.radiance == b.radiance));
    // In a hundredth of a second, a light moves no farther than a lantern swings.
    let near = lantern.at(20.01).expect("in range");
    for (a, b) in near.lights.iter().zip(&scene.lights) {
        if let (LightKind::Point { position: a }, LightKind::Point { position: b }) = (a.kind, b.kind) {
            assert!((a - b).length() < 0.02, "{a} and {b}");
        }
    }
    assert!(lantern.at(-1.0).is_err() && lantern.at(f64::NAN).is_err());
}

/// A ball that swings over a rising plate; the light turns.
#[derive(Debug)]
struct Swing;

impl Animated for Swing {
    fn at(&self, scene: &Scene, time_s: f64) -> gobo::Result<SceneParts> {
        let mut meshes = scene.meshes.clone();
        meshes[0].positions.iter_mut().for_each(|corner| corner[2] = -2.0 + 0.1 * time_s as f32);
        let ball = |i: u32| Particle { position: [time_s.sin() as f32, i as f32, 0.5], radius: 0.4, extinction: 3.0 };
        let direction = DVec3::new(0.1 * time_s, 0.0, -1.0).normalize();
        let lights = vec![Light { kind: LightKind::Directional { direction }, ..scene.lights[0] }];
        Ok(SceneParts {
            particles: Some((0..1 + time_s as u32).map(ball).collect()),
            meshes: Some(meshes),
            lights: Some(lights),
            ..SceneParts::default()
        })
    }
}

/// A custom scene moves as built-in ones do: at each time its world equals one created then. A world has no room for casters that the scene
/// does not reserve.
#[test]
fn a_scene_of_ones_own_moves() {
    let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
    let plate = Mesh {
        name: "plate".into(),
        positions,
        triangles: vec![[0, 1, 2]],
        albedo: [0.5; 3],
        solid: false,
        alpha: None,
    };
    let scene = Scene { meshes: vec![plate], ..Scene::default() };
    assert_eq!(AnimatedScene::from(scene.clone()).fingerprint(), scene.fingerprint());
    let unreserved = AnimatedScene::new(scene, Swing);
    assert_ne!(unreserved.fingerprint(), unreserved.scene.fingerprint());
    let mut own = unreserved.clone();
    own.scene.reserve.particles = 4;
    assert!(own.moves() && own.fountain().is_none());
    gpu_test("a_scene_of_ones_own_moves", |context| {
        let text = "avsm:path=binned,size=24";
        let mut world = world(context, &own.scene);
        let mut moved = opened(context, &world, &spec(text));
        for time_s in [0.5, 3.0, 1.5] {
            own.move_world(&mut world, time_s).expect("room for four");
            build(&mut moved, &world, text);
            let new_world = self::world(context, &own.at(time_s).expect("a state"));
            let mut fresh = opened(context, &new_world, &spec(text));
            build(&mut fresh, &new_world, text);
            let asked = [&moved, &fresh].map(|o| ask(context, o.technique.as_ref(), 0, &points()));
            assert!(asked[0] == asked[1], "{time_s} s");
            assert!(asked[0].iter().any(|v| *v < 1.0), "{time_s} s: no shadow");
        }
        let mut world = self::world(context, &unreserved.at(0.0).expect("a state"));
        let error = unreserved.move_world(&mut world, 3.0).expect_err("no room").to_string();
        assert!(error.contains("4 casters, and the world has room for 1"), "{error}");
    });
}
