//! A world filled by the caller's buffers gives the same look-ups as a scene of the same casters.

use super::{answers, build, opened};
use crate::support::alike::assert_alike;
use crate::support::scenes::{self, Random};
use crate::support::{every_path, gpu_test, runs, some, spec};
use gobo::gpu::{Buffer, Commands, Context};
use gobo::scene::{Caster, Mesh, Particle, Scene};
use gobo::technique::{self, Lifetime, Spec};
use gobo::world::{Capacity, Corners, Count, Number, Source, SphereAt, StrandAt, World};

/// Words from one of the caller's particles to the next, and words before the first.
const STRIDE: usize = 12;
const FIRST: usize = 4;

/// The position follows one of the caller's own numbers, and extinction precedes radius.
pub const AT: SphereAt = SphereAt { position: 4, radius: Number::At(40), extinction: Number::At(20) };

pub const NAN: u32 = 0x7FC0_0000;

/// Smoke, an object and the ground, under a directional light, a spot and a point light. The first caster along x and the first vertex are
/// at the origin, from which a world without a box measures.
pub fn scene(seed: u64, count: usize) -> Scene {
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
    scene.meshes.push(Mesh { name: "thing".into(), positions, triangles: thing, albedo, solid: false, alpha: None });
    scene.meshes.push(scenes::level(-1.2, 1.0, [1.2, 0.0]));
    scene
}

/// Returns words that no pass may mistake for data.
fn junk(count: usize) -> Vec<u32> {
    (0..count as u32).map(|i| if i % 2 == 0 { NAN } else { 0xFFFF_FFFF }).collect()
}

/// Returns particles in the caller's layout, with junk between their numbers.
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

pub fn buffer(context: &Context, words: &[u32]) -> Buffer {
    Buffer::with_data(context, "theirs", words).expect("room")
}

/// Returns a count known to the host, or one on the device.
pub fn count(context: &Context, count: usize, on_device: bool) -> Count {
    if on_device {
        return Count::Device { buffer: buffer(context, &[NAN, NAN, count as u32]), offset: 8 };
    }
    Count::Host(count as u32)
}

pub fn source(context: &Context, particles: &[Particle], on_device: bool) -> Source {
    let buffer = buffer(context, &laid_out(particles));
    Source {
        buffer,
        offset: 4 * FIRST as u64,
        stride: 4 * STRIDE as u32,
        count: count(context, particles.len(), on_device),
    }
}

/// Returns vertices at a stride of 20 bytes, and indices after one word.
pub fn corners(context: &Context, meshes: &[Mesh], on_device: bool) -> Corners {
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
        alpha: None,
    }
}

/// Returns a world for the scene's casters and lights, with room for `more` of each.
pub fn theirs(context: &Context, scene: &Scene, more: u32, on_device: bool) -> World {
    let triangles: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let capacity = Capacity {
        particles: scene.particles.len() as u32 + more,
        triangles: triangles as u32 + if triangles > 0 { more } else { 0 },
        lights: scene.lights.len() as u32,
        ..Capacity::default()
    };
    let mut world = World::of(context, capacity).expect("room");
    fill(context, &mut world, scene, on_device);
    world
}

/// Fills the world, and returns the frame that does so.
pub fn fill(context: &Context, world: &mut World, scene: &Scene, on_device: bool) -> u64 {
    record(context, |commands| {
        world.update_lights(commands, &scene.lights)?;
        world.update_particles(commands, &source(context, &scene.particles, on_device), AT)?;
        if !scene.meshes.is_empty() {
            world.update_triangles(commands, &corners(context, &scene.meshes, on_device))?;
        }
        Ok(())
    })
}

/// Runs a recording, and returns its frame.
pub fn record(context: &Context, pass: impl FnOnce(&mut Commands) -> gobo::Result<()>) -> u64 {
    let mut frame = 0;
    let ran = context.try_submit(|commands| {
        frame = commands.frame();
        pass(commands)
    });
    ran.expect("recorded and submitted");
    frame
}

pub fn refused_in(world: &World, frame: u64) -> [u32; 5] {
    world.gathered(frame).expect("read").expect("the last that gathered").refused
}

pub fn specs(test: &str, context: &Context) -> Vec<Spec> {
    let mut specs = every_path(test, context);
    // The scene has no virtual lights and no box.
    let fits = |spec: &Spec| spec.entry.lifetime == Lifetime::Frame && !["ism", "ray-query"].contains(&spec.entry.name);
    specs.retain(|spec| fits(spec) && runs(test, context, &spec.short()));
    specs
        .iter_mut()
        .filter(|spec| spec.entry.name != "voxel-grid")
        .for_each(|spec| spec.set(gobo::technique::Name::SIZE, "28"));
    specs
}

pub fn points() -> Vec<[f32; 3]> {
    let mut random = Random::new(43);
    (0..1500).map(|_| [random.between(-0.4, 2.4), random.between(-1.4, 1.4), random.between(-1.4, 1.4)]).collect()
}

/// Returns an error's message.
pub fn cause(result: gobo::Result<()>) -> String {
    result.expect_err("an error").to_string()
}

pub fn bits(answers: Vec<Vec<f32>>) -> Vec<Vec<u32>> {
    answers.into_iter().map(|light| light.into_iter().map(f32::to_bits).collect()).collect()
}

