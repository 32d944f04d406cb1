//! The host's volumes in a world of the caller's: look-ups equal a scene's, and unchanged volumes are neither copied nor rebuilt.

use super::buffers::{fill, record};
use super::{answers, build, opened, points};
use crate::support::{self, ask, gpu_test, runs, scenes, spec};
use glam::DVec3;
use gobo::reference::truth::{Casters, space_points};
use gobo::scene::{Caster, Field, Particle, Placed, Scene, Volume};
use gobo::world::{Capacity, World};
use std::sync::Arc;

/// A soft ball with `count`³ samples, 1.4 world units wide, around `middle`.
fn ball(count: i32, middle: [f64; 3]) -> Volume {
    let half = 0.5 * f64::from(count - 1);
    let density = |place: [i32; 3]| {
        let far = DVec3::from_array(place.map(f64::from)).distance(DVec3::splat(half)) / half;
        (1.0 - far * far).max(0.0) as f32
    };
    let places = (0..count.pow(3)).map(|i| [i % count, i / count % count, i / count / count]);
    let field = Field::new(places.map(|place| (place, density(place)))).expect("a field");
    let steps = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * 0.7 / half);
    let origin = DVec3::from_array(middle) - half * (steps[0] + steps[1] + steps[2]);
    let placed = Placed { origin, steps, extinction: 3.0, color: [0.9, 0.5, 0.2], side: 1 };
    Volume::new(Arc::new(field), placed).expect("a volume")
}

/// Smoke beside a volume, under a light with a position, from which views are measured in both kinds of world.
fn scene(volumes: Vec<Volume>) -> Scene {
    let smoke = |i: u8| Particle { position: [0.2 * f32::from(i) - 1.0, 0.6, -0.4], radius: 0.2, extinction: 2.0 };
    let mut scene = scenes::directional("beside", [0.3, 0.2, -0.9], (0..10).map(smoke).collect());
    scene.lights = scenes::spot([0.4, 2.0, 3.0], 70.0, scene.clone()).lights;
    Scene { volumes, ..scene }
}

const ROOM: Capacity = Capacity {
    particles: 10,
    strands: 3,
    splats: 2,
    cells: 9000,
    triangles: 0,
    alpha_texels: None,
    see_through: false,
    lights: 1,
};

fn theirs(context: &gobo::gpu::Context, scene: &Scene) -> World {
    let mut world = World::of(context, ROOM).expect("room");
    fill(context, &mut world, scene, true);
    record(context, |commands| world.volumes(commands, &scene.volumes));
    world
}

/// Another volume per frame: larger, moved, two, none. A technique that stays open gives the same look-ups as one opened for a scene of
/// that frame alone, close to the field's exact values.
#[test]
fn volumes_of_a_caller_answer_as_a_scene_does() {
    if crate::support::is_long("volumes_of_a_caller_answer_as_a_scene_does") {
        return;
    }
    gpu_test("volumes_of_a_caller_answer_as_a_scene_does", |context| {
        let points = points();
        let frames = [
            vec![ball(12, [0.0; 3])],
            vec![ball(20, [0.3, -0.2, 0.1])],
            vec![ball(9, [0.2, 0.1, -0.3]), ball(11, [-0.6, 0.0, 0.4])],
            vec![],
            vec![ball(14, [0.0, -0.4, 0.2])],
        ];
        for text in ["layers:size=28,path=binned", "grid-query", "density-grid:size=64", "uncompressed:size=28"] {
            if !runs("volumes_of_a_caller_answer_as_a_scene_does", context, text) {
                continue;
            }
            let mut world = theirs(context, &scene(frames[0].clone()));
            let mut stays = opened(context, &world, &spec(text));
            for (frame, volumes) in frames.iter().enumerate() {
                let scene = scene(volumes.clone());
                record(context, |commands| world.volumes(commands, volumes));
                assert!(world.kinds().volumes && world.caster_count() == 15 + scene.cell_count() as u32);
                build(&mut stays, &world, text);
                let is = answers(context, stays.technique.as_ref(), 1, &points).concat();
                let ours = super::world(context, &scene);
                let mut fresh = opened(context, &ours, &spec(text));
                build(&mut fresh, &ours, text);
                let expected = answers(context, fresh.technique.as_ref(), 1, &points).concat();
                assert!(expected.iter().filter(|answer| **answer < 0.6).count() > 20, "{text}: too little shadow");
                for (is, expected) in is.iter().zip(&expected) {
                    assert!((is - expected).abs() < 2e-5, "{text}, frame {frame}: {is}, not {expected}");
                }
                let truth = Casters::new(&scene);
                let within = space_points(&scene, 0, 400);
                let found = ask(context, stays.technique.as_ref(), 0, &within);
                let (mut error, mut none) = (0.0, 0.0);
                for (point, answer) in within.iter().zip(found) {
                    let light = truth.visibility(0, DVec3::from(point.map(f64::from)));
                    (error, none) = (error + (f64::from(answer) - light).abs(), none + 1.0 - light);
                }
                println!("{text}, frame {frame}: {:.4} of {:.4}", error / 400.0, none / 400.0);
                assert!(error < 0.3 * none, "{text}, frame {frame}: {error}, without shadows {none}");
            }
        }
    });
}

