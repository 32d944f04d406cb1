//! Answers: the look-up, what is lit and what is not, what there is no answer to.

use crate::maps::stand;
use crate::support::scenes::{Random, cuboid};
use crate::support::{ask, gpu_test};
use crate::{PATHS, built, refusal, scenes};
use glam::DVec3;
use gobo::reference::truth::Casters;
use gobo::reference::twin::ism::look_up::look_up;
use gobo::scene::{Light, LightKind, Mesh, Scene};

/// Points about the middle.
fn about(count: usize, reach: f32) -> Vec<[f32; 3]> {
    let mut random = Random::new(21);
    (0..count).map(|_| random.point(-reach, reach)).collect()
}

/// From the map that the device has.
#[test]
fn look_ups_equal_their_twin() {
    gpu_test("ism::look_ups_equal_their_twin", |context| {
        for (scene, size) in [(scenes::soup(), 32), (scenes::room(), 64)] {
            let ism = built(context, &scene, &format!("ism:points=1024,path=atomic,size={size}"));
            let points = about(2000, 3.0);
            for light in 0..8 {
                let map = ism.atlas().map(light).expect("the map");
                let (origin, normal) = stand(&scene, light);
                let twin = points.iter().map(|p| look_up(&map, size, origin, normal, *p));
                let others = ask(context, ism.as_ref(), light, &points)
                    .into_iter()
                    .zip(twin)
                    .filter(|(got, wanted)| {
                        assert!((0.0..=1.0).contains(got));
                        (got - wanted).abs() > 1e-3
                    })
                    .count();
                // Where a distance is a texel's but for rounding.
                assert!(others <= 4, "{}, light {light}: {others} of {} answers", scene.name, points.len());
            }
        }
    });
}

/// A plate between light and points: dark behind it, lit beside it and before it, by every path.
#[test]
fn a_plate_shadows_what_is_behind_it() {
    gpu_test("ism::a_plate_shadows_what_is_behind_it", |context| {
        let plate = cuboid([-1.0, -1.0, 1.0], [1.0, 1.0, 1.02]);
        let scene = scenes::under("plate", vec![plate], vec![scenes::light(DVec3::ZERO, DVec3::Z)]);
        let points = about(4000, 2.0).into_iter().map(|[x, y, z]| [x, y, z + 2.0]).collect::<Vec<_>>();
        for path in PATHS {
            for culling in ["on", "off"] {
                let text = format!("ism:points=4096,path={path},culling={culling}");
                if refusal(context, &scene, &text).is_some() {
                    continue;
                }
                let ism = built(context, &scene, &text);
                let answers = ask(context, ism.as_ref(), 0, &points);
                for (answer, [x, y, z]) in answers.into_iter().zip(&points) {
                    let wide = x.abs().max(y.abs()) / z;
                    if *z > 1.3 && wide < 0.8 {
                        assert_eq!(answer, 0.0, "{text}: behind it at {x}, {y}, {z}");
                    } else if wide > 1.25 || *z < 0.8 {
                        assert_eq!(answer, 1.0, "{text}: beside it at {x}, {y}, {z}");
                    }
                }
            }
        }
    });
}

/// In a room with a table: what rays in f64 say, but for what small maps of points cost: less than half of what it costs to say that
/// all is lit, or to ask another light's map, and more with fewer points and texels.
#[test]
fn a_room_is_about_what_rays_say() {
    gpu_test("ism::a_room_is_about_what_rays_say", |context| {
        let scene = scenes::room();
        let casters = Casters::new(&scene);
        let points: Vec<_> = about(600, 1.9).into_iter().filter(|p| p[2] > -0.2 || p[2] < -0.8).collect();
        let error = |text: &str, shift: usize| {
            let ism = built(context, &scene, text);
            let (mut sum, mut dark, mut count) = (0.0, 0.0, 0);
            for light in 0..scene.lights.len() {
                let answers = ask(context, ism.as_ref(), (light + shift) % scene.lights.len(), &points);
                for (answer, point) in answers.into_iter().zip(&points) {
                    let position = DVec3::from(point.map(f64::from));
                    if scene.lights[light].shines_on(position) && !casters.inside(light, position) {
                        sum += (f64::from(answer) - casters.visibility(light, position)).abs();
                        dark += 1.0 - casters.visibility(light, position);
                        count += 1;
                    }
                }
            }
            (sum / f64::from(count), dark / f64::from(count))
        };
        let (fine, dark) = error("ism:points=8192,path=atomic", 0);
        println!("off by {fine:.4}, all lit by {dark:.4}");
        assert!(fine < 0.5 * dark, "{fine} and {dark}");
        let (other, _) = error("ism:points=8192,path=atomic", 1);
        assert!(other > 2.0 * fine, "{other} of another light's map, {fine}");
        let (adaptive, _) = error("ism:points=8192,path=atomic,adaptive=on", 0);
        assert!(adaptive < fine, "{adaptive} where lights choose their points, {fine} where they do not");
        let (coarse, _) = error("ism:points=1024,size=32,path=atomic", 0);
        assert!(coarse > fine, "{coarse} of fewer points and texels, {fine} of more");
    });
}

