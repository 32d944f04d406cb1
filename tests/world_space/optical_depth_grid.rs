//! Grids of optical depths: cells and look-ups against their twin, and gradual bakes against full ones.

use crate::support::{ask, gpu_test, ran, scenes, scenes::Random, some};
use gobo::gpu::Context;
use gobo::reference::twin::grid::Place;
use gobo::reference::twin::media::Media;
use gobo::reference::twin::optical_depth_grid::OpticalDepths;
use gobo::scene::Scene;
use gobo::technique::optical_depth_grid::{Bake, Settings, way_parts};
use gobo::technique::{Opened, OpticalDepthGrid, Technique};
use gobo::world::World;

const PLAIN: Settings = Settings { size: 64, cells: 32, bake: Bake::Whole, frames: 8, opaque: None };

fn built(context: &Context, scene: &Scene, settings: Settings) -> (World, Opened<OpticalDepthGrid>) {
    let world = World::new(context, scene).expect("room for the scene");
    let technique = OpticalDepthGrid::new(context, &world, &settings).expect("opens");
    let mut opened = Opened::new(context, Box::new(technique), true);
    opened.build(&world).expect("built");
    (world, opened)
}

/// Cells whose centre sees the light along a voxel's side may use either voxel.
#[test]
fn cells_and_answers_equal_their_twin() {
    gpu_test("cells_and_answers_equal_their_twin", |context| {
        for scene in some([scenes::four_lights(), scenes::locks(), scenes::random()], 2) {
            let (_, opened) = built(context, &scene, PLAIN);
            let (data, depths) = opened.technique.baked().expect("read");
            let place = Place { origin: data.origin, voxel: data.voxel, per_unit: data.per_unit, size: data.size };
            let media = Media::deposit(&scene.casters(), &place);
            let mut random = Random::new(91);
            for ((i, light), found) in scene.lights.iter().enumerate().zip(depths.chunks_exact(32 * 32 * 32)) {
                let parts = way_parts(u64::from(PLAIN.cells).pow(3) * scene.lights.len() as u64);
                let twin = OpticalDepths::bake(&media, &place, light, PLAIN.cells, parts);
                let off = |(a, b): (&f32, &f32)| (a - b).abs() > 1e-3 * (1.0 + b.abs());
                let differ = twin.depths.iter().zip(found).filter(|(b, a)| off((a, b))).count();
                let some = twin.depths.iter().filter(|depth| **depth > 0.05).count();
                assert!(differ < 40 && some > 300, "{}, light {i}: {differ} differ, {some} are dark", scene.name);
                let points: Vec<_> = (0..1000).map(|_| random.point(-1.5, 1.5)).collect();
                let answers = ask(context, opened.technique.as_ref(), i, &points);
                let wrong = points
                    .iter()
                    .zip(answers)
                    .filter(|(point, answer)| (answer - twin.visibility(&media, light, **point)).abs() > 1e-3);
                let wrong = wrong.count();
                assert!(wrong < 10, "{}, light {i}: {wrong} answers are off", scene.name);
            }
        }
    });
}

/// A gradual bake keeps the old look-ups until it is complete, and then equals a full bake.
#[test]
fn turns_end_where_the_whole_is() {
    gpu_test("turns_end_where_the_whole_is", |context| {
        let scene = scenes::four_lights();
        let mut moved = scene.clone();
        moved.particles.iter_mut().for_each(|particle| particle.position[0] *= 0.5);
        let points: Vec<_> = {
            let mut random = Random::new(92);
            (0..400).map(|_| random.point(-1.2, 1.2)).collect()
        };
        let [before, after] = [&scene, &moved].map(|scene| {
            let (_, opened) = built(context, scene, PLAIN);
            ask(context, opened.technique.as_ref(), 0, &points)
        });
        assert!(before != after);
        // The depths are the same, but split differently along the rays, so they are summed in another order.
        let alike = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
        for frames in some([4, 8, 16], 1) {
            let settings = Settings { bake: Bake::RoundRobin, frames, ..PLAIN };
            let (mut world, mut opened) = built(context, &scene, settings);
            let first = ask(context, opened.technique.as_ref(), 0, &points);
            assert!(alike(&first, &before), "the first build bakes all of it");
            world.replace(&moved).expect("as many of all");
            for frame in 0..frames {
                assert!(ask(context, opened.technique.as_ref(), 0, &points) == first, "after {frame} of {frames}");
                ran(context, |commands| opened.technique.record(commands, &world).expect("recorded"));
            }
            let last = ask(context, opened.technique.as_ref(), 0, &points);
            assert!(alike(&last, &after) && !alike(&last, &before), "after all {frames}");
        }
    });
}

/// A gradual bake shows the scene as it was when the turn began; what moves meanwhile shows in the next turn.
#[test]
fn a_turn_sees_one_moment() {
    gpu_test("a_turn_sees_one_moment", |context| {
        let scene = scenes::four_lights();
        let at = |frame: u32| {
            let mut scene = scene.clone();
            scene.particles.iter_mut().for_each(|particle| particle.position[0] *= 1.0 - 0.05 * frame as f32);
            scene
        };
        let points: Vec<_> = {
            let mut random = Random::new(93);
            (0..400).map(|_| random.point(-1.2, 1.2)).collect()
        };
        let settings = Settings { bake: Bake::RoundRobin, frames: 4, ..PLAIN };
        let (mut world, mut opened) = built(context, &scene, settings);
        for frame in 1..=4 {
            world.replace(&at(frame)).expect("as many of all");
            ran(context, |commands| opened.technique.record(commands, &world).expect("recorded"));
        }
        let found = ask(context, opened.technique.as_ref(), 0, &points);
        let [then, now] = [1, 4].map(|frame| {
            let (_, opened) = built(context, &at(frame), PLAIN);
            ask(context, opened.technique.as_ref(), 0, &points)
        });
        let off = |a: &[f32]| a.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off(&then) < 1e-5 && off(&now) > 1e-2, "{} and {}", off(&then), off(&now));
    });
}
