//! A world that buffers of the caller's fill answers as a scene of the same casters does.

use super::{answers, build, opened};
use crate::support::scenes::{self, Random};
use crate::support::{every_path, gpu_test, runs, some, spec};
use gobo::Error;
use gobo::gpu::{Buffer, Commands, Context};
use gobo::reference::twin::gather::{CasterAt, Vertices, casters};
use gobo::scene::{Caster, Light, LightKind, Mesh, Particle, Scene};
use gobo::technique::{self, Lifetime, Opened, Spec};
use gobo::world::{Capacity, Corners, Count, Gathered, Number, Source, SphereAt, StrandAt, World};

/// Words from one particle of theirs to the next, and to the first.
const STRIDE: usize = 12;
const FIRST: usize = 4;

/// A position behind a number of theirs, extinction before radius.
const AT: SphereAt = SphereAt { position: 4, radius: Number::At(40), extinction: Number::At(20) };

const NAN: u32 = 0x7FC0_0000;

/// Smoke, a thing and the ground, under a directional light, a spot and a point light. The first caster along x and the first corner
/// stand at the origin, from which a world without a box measures.
fn scene(seed: u64, count: usize) -> Scene {
    let mut random = Random::new(seed);
    let mut particles: Vec<_> = (1..count)
        .map(|_| {
            let radius = random.between(0.05, 0.4);
            let position = [random.between(0.1, 2.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
            Particle { position, radius, extinction: random.between(0.1, 2.0) }
        })
        .collect();
    particles.insert(count / 2, Particle { position: [0.0; 3], radius: 0.2, extinction: 0.7 });
    let mut scene = scenes::directional("theirs", [0.5, 0.3, -0.81], particles);
    scene.lights.extend(scenes::spot([0.4, 2.0, 3.0], 70.0, scene.clone()).lights);
    scene.lights.extend(scenes::point([0.9, 0.1, 0.3], scene.clone()).lights);
    let positions = vec![[0.0, 0.0, 0.0], [0.4, 0.1, 0.0], [0.1, 0.5, -0.1], [0.2, 0.2, 0.5]];
    let thing = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let albedo = [0.5; 3];
    scene.meshes.push(Mesh { name: "thing".into(), positions, triangles: thing, albedo, solid: false });
    scene.meshes.push(scenes::level(-1.2, 1.0, [1.2, 0.0]));
    scene
}

/// Words that no pass may take for anything.
fn junk(count: usize) -> Vec<u32> {
    (0..count as u32).map(|i| if i % 2 == 0 { NAN } else { 0xFFFF_FFFF }).collect()
}

/// Particles in their layout, those that are none among them.
fn laid_out(particles: &[Particle]) -> Vec<u32> {
    let mut words = junk(FIRST + STRIDE * particles.len());
    for (i, particle) in particles.iter().enumerate() {
        let at = &mut words[FIRST + STRIDE * i..][..STRIDE];
        at[1..4].copy_from_slice(&particle.position.map(f32::to_bits));
        at[5] = particle.extinction.to_bits();
        at[10] = particle.radius.to_bits();
    }
    words
}

fn buffer(context: &Context, words: &[u32]) -> Buffer {
    Buffer::with_data(context, "theirs", words).expect("room")
}

/// What the host says of a count, or what it leaves to the device.
fn count(context: &Context, count: usize, on_device: bool) -> Count {
    if on_device {
        return Count::Device { buffer: buffer(context, &[NAN, NAN, count as u32]), offset: 8 };
    }
    Count::Host(count as u32)
}

fn source(context: &Context, particles: &[Particle], on_device: bool) -> Source {
    let buffer = buffer(context, &laid_out(particles));
    Source {
        buffer,
        offset: 4 * FIRST as u64,
        stride: 4 * STRIDE as u32,
        count: count(context, particles.len(), on_device),
    }
}

/// Vertices that are 20 bytes apart, and indices behind a word.
fn corners(context: &Context, meshes: &[Mesh], on_device: bool) -> Corners {
    let mut words = junk(2);
    let mut indices = vec![NAN];
    let mut first = 0;
    for mesh in meshes {
        for position in &mesh.positions {
            words.extend(position.map(f32::to_bits));
            words.extend(junk(2));
        }
        indices.extend(mesh.triangles.iter().flatten().map(|i| first + i));
        first += mesh.positions.len() as u32;
    }
    let triangles = (indices.len() - 1) / 3;
    Corners {
        vertices: buffer(context, &words),
        offset: 8,
        stride: 20,
        indices: Some((buffer(context, &indices), 4)),
        count: count(context, triangles, on_device),
        albedo: [0.5; 3],
    }
}

/// A world of the same casters and lights as the scene, with room for more of each.
fn theirs(context: &Context, scene: &Scene, more: u32, on_device: bool) -> World {
    let triangles: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let capacity = Capacity {
        particles: scene.particles.len() as u32 + more,
        strands: 0,
        triangles: triangles as u32 + if triangles > 0 { more } else { 0 },
        lights: scene.lights.len() as u32,
    };
    let mut world = World::of(context, capacity).expect("room");
    fill(context, &mut world, scene, on_device);
    world
}

/// Returns the frame that fills it.
fn fill(context: &Context, world: &mut World, scene: &Scene, on_device: bool) -> u64 {
    record(context, |commands| {
        world.lights(commands, &scene.lights)?;
        world.particles(commands, &source(context, &scene.particles, on_device), AT)?;
        if !scene.meshes.is_empty() {
            world.triangles(commands, &corners(context, &scene.meshes, on_device))?;
        }
        Ok(())
    })
}

/// Returns the frame that runs it.
fn record(context: &Context, pass: impl FnOnce(&mut Commands) -> gobo::Result<()>) -> u64 {
    let mut frame = 0;
    let ran = context.try_submit(|commands| {
        frame = commands.frame();
        pass(commands)
    });
    ran.expect("recorded and submitted");
    frame
}

fn refused_in(world: &World, frame: u64) -> [u32; 3] {
    world.gathered(frame).expect("read").expect("the last that gathered").refused
}

fn specs(test: &str, context: &Context) -> Vec<Spec> {
    let mut specs = every_path(test, context);
    // Virtual lights and a box are not in the scene.
    let fits = |spec: &Spec| spec.entry.lifetime == Lifetime::Frame && !["ism", "ray-query"].contains(&spec.entry.name);
    specs.retain(|spec| fits(spec) && runs(test, context, &spec.short()));
    specs
        .iter_mut()
        .filter(|spec| spec.entry.name != "voxel-grid")
        .for_each(|spec| spec.set(gobo::technique::Name::SIZE, "28"));
    specs
}

fn points() -> Vec<[f32; 3]> {
    let mut random = Random::new(43);
    (0..1500).map(|_| [random.between(-0.4, 2.4), random.between(-1.4, 1.4), random.between(-1.4, 1.4)]).collect()
}

fn bits(answers: Vec<Vec<f32>>) -> Vec<Vec<u32>> {
    answers.into_iter().map(|light| light.into_iter().map(f32::to_bits).collect()).collect()
}

/// Every path, with room for more than there is, and the counts the host's or the device's: the same bytes; and so after all has moved.
#[test]
fn buffers_answer_as_a_scene_does() {
    gpu_test("buffers_answer_as_a_scene_does", |context| {
        let (first, next) = (scene(1, 150), scene(2, 90));
        let points = points();
        for spec in some(specs("buffers_answer_as_a_scene_does", context), 6) {
            let what = spec.short();
            let expected: Vec<_> = [&first, &next]
                .map(|scene| {
                    let world = super::world(context, scene);
                    let mut opened = opened(context, &world, &spec);
                    build(&mut opened, &world, &what);
                    bits(answers(context, opened.technique.as_ref(), 3, &points))
                })
                .into();
            assert!(expected[0] != expected[1] && expected[0].concat().iter().any(|b| *b != 1f32.to_bits()), "{what}");
            for on_device in [false, true] {
                let mut world = theirs(context, &first, 70, on_device);
                let mut opened = opened(context, &world, &spec);
                build(&mut opened, &world, &what);
                let is = bits(answers(context, opened.technique.as_ref(), 3, &points));
                assert!(is == expected[0], "{what}, count on the device: {on_device}");
                assert_eq!(build(&mut opened, &world, &what).passes, vec![], "{what}: nothing has moved");
                fill(context, &mut world, &next, on_device);
                build(&mut opened, &world, &what);
                let is = bits(answers(context, opened.technique.as_ref(), 3, &points));
                assert!(is == expected[1], "{what}, moved, count on the device: {on_device}");
            }
        }
    });
}

/// The five that a caller takes first, whatever `some` chose: of smoke alone, of meshes alone, and of nothing.
#[test]
fn what_there_is_room_for_need_not_be_there() {
    gpu_test("what_there_is_room_for_need_not_be_there", |context| {
        let points = points();
        let texts = [
            "avsm:path=binned,size=28",
            "psm:path=fused,size=28",
            "beer-shadow-map:size=28",
            "voxel-grid",
            "shadow-map:size=64",
        ];
        for text in texts.into_iter().filter(|text| runs("what_there_is_room_for_need_not_be_there", context, text)) {
            let whole = scene(3, 80);
            let smoke = Scene { meshes: Vec::new(), ..whole.clone() };
            let meshes = Scene { particles: Vec::new(), ..whole.clone() };
            let nothing = Scene { particles: Vec::new(), meshes: Vec::new(), ..whole.clone() };
            for (scene, name) in [(&smoke, "smoke"), (&meshes, "meshes"), (&nothing, "nothing")] {
                // Room for all that the whole has, and no more of it there.
                let mut world = theirs(context, &whole, 5, true);
                let spec = spec(text);
                let mut theirs = opened(context, &world, &spec);
                build(&mut theirs, &world, text);
                let filled = context.try_submit(|commands| {
                    world.particles(commands, &source(context, &scene.particles, true), AT)?;
                    world.triangles(commands, &corners(context, &scene.meshes, true))
                });
                filled.expect("filled");
                build(&mut theirs, &world, text);
                let is = answers(context, theirs.technique.as_ref(), 3, &points);
                let casts = technique::open(context, &super::world(context, scene), &spec);
                let expected = match casts {
                    Ok(mut opened) => {
                        let world = super::world(context, scene);
                        build(&mut opened, &world, text);
                        answers(context, opened.technique.as_ref(), 3, &points)
                    }
                    // It casts from nothing that is there.
                    Err(_) => vec![vec![1.0; points.len()]; 3],
                };
                let farthest =
                    is.concat().iter().zip(expected.concat()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                // Where there are no casters at all a volume is fitted to nothing, and to the meshes where there is no room either.
                assert!(farthest < 1e-6, "{text}, {name}: {farthest}");
            }
        }
    });
}

/// Strands stand behind all particles that there is room for, in another place than a scene has them.
#[test]
fn hair_and_smoke_answer_as_a_scene_does() {
    gpu_test("hair_and_smoke_answer_as_a_scene_does", |context| {
        let mut scene = scenes::locks();
        scene.lights = scenes::spot([0.4, 2.0, 3.0], 70.0, scene.clone()).lights;
        scene.lights.extend(scenes::point([0.9, 0.1, 0.3], scene.clone()).lights);
        let points = points();
        // What strands become is what `Caster` makes of them: their optical depths are theirs to say.
        let strands: Vec<_> = scene.strands.iter().zip(scene.casters().split_off(scene.particles.len())).collect();
        let words: Vec<u32> = strands
            .iter()
            .flat_map(|(strand, caster)| {
                let [a, b] = [strand.start, strand.end].map(|end| end.map(f32::to_bits));
                [a[0], a[1], a[2], NAN, b[0], b[1], b[2], caster.density.to_bits(), strand.radius.to_bits()]
            })
            .collect();
        let at = StrandAt { start: 0, end: 16, radius: Number::At(32), depth: Number::At(28) };
        let texts = [
            "avsm:path=binned,size=28",
            "avsm:path=two-pass,size=28",
            "beer-shadow-map:size=28",
            "voxel-grid",
            "uncompressed:size=28",
        ];
        for text in texts.into_iter().filter(|text| runs("hair_and_smoke_answer_as_a_scene_does", context, text)) {
            let ours = super::world(context, &scene);
            for on_device in [false, true] {
                let capacity = Capacity { particles: 90, strands: 1100, triangles: 0, lights: 2 };
                let mut world = World::of(context, capacity).expect("room");
                let count = count(context, strands.len(), on_device);
                let theirs = Source { buffer: buffer(context, &words), offset: 0, stride: 36, count };
                // Hair first: the room for smoke is empty then.
                let strands = context.try_submit(|commands| {
                    world.lights(commands, &scene.lights)?;
                    world.strands(commands, &theirs, at)
                });
                strands.expect("filled");
                assert!(world.casters.read::<Caster>(90).expect("read").iter().all(|caster| caster.radius == 0.0));
                fill(context, &mut world, &scene, on_device);
                let answers = [&ours, &world].map(|world| {
                    let mut opened = opened(context, world, &spec(text));
                    build(&mut opened, world, text);
                    bits(answers(context, opened.technique.as_ref(), 2, &points))
                });
                assert!(answers[0] == answers[1], "{text}, counts on the device: {on_device}");
            }
        }
    });
}

/// More than there is room for, and what has no place or no size.
#[test]
fn what_is_no_caster_casts_nothing() {
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
            for text in ["beer-shadow-map:size=28", "shadow-map:size=64", "voxel-grid"] {
                let (ours, mut theirs) = (super::world(context, &good), theirs(context, &mixed, 3, true));
                let answers = [&ours, &theirs].map(|world| {
                    let mut opened = opened(context, world, &spec(text));
                    build(&mut opened, world, text);
                    bits(answers(context, opened.technique.as_ref(), 3, &points))
                });
                assert!(answers[0] == answers[1], "{text}, {value}");
                let triangles = good.meshes.iter().map(|m| m.triangles.len() as u32).sum::<u32>();
                let expected = Gathered { asked: [63, 0, triangles + 2], refused: [3, 0, 2] };
                let frame = fill(context, &mut theirs, &mixed, true);
                assert_eq!(theirs.gathered(frame).expect("read"), Some(expected), "{value}");
            }
        }
        // Two more are written than there is room for: the last two are left out.
        let mut world = World::of(context, Capacity { particles: 58, lights: 3, ..Capacity::default() }).expect("room");
        let fewer = Scene { particles: good.particles[..58].to_vec(), meshes: Vec::new(), ..good.clone() };
        let frame = fill(context, &mut world, &Scene { meshes: Vec::new(), ..good.clone() }, true);
        assert_eq!(world.gathered(frame).expect("read"), Some(Gathered { asked: [60, 0, 0], refused: [0; 3] }));
        assert_eq!(world.casters.read::<Caster>(58).expect("read"), fewer.casters());
    });
}

