//! Lights of a world of buffers: they appear, disappear and persist.

use super::buffers::{bits, cause, fill, points, scene, theirs};
use super::{answers, build, opened};
use crate::support::{gpu_test, spec};
use gobo::gpu::Context;
use gobo::scene::{Light, LightKind, Scene};
use gobo::technique::Opened;
use gobo::world::{Capacity, World};

/// When lights disappear, look-ups for the others stay the same to the bit. A technique reports it if there are more lights than it was
/// opened for, unless it stores nothing per light; opened anew, or opened with as many, it gives the look-ups of a scene.
#[test]
fn lights_come_and_go() {
    gpu_test("lights_come_and_go", |context| {
        let (scene, points) = (scene(7, 60), points());
        let two = Scene { lights: scene.lights[..2].to_vec(), ..scene.clone() };
        for text in ["avsm:size=28", "shadow-map:size=28", "voxel-grid:size=64"] {
            let spec = spec(text);
            let of = |scene: &Scene| {
                let world = super::world(context, scene);
                let mut opened = opened(context, &world, &spec);
                build(&mut opened, &world, text);
                bits(answers(context, opened.technique.as_ref(), scene.lights.len(), &points))
            };
            let (all, both) = (of(&scene), of(&two));
            assert!(all[..2] == both, "{text}");
            let mut world = theirs(context, &Scene { lights: scene.lights[..1].to_vec(), ..scene.clone() }, 0, false);
            assert!(cause(set_lights(context, &mut world, &scene.lights)).contains("room for 1"), "{text}");
            let triangles = world.triangle_capacity();
            let capacity = Capacity { particles: 60, triangles, lights: 3, ..Capacity::default() };
            let mut world = World::of(context, capacity).expect("room");
            fill(context, &mut world, &two, false);
            let mut opened_for_two = opened(context, &world, &spec);
            build(&mut opened_for_two, &world, text);
            let is = |opened: &Opened, lights| bits(answers(context, opened.technique.as_ref(), lights, &points));
            assert!(is(&opened_for_two, 2) == both, "{text}");
            set_lights(context, &mut world, &two.lights[..1]).expect("fewer");
            assert_eq!((world.light_count(), world.all_lights()[1].radiance), (2, [0.0; 3]));
            build(&mut opened_for_two, &world, text);
            assert!(is(&opened_for_two, 1) == both[..1], "{text}");
            set_lights(context, &mut world, &scene.lights).expect("there is room");
            let built = opened_for_two.build(&world);
            if text.starts_with("voxel-grid") {
                built.expect("it keeps nothing of a light");
                assert!(is(&opened_for_two, 3) == all, "{text}");
            } else {
                assert!(cause(built.map(|_| ())).contains("8 maps, and a technique was opened for 2"), "{text}");
            }
            let mut anew = opened(context, &world, &spec);
            build(&mut anew, &world, text);
            assert!(is(&anew, 3) == all, "{text}");
            set_lights(context, &mut world, &[]).expect("none");
            set_lights(context, &mut world, &scene.lights).expect("all again");
            build(&mut anew, &world, text);
            assert!(is(&anew, 3) == all, "{text}");
        }
    });
}

fn set_lights(context: &Context, world: &mut World, lights: &[Light]) -> gobo::Result<()> {
    context.try_submit(|commands| world.update_lights(commands, lights)).map(|_| ())
}

/// Each light has its own generation, and nothing is recorded if none has changed.
#[test]
fn lights_that_stand_are_left() {
    gpu_test("lights_that_stand_are_left", |context| {
        let scene = scene(6, 20);
        let mut world = theirs(context, &scene, 0, false);
        let before = world.generations().clone();
        let mut lights = scene.lights.clone();
        let mut set = |lights: &[Light]| {
            let recorded =
                context.submit(|commands| world.update_lights(commands, lights).expect("lights")).expect("submitted");
            (recorded.len(), world.generations().lights.clone())
        };
        let timed = usize::from(context.features().timestamp_valid_bits > 0);
        assert_eq!(set(&lights), (0, before.lights.clone()));
        lights[0].radiance = [0.25; 3];
        assert_eq!(set(&lights), (timed, before.lights.clone()));
        lights[2].kind = LightKind::Point { position: glam::DVec3::ONE };
        assert_eq!(set(&lights), (timed, vec![0, 0, 1]));
    });
}