/// Every path gives the same bytes as for a scene, with more room than needed and counts on the host or on the device, even after
/// everything has moved.
#[test]
fn buffers_answer_as_a_scene_does() {
    if crate::support::is_costly("buffers_answer_as_a_scene_does") {
        return;
    }
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
                    answers(context, opened.technique.as_ref(), 3, &points).concat()
                })
                .into();
            assert!(expected[0] != expected[1] && expected[0].iter().any(|answer| *answer != 1.0), "{what}");
            for on_device in [false, true] {
                let mut world = theirs(context, &first, 70, on_device);
                let mut opened = opened(context, &world, &spec);
                build(&mut opened, &world, &what);
                let is = answers(context, opened.technique.as_ref(), 3, &points).concat();
                assert_alike(&spec, 150, &is, &expected[0], &format!("{what}, count on the device: {on_device}"));
                assert_eq!(build(&mut opened, &world, &what).passes, vec![], "{what}: nothing has moved");
                fill(context, &mut world, &next, on_device);
                build(&mut opened, &world, &what);
                let is = answers(context, opened.technique.as_ref(), 3, &points).concat();
                assert_alike(&spec, 90, &is, &expected[1], &format!("{what}, moved, count on the device: {on_device}"));
            }
        }
    });
}

/// A world may hold less than it has room for: smoke alone, meshes alone, or nothing. Every run tests the five specs that a caller would
/// choose first.
#[test]
fn what_there_is_room_for_need_not_be_there() {
    if crate::support::is_costly("what_there_is_room_for_need_not_be_there") {
        return;
    }
    gpu_test("what_there_is_room_for_need_not_be_there", |context| {
        let points = points();
        let texts = [
            "avsm:path=binned,size=28",
            "psm:path=fused,size=28",
            "beer-shadow-map:size=28",
            "voxel-grid:size=64",
            "shadow-map:size=64",
        ];
        for text in texts.into_iter().filter(|text| runs("what_there_is_room_for_need_not_be_there", context, text)) {
            let whole = scene(3, 80);
            let smoke = Scene { meshes: Vec::new(), ..whole.clone() };
            let meshes = Scene { particles: Vec::new(), ..whole.clone() };
            let nothing = Scene { particles: Vec::new(), meshes: Vec::new(), ..whole.clone() };
            for (scene, name) in [(&smoke, "smoke"), (&meshes, "meshes"), (&nothing, "nothing")] {
                // The world has room for the entire scene, but holds only this part of it.
                let mut world = theirs(context, &whole, 5, true);
                let spec = spec(text);
                let mut theirs = opened(context, &world, &spec);
                build(&mut theirs, &world, text);
                let filled = context.try_submit(|commands| {
                    world.update_particles(commands, &source(context, &scene.particles, true), AT)?;
                    world.update_triangles(commands, &corners(context, &scene.meshes, true))
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
                    // The technique refuses a scene in which nothing casts for it: all is lit.
                    Err(_) => vec![vec![1.0; points.len()]; 3],
                };
                let farthest =
                    is.concat().iter().zip(expected.concat()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                // Without casters this world fits a map's volume to nothing; a scene without room for casters fits it to the meshes.
                assert!(farthest < 1e-6, "{text}, {name}: {farthest}");
            }
        }
    });
}

/// Strands follow the room for all particles, not the particles themselves as in a scene.
#[test]
fn hair_and_smoke_answer_as_a_scene_does() {
    if crate::support::is_costly("hair_and_smoke_answer_as_a_scene_does") {
        return;
    }
    gpu_test("hair_and_smoke_answer_as_a_scene_does", |context| {
        let mut scene = scenes::locks();
        scene.lights = scenes::spot([0.4, 2.0, 3.0], 70.0, scene.clone()).lights;
        scene.lights.extend(scenes::point([0.9, 0.1, 0.3], scene.clone()).lights);
        let points = points();
        // Strands become what `Caster` makes of them, with the caller's own optical depths.
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
            let (ours, spec) = (super::world(context, &scene), spec(text));
            for on_device in [false, true] {
                let capacity = Capacity { particles: 90, strands: 1100, lights: 2, ..Capacity::default() };
                let mut world = World::of(context, capacity).expect("room");
                let count = count(context, strands.len(), on_device);
                let theirs = Source { buffer: buffer(context, &words), offset: 0, stride: 36, count };
                // Hair first, while the room for smoke is still empty.
                let strands = context.try_submit(|commands| {
                    world.update_lights(commands, &scene.lights)?;
                    world.update_strands(commands, &theirs, at)
                });
                strands.expect("filled");
                assert!(
                    world.buffers().casters.read::<Caster>(90).expect("read").iter().all(|caster| caster.radius == 0.0)
                );
                fill(context, &mut world, &scene, on_device);
                let [expected, is] = [&ours, &world].map(|world| {
                    let mut opened = opened(context, world, &spec);
                    build(&mut opened, world, text);
                    answers(context, opened.technique.as_ref(), 2, &points)
                });
                let what = format!("{text}, counts on the device: {on_device}");
                assert_alike(&spec, scene.casters().len(), &is.concat(), &expected.concat(), &what);
            }
        }
    });
}
