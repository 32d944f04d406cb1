//! Invalid casters, and more casters than there is room for.

use super::buffers::{AT, bits, cause, corners, fill, points, scene, source, theirs};
use super::{answers, build, opened};
use crate::support::{gpu_test, spec};
use gobo::Error;
use gobo::scene::{Caster, Light, LightKind, Particle, Scene};
use gobo::technique;
use gobo::world::{Capacity, Count, Gathered, Source, World};

/// Casters beyond the capacity, and casters without a valid position or size, cast nothing, and are counted.
#[test]
fn what_is_no_caster_casts_nothing() {
    if crate::support::is_costly("what_is_no_caster_casts_nothing") {
        return;
    }
    gpu_test("what_is_no_caster_casts_nothing", |context| {
        let good = scene(4, 60);
        let points = points();
        for (bad, value) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0].into_iter().enumerate() {
            let mut mixed = good.clone();
            let particle = Particle { position: [0.3; 3], radius: 0.3, extinction: 3.0 };
            for place in [0, 17, 62] {
                let mut particle = particle;
                match (place, value.is_finite()) {
                    (0, false) => particle.position[bad % 3] = value,
                    (17, false) => particle.extinction = -value.abs(),
                    _ => particle.radius = value,
                }
                mixed.particles.insert(place, particle);
            }
            mixed.meshes[0].positions.push([f32::NAN, 0.0, 0.0]);
            mixed.meshes[0].triangles.push([0, 1, 4]);
            mixed.meshes[1].triangles.push([0, 1, 900]);
            for text in ["beer-shadow-map:size=28", "shadow-map:size=64", "voxel-grid:size=64"] {
                let (ours, mut theirs) = (super::world(context, &good), theirs(context, &mixed, 3, true));
                let answers = [&ours, &theirs].map(|world| {
                    let mut opened = opened(context, world, &spec(text));
                    build(&mut opened, world, text);
                    bits(answers(context, opened.technique.as_ref(), 3, &points))
                });
                assert!(answers[0] == answers[1], "{text}, {value}");
                let triangles = good.meshes.iter().map(|m| m.triangles.len() as u32).sum::<u32>();
                let expected = Gathered { asked: [63, 0, triangles + 2, 0, 0], refused: [3, 0, 2, 0, 0] };
                let frame = fill(context, &mut theirs, &mixed, true);
                assert_eq!(theirs.gathered(frame).expect("read"), Some(expected), "{value}");
            }
        }
        // Two more are written than there is room for: the last two are dropped.
        let mut world = World::of(context, Capacity { particles: 58, lights: 3, ..Capacity::default() }).expect("room");
        let fewer = Scene { particles: good.particles[..58].to_vec(), meshes: Vec::new(), ..good.clone() };
        let frame = fill(context, &mut world, &Scene { meshes: Vec::new(), ..good.clone() }, true);
        assert_eq!(world.gathered(frame).expect("read"), Some(Gathered { asked: [60, 0, 0, 0, 0], refused: [0; 5] }));
        assert_eq!(world.buffers().casters.read::<Caster>(58).expect("read"), fewer.casters());
    });
}

#[test]
fn what_the_host_knows_is_an_error() {
    gpu_test("what_the_host_knows_is_an_error", |context| {
        let scene = scene(5, 20);
        let capacity = Capacity { particles: 19, triangles: 5, lights: 3, ..Capacity::default() };
        let mut world = World::of(context, capacity).expect("room");
        let mut ours = super::world(context, &scene);
        let good = source(context, &scene.particles, false);
        let passes = context.submit(|commands| {
            let too_many = world.update_particles(commands, &good, AT);
            assert!(cause(too_many).contains("20, and the world has room for 19"));
            let short = Source { count: Count::Host(19), stride: 64, ..good.clone() };
            assert!(cause(world.update_particles(commands, &short, AT)).contains("the buffer holds 15"));
            let odd = Source { count: Count::Host(1), offset: 6, ..good.clone() };
            assert!(cause(world.update_particles(commands, &odd, AT)).contains("6 bytes"));
            let outside = Count::Device { buffer: good.buffer.clone(), offset: good.buffer.bytes() };
            assert!(
                cause(world.update_particles(commands, &Source { count: outside, ..good.clone() }, AT))
                    .contains("a count")
            );
            assert!(
                cause(world.update_triangles(commands, &corners(context, &scene.meshes, false))).contains("room for 5")
            );
            assert!(cause(ours.update_particles(commands, &good, AT)).contains("a scene fills this world"));
            let mut light = scene.lights.clone();
            light.push(light[0]);
            assert!(cause(world.update_lights(commands, &light)).contains("room for 3"));
            light.pop();
            light[1].radius = f64::NAN;
            assert!(cause(world.update_lights(commands, &light)).contains("light 1"));
            world.update_lights(commands, &scene.lights).expect("lights");
            light.clone_from(&scene.lights);
            light.swap(0, 2);
            assert!(cause(world.update_lights(commands, &light)).contains("light 0 has another number of maps"));
        });
        passes.expect("submitted");
        assert!(cause(world.set_box([0.0; 3], [1.0, f32::NAN, 1.0])).contains("from"));
        assert!(matches!(world.scene(), Err(Error::Refused(_))) && world.replace(&scene).is_err());
        let refused = |text: &str, world: &World| match technique::open(context, world, &spec(text)) {
            Err(Error::Refused(needs)) => needs,
            Err(error) => panic!("{text}: {error}"),
            Ok(_) => "nothing".into(),
        };
        let direction = |light: &&Light| matches!(light.kind, LightKind::Directional { .. });
        let sun: Vec<_> = scene.lights.iter().filter(direction).copied().collect();
        let mut world = World::of(context, capacity).expect("room");
        context.submit(|commands| world.update_lights(commands, &sun).expect("lights")).expect("submitted");
        assert!(refused("voxelized:size=64", &world).to_string().contains("World::set_box"));
        world.set_box([-1.0; 3], [1.0; 3]).expect("a box");
        assert_eq!(refused("voxelized:size=64", &world), "nothing".into());
    });
}