/// The same volumes cause no pass, no new generation and no build: what was written over the cells is still there. Different volumes are
/// copied, and only to their own place.
#[test]
fn volumes_that_are_the_same_are_not_copied() {
    gpu_test("volumes_that_are_the_same_are_not_copied", |context| {
        let (one, other) = (ball(9, [0.0; 3]), ball(12, [0.1, 0.2, 0.3]));
        let mut world = theirs(context, &scene(vec![one.clone()]));
        let mut opened = opened(context, &world, &spec("layers:size=28,path=binned"));
        build(&mut opened, &world, "layers");
        let written: Vec<Caster> = world.buffers().casters.read(15 + one.cells().len()).expect("read");
        assert_eq!(&written[15..], one.cells());
        let marked = vec![Caster { position: [7.0; 3], radius: 0.25, axis: [0.0; 3], density: 3.0 }; 200];
        world.buffers().casters.write(&marked).expect("room");
        // A clone, and a separate field with equal samples.
        for same in [one.clone(), ball(9, [0.0; 3])] {
            let before = world.generations().clone();
            let passes = support::opened(
                context.try_submit(|commands| world.volumes(commands, std::slice::from_ref(&same))),
                "the same",
            );
            assert!(passes.is_empty(), "{passes:?}");
            assert_eq!(world.generations(), &before);
            assert!(build(&mut opened, &world, "layers").passes.is_empty(), "nothing has changed");
        }
        assert_eq!(world.buffers().casters.read::<Caster>(200).expect("read"), marked);
        let before = world.generations().clone();
        let passes = support::opened(
            context.try_submit(|commands| world.volumes(commands, std::slice::from_ref(&other))),
            "another",
        );
        assert!(passes.iter().all(|pass| pass.name == "world.volumes") && passes.len() <= 1, "{passes:?}");
        assert_eq!(
            (world.generations().strands, world.generations().particles),
            (before.strands + 1, before.particles)
        );
        let all: Vec<Caster> = world.buffers().casters.read(15 + other.cells().len()).expect("read");
        assert!(all[..15] == marked[..15] && &all[15..] == other.cells());
    });
}

/// In a world of a scene, moving particles leave the cells alone, and moving cells leave the particles alone.
#[test]
fn what_moves_beside_volumes_is_copied_alone() {
    gpu_test("what_moves_beside_volumes_is_copied_alone", |context| {
        let still = scene(vec![ball(9, [0.0; 3])]);
        let cells = still.cell_count();
        let marked = vec![Caster { position: [7.0; 3], radius: 0.25, axis: [0.0; 3], density: 3.0 }; 10 + cells];
        let mut smoke = still.clone();
        smoke.particles.iter_mut().for_each(|p| p.position[0] += 0.125);
        let mut moved = still.clone();
        moved.volumes = vec![ball(9, [0.25, 0.0, 0.0])];
        let mut fewer = still.clone();
        fewer.particles.pop();
        for (after, copied) in [(smoke, 0..10), (moved, 10..10 + cells), (fewer, 0..9 + cells), (still.clone(), 0..0)] {
            let mut world = super::world(context, &still);
            world.buffers().casters.write(&marked).expect("room");
            world.replace(&after).expect("another state");
            let casters = after.casters();
            let found: Vec<Caster> = world.buffers().casters.read(casters.len()).expect("read");
            for (i, (found, caster)) in found.iter().zip(&casters).enumerate() {
                let expected = if copied.contains(&i) { caster } else { &marked[i] };
                assert_eq!(found, expected, "caster {i} of {copied:?}");
            }
        }
    });
}

#[test]
fn volumes_without_room_are_refused() {
    gpu_test("volumes_without_room_are_refused", |context| {
        let volume = ball(9, [0.0; 3]);
        let cells = volume.cells().len() as u32;
        let mut world = World::of(context, Capacity { cells: cells - 1, ..Capacity::default() }).expect("room");
        let mut ours = super::world(context, &scene(vec![volume.clone()]));
        for (world, words) in [
            (&mut world, format!("{cells} cells, and the world has room for {}", cells - 1)),
            (&mut ours, "World::of".to_owned()),
        ] {
            let set = context.try_submit(|commands| world.volumes(commands, std::slice::from_ref(&volume)));
            let error = set.map(|_| ()).expect_err("refused").to_string();
            assert!(error.contains(&words) && !error.contains('\n'), "{error}");
        }
    });
}