/// Nothing to cast: everything is lit. What has no area, or is no number far away, casts nothing and breaks nothing.
#[test]
fn nothing_casts_nothing() {
    gpu_test("ism::nothing_casts_nothing", |context| {
        let line = |at: [f32; 3]| Mesh {
            name: "line".into(),
            positions: vec![at, [at[0] + 1.0, at[1], at[2]], [at[0] + 2.0, at[1], at[2]], at],
            triangles: vec![[0, 1, 2], [0, 0, 3]],
            albedo: [0.5; 3],
            solid: false,
        };
        let scenes = [
            scenes::under("nothing", Vec::new(), scenes::lights(3)),
            scenes::under("lines", vec![line([0.0; 3]), line([1.0, 2.0, 3.0])], scenes::lights(3)),
        ];
        for scene in &scenes {
            for path in PATHS {
                for adaptive in ["off", "on"] {
                    let text = format!("ism:points=1024,path={path},size=32,adaptive={adaptive}");
                    let ism = built(context, scene, &text);
                    let answers = ask(context, ism.as_ref(), 0, &about(200, 3.0));
                    assert!(answers.iter().all(|answer| *answer == 1.0), "{text} of {}", scene.name);
                }
            }
        }
    });
}

/// A light on a floor, anywhere: the floor is not before it, however its points round, and shadows nothing above it.
#[test]
fn a_floor_does_not_shadow_its_light() {
    gpu_test("ism::a_floor_does_not_shadow_its_light", |context| {
        let mut random = Random::new(31);
        let up = DVec3::new(0.3, -0.2, 1.0).normalize();
        let (right, ahead) = (up.cross(DVec3::Y).normalize(), up.cross(up.cross(DVec3::Y)).normalize());
        for far in [0.0, 100.0] {
            let at = |x: f64, y: f64, z: f64| far * DVec3::ONE + x * right + y * ahead + z * up;
            let corner =
                |i: u32| at([-2.0, 2.0][i as usize & 1], [-2.0, 2.0][i as usize >> 1], 0.0).as_vec3().to_array();
            let floor = Mesh {
                name: "floor".into(),
                positions: (0..4).map(corner).collect(),
                triangles: vec![[0, 1, 3], [0, 3, 2]],
                albedo: [0.5; 3],
                solid: false,
            };
            let mut place = || f64::from(random.between(-1.5, 1.5));
            let lights = (0..8).map(|_| scenes::light(at(place(), place(), 0.0), up)).collect();
            let points: Vec<_> = (0..300).map(|i| at(place(), place(), 0.3 + 0.005 * f64::from(i))).collect();
            let points: Vec<_> = points.iter().map(|p| p.as_vec3().to_array()).collect();
            let scene = scenes::under("floor", vec![floor], lights);
            for path in PATHS {
                for culling in ["on", "off"] {
                    let text = format!("ism:points=1024,path={path},size=32,culling={culling}");
                    let ism = built(context, &scene, &text);
                    for light in 0..8 {
                        let lit = ask(context, ism.as_ref(), light, &points).iter().filter(|a| **a == 1.0).count();
                        assert_eq!(lit, points.len(), "{text}, {far} units away, light {light}");
                    }
                }
            }
        }
    });
}

/// A light of another kind, and a device or a scene without room: one line that names it.
#[test]
fn what_has_no_answer_is_refused() {
    gpu_test("ism::what_has_no_answer_is_refused", |context| {
        let mut scene = scenes::room();
        assert_eq!(refusal(context, &scene, "ism:path=atomic,points=1024"), None);
        let kind = LightKind::Point { position: DVec3::ZERO };
        scene.lights.push(Light { kind, radiance: [1.0; 3], radius: 9.0 });
        let needs = refusal(context, &scene, "ism").expect("a point light");
        assert!(needs.contains("virtual point lights") && needs.contains("--vpls"), "{needs}");

        let has = context.features().max_compute_shared_memory_bytes;
        let text = "ism:size=128,path=tiled,points=1024";
        match refusal(context, &scenes::room(), text) {
            Some(needs) => {
                assert!(has < 87360 && needs.contains("maxComputeSharedMemorySize of at least 87360"), "{needs}")
            }
            None => assert!(has >= 87360, "{has}"),
        }
    });
}

/// A world that moved is a new world, and the lights of one do not disturb each other.
#[test]
fn a_moved_world_is_a_new_world() {
    use gobo::technique::{Ism, IsmSettings, Opened};
    use gobo::world::World;
    gpu_test("ism::a_moved_world_is_a_new_world", |context| {
        let mut scene = scenes::room();
        let points = about(500, 1.9);
        for path in PATHS {
            let text = format!("ism:points=1024,path={path},size=32");
            let mut world = World::new(context, &scene).expect("room");
            let ism = Ism::new(context, &world, &IsmSettings::of(&crate::spec(&text))).expect("opened");
            let mut opened = Opened::new(context, Box::new(ism), true);
            opened.build(&world).expect("built");
            let before = ask(context, opened.technique.as_ref(), 4, &points);
            scene.lights.rotate_left(1);
            scene.meshes[6].positions.iter_mut().for_each(|p| p[0] += 0.25);
            world.replace(&scene).expect("as many");
            opened.build(&world).expect("built again");
            let new = built(context, &scene, &text);
            for light in [0, 4, 29] {
                let now = ask(context, opened.technique.as_ref(), light, &points);
                assert!(now == ask(context, new.as_ref(), light, &points), "{text}, light {light}");
                assert!(light != 4 || now != before, "{text}: nothing changed");
            }
        }
    });
}

/// What is told by the normals alone loses points that a light sees, and keeps some that it does not: counted against the exact test.
#[test]
fn facing_by_normals_is_not_exact() {
    gpu_test("ism::facing_by_normals_is_not_exact", |context| {
        let scene: Scene = scenes::room();
        let seen = ["exact", "slide"].map(|facing| {
            let ism = built(context, &scene, &format!("ism:points=4096,path=atomic,facing={facing}"));
            ism.atlas().seen().expect("counted").into_iter().map(u64::from).sum::<u64>()
        });
        assert!(seen[1] * 10 < seen[0] * 9, "a light on the floor sees no wall's back by its normal: {seen:?}");
    });
}
