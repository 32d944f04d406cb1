//! Worlds that change: blocks found anew where something moved, and blocks kept, have the words of a fresh bake.

use super::{PLAIN, Settings, Structure, baked, shapes};
use crate::support::{self, gpu_test, scenes::Random};
use glam::DVec3;
use gobo::gpu::Context;
use gobo::reference::truth::bounds;
use gobo::scene::{Light, LightKind, Scene};
use gobo::technique::{Opened, Voxelized};
use gobo::world::World;

fn opened(context: &Context, world: &World, settings: Settings) -> Opened<Voxelized> {
    let technique = support::opened(Voxelized::planned(context, world, &settings), "voxelized");
    Opened::new(context, Box::new(technique), true)
}

/// Moves a box in the middle of the scene, which does not change the scene's bounds.
fn moved(scene: &Scene, mesh: usize, by: DVec3) -> Scene {
    let mut scene = scene.clone();
    for position in &mut scene.meshes[mesh].positions {
        *position = (DVec3::from(position.map(f64::from)) + by).as_vec3().into();
    }
    scene
}

/// Partial bakes have the words of a fresh bake, under a directional light, with several tiles and with one, and under a spot and a point
/// light. Steps: nothing is known; a box moves, and the static blocks are laid out; the box moves on; two boxes move; one turns inside out;
/// the light moves; a mesh at the rim moves, and the cube with it; and back.
#[test]
fn parts_have_the_words_of_the_whole() {
    gpu_test("parts_have_the_words_of_the_whole", |context| {
        let mut placed = shapes::houses();
        let spot =
            LightKind::Spot { position: DVec3::new(0.05, 0.1, 1.3), direction: DVec3::NEG_Z, cone_degrees: 110.0 };
        let point = LightKind::Point { position: DVec3::new(0.1, -0.05, 0.7) };
        let light = |kind| Light { kind, radiance: [1.0; 3], radius: f64::INFINITY };
        placed.lights = vec![light(spot), light(point)];
        let cases = [
            (shapes::houses(), Settings { size: 256, tile: 128, ..PLAIN }),
            (placed, Settings { size: 128, ..PLAIN }),
            (shapes::houses(), Settings { size: 256, structure: Structure::Svo, ..PLAIN }),
        ];
        for (scene, settings) in support::some(cases, 1) {
            let settings = Settings { keep_columns: false, ..settings };
            let by = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
            let first = moved(&scene, 2, by(0.03, -0.02, 0.01));
            let on = moved(&first, 2, by(0.05, 0.04, -0.03));
            let two = moved(&moved(&on, 1, by(0.0, 0.02, 0.0)), 3, by(-0.1, 0.0, 0.02));
            let mut turned = two.clone();
            turned.meshes[2].triangles.iter_mut().for_each(|t| t.swap(1, 2));
            let mut lit = turned.clone();
            lit.lights[0].kind = match lit.lights[0].kind {
                LightKind::Directional { direction } => {
                    LightKind::Directional { direction: (direction + by(0.1, 0.0, 0.0)).normalize() }
                }
                kind => kind,
            };
            let rim = moved(&lit, 0, by(0.4, 0.0, 0.0));
            let mut world = World::new(context, &scene).expect("room");
            let mut kept = opened(context, &world, settings);
            let mut found = Vec::new();
            for (step, now) in [&scene, &first, &on, &two, &turned, &lit, &rim, &on, &first].into_iter().enumerate() {
                world.replace(now).expect("as many of all");
                kept.build(&world).expect("baked");
                let fresh = baked(context, now, settings);
                let what = format!("{} lights, {settings:?}, step {step}", scene.lights.len());
                assert_eq!(kept.technique.nodes().expect("read"), fresh.technique.nodes().expect("read"), "{what}");
                assert_eq!(kept.technique.trees().expect("read"), fresh.technique.trees().expect("read"), "{what}");
                found.push(kept.technique.found_blocks());
            }
            println!("{} lights, {settings:?}: blocks found {found:?}", scene.lights.len());
            let all = found[0];
            assert!(found[1] == all && found[2] > 0 && found[2] < all / 2, "{found:?}");
            // A tree in which nothing merges may outgrow its buffer, and is then baked whole.
            assert!(found[3] < all || settings.structure == Structure::Svo, "{found:?}");
            // A pyramid does not depend on its contents.
            let is_cube = matches!(scene.lights[0].kind, LightKind::Directional { .. });
            assert!((found[5] == all) == is_cube && (found[6] == all) == is_cube, "{found:?}");
        }
    });
}

/// Moves random triangles out of many, a few at a time.
#[test]
fn whatever_moves_is_found() {
    gpu_test("whatever_moves_is_found", |context| {
        let mut random = Random::new(12);
        let mut scene = shapes::soup();
        let settings = Settings { size: 128, keep_columns: false, ..PLAIN };
        let mut world = World::new(context, &scene).expect("room");
        let mut kept = opened(context, &world, settings);
        for step in 0..12 {
            for _ in 0..step % 4 {
                let mesh = random.bits() as usize % scene.meshes.len();
                scene = moved(&scene, mesh, DVec3::from(random.point(-0.05, 0.05).map(f64::from)));
            }
            world.replace(&scene).expect("as many of all");
            kept.build(&world).expect("baked");
            let fresh = baked(context, &scene, settings);
            assert_eq!(kept.technique.nodes().expect("read"), fresh.technique.nodes().expect("read"), "step {step}");
        }
    });
}

/// Measures the cost of moving a box in the middle, whose half-extent is a hundredth of the scene's diagonal: `cargo test --release --test
/// world_space voxelized:: -- --nocapture --ignored what_a_move_costs` prints it.
#[test]
#[ignore = "measures"]
fn what_a_move_costs() {
    gpu_test("what_a_move_costs", |context| {
        let named = |name: &str| Scene::load(name, 0.0).expect("built in");
        for name in ["houses", "town"] {
            let mut scene = named(name);
            let [low, high] = bounds(&scene).expect("meshes");
            let (middle, half) = (0.5 * (low + high), 0.01 * (high - low).length());
            let corner = |by: f64| (middle + by).as_vec3().into();
            scene.meshes.push(support::scenes::cuboid(corner(-half), corner(half)));
            for size in [1024, 2048] {
                let settings = Settings { size, keep_columns: false, ..PLAIN };
                let mut world = World::new(context, &scene).expect("room");
                let mut kept = opened(context, &world, settings);
                let mesh = scene.meshes.len() - 1;
                let (mut parts, mut whole, mut blocks) = (Vec::new(), Vec::new(), 0);
                for step in 0..8 {
                    let now = moved(&scene, mesh, DVec3::new(0.1 * half * f64::from(step), 0.0, 0.0));
                    world.replace(&now).expect("as many of all");
                    let built = kept.build(&world).expect("baked");
                    if step > 1 {
                        parts.push(built.device_ns.expect("timestamps"));
                        blocks = kept.technique.found_blocks();
                    }
                }
                for _ in 0..5 {
                    whole.push(kept.rebuild(&world).expect("baked").device_ns.expect("timestamps"));
                }
                let median = |all: &mut Vec<f64>| {
                    all.sort_by(f64::total_cmp);
                    all[all.len() / 2] * 1e-6
                };
                let (parts, whole) = (median(&mut parts), median(&mut whole));
                let triangles = scene.meshes[mesh].triangles.len();
                let all = (size / 8).pow(2);
                println!(
                    "{name}, {size}: {triangles} triangles move, {blocks} of {all} blocks, {parts:.1} ms of {whole:.1}"
                );
            }
        }
    });
}