fn cause(result: gobo::Result<()>) -> String {
    result.expect_err("an error").to_string()
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
            let too_many = world.particles(commands, &good, AT);
            assert!(cause(too_many).contains("20, and the world has room for 19"));
            let short = Source { count: Count::Host(19), stride: 64, ..good.clone() };
            assert!(cause(world.particles(commands, &short, AT)).contains("the buffer holds 15"));
            let odd = Source { count: Count::Host(1), offset: 6, ..good.clone() };
            assert!(cause(world.particles(commands, &odd, AT)).contains("6 bytes"));
            let outside = Count::Device { buffer: good.buffer.clone(), offset: good.buffer.bytes() };
            assert!(
                cause(world.particles(commands, &Source { count: outside, ..good.clone() }, AT)).contains("a count")
            );
            assert!(cause(world.triangles(commands, &corners(context, &scene.meshes, false))).contains("room for 5"));
            assert!(cause(ours.particles(commands, &good, AT)).contains("a scene fills this world"));
            let mut light = scene.lights.clone();
            light.push(light[0]);
            assert!(cause(world.lights(commands, &light)).contains("room for 3"));
            light.pop();
            light[1].radius = f64::NAN;
            assert!(cause(world.lights(commands, &light)).contains("light 1"));
            world.lights(commands, &scene.lights).expect("lights");
            light.clone_from(&scene.lights);
            light.swap(0, 2);
            assert!(cause(world.lights(commands, &light)).contains("light 0 has another number of maps"));
        });
        passes.expect("submitted");
        assert!(cause(world.set_box([0.0; 3], [1.0, f32::NAN, 1.0])).contains("from"));
        assert!(matches!(world.scene(), Err(Error::Refused { .. })) && world.replace(&scene).is_err());
        let refused = |text: &str, world: &World| match technique::open(context, world, &spec(text)) {
            Err(Error::Refused { needs }) => needs,
            Err(error) => panic!("{text}: {error}"),
            Ok(_) => "nothing".into(),
        };
        let direction = |light: &&Light| matches!(light.kind, LightKind::Directional { .. });
        let sun: Vec<_> = scene.lights.iter().filter(direction).copied().collect();
        let mut world = World::of(context, capacity).expect("room");
        context.submit(|commands| world.lights(commands, &sun).expect("lights")).expect("submitted");
        assert!(refused("voxelized:size=64", &world).contains("World::set_box"));
        world.set_box([-1.0; 3], [1.0; 3]).expect("a box");
        assert_eq!(refused("voxelized:size=64", &world), "nothing");
    });
}

/// Where lights go the others are answered to the same bits. A technique says where there are more lights than it was opened for, but for what
/// keeps nothing of a light; opened anew, or begun with as many, all are those of a scene.
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
            let capacity = Capacity { particles: 60, strands: 0, triangles, lights: 3 };
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
    context.try_submit(|commands| world.lights(commands, lights)).map(|_| ())
}

/// Lights are raised one by one, and nothing is recorded where none has changed.
#[test]
fn lights_that_stand_are_left() {
    gpu_test("lights_that_stand_are_left", |context| {
        let scene = scene(6, 20);
        let mut world = theirs(context, &scene, 0, false);
        let before = world.generations().clone();
        let mut lights = scene.lights.clone();
        let mut set = |lights: &[Light]| {
            let recorded =
                context.submit(|commands| world.lights(commands, lights).expect("lights")).expect("submitted");
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

/// Numbers that a buffer may hold.
fn word(random: &mut Random, all: bool) -> u32 {
    let odd = [NAN, 0xFFFF_FFFF, 0x7F80_0000, 0xFF80_0000, 0x7F7F_FFFF, 0xFF7F_FFFF, 0x8000_0000, 0];
    let small = [1, 0x8000_0001, 0x0080_0000];
    match random.bits() % 40 {
        i if i < 8 => odd[i as usize],
        i if all && i < 11 => small[i as usize - 8],
        12 => random.between(-1.0, 1.0).to_bits(),
        _ => random.between(0.01, 2.0).to_bits(),
    }
}

/// Casters and triangles of any bits equal their twins, byte for byte.
#[test]
fn what_is_gathered_equals_its_twin() {
    gpu_test("what_is_gathered_equals_its_twin", |context| {
        let mut random = Random::new(7);
        for (slots, live, stride) in some([(500, 300, 9), (64, 64, 8), (65, 0, 11), (3000, 2999, 5), (1, 1, 9)], 3) {
            let start = 3;
            let mut words: Vec<u32> = (0..start + stride * slots).map(|_| word(&mut random, true)).collect();
            let spheres = CasterAt { start, stride, position: 0, end: None, radius: Ok(4), density: Err(0.5) };
            let (expected, refused) = casters(&words, &spheres, slots, live);
            let capacity =
                Capacity { particles: slots as u32, strands: slots as u32, triangles: slots as u32, lights: 0 };
            let mut world = World::of(context, capacity).expect("room");
            let from = |words: &[u32]| Source {
                buffer: buffer(context, words),
                offset: 4 * start as u64,
                stride: 4 * stride as u32,
                count: count(context, live, true),
            };
            let at = SphereAt { position: 0, radius: Number::At(16), extinction: Number::Is(0.5) };
            let frame = record(context, |commands| world.particles(commands, &from(&words), at));
            let is: Vec<Caster> = world.casters.read(slots).expect("read");
            assert!(bytemuck::cast_slice::<_, u8>(&is) == bytemuck::cast_slice::<_, u8>(&expected), "{slots} spheres");
            assert_eq!(refused_in(&world, frame)[0], refused);
            if stride >= 8 {
                // Differences that a device may flush are none of the contract.
                words = (0..start + stride * slots).map(|_| word(&mut random, false)).collect();
                let strands = CasterAt { end: Some(4), radius: Ok(3), density: Ok(7), ..spheres };
                let (expected, refused) = casters(&words, &strands, slots, live);
                let at = StrandAt { start: 0, end: 16, radius: Number::At(12), depth: Number::At(28) };
                let frame = record(context, |commands| world.strands(commands, &from(&words), at));
                let is: Vec<Caster> = world.casters.read_from(slots, slots).expect("read");
                assert!(
                    bytemuck::cast_slice::<_, u8>(&is) == bytemuck::cast_slice::<_, u8>(&expected),
                    "{slots} strands"
                );
                assert_eq!(refused_in(&world, frame)[1], refused);
            }
            let indices: Vec<u32> = (0..3 * slots).map(|_| random.bits() % (slots as u32 + 9)).collect();
            for indices in [Some(indices), None] {
                let place = [0.0; 3];
                let albedo = [0.1, 0.2, 0.3];
                let live = if indices.is_some() { live } else { live / 3 };
                let vertices =
                    Vertices { words: &words, start, stride, count: slots, indices: indices.as_deref(), albedo, place };
                let (expected, refused) = vertices.triangles(slots, live);
                let corners = Corners {
                    vertices: buffer(context, &words),
                    offset: 4 * start as u64,
                    stride: 4 * stride as u32,
                    indices: indices.as_ref().map(|indices| (buffer(context, indices), 0)),
                    count: count(context, live, true),
                    albedo,
                };
                let frame = record(context, |commands| world.triangles(commands, &corners));
                let is: Vec<[[f32; 3]; 4]> = world.triangles.read(slots).expect("read");
                let same = bytemuck::cast_slice::<_, u8>(&is) == bytemuck::cast_slice::<_, u8>(&expected);
                assert!(same, "{slots} triangles, {live} of them theirs, indices: {}", indices.is_some());
                assert_eq!(refused_in(&world, frame)[2], refused);
            }
        }
    });
}
