//! Lights from the caller's buffers give the same look-ups as the same lights from the host.

use super::buffers::{self, NAN, buffer, cause, count, points, record, scene};
use super::{answers, build, opened};
use crate::support::alike::assert_alike;
use crate::support::scenes::Random;
use crate::support::{gpu_test, runs, some, spec};
use glam::DVec3;
use gobo::gpu::{Commands, Context};
use gobo::lights::indirect::Vpls;
use gobo::maps::Map;
use gobo::reference::twin::fit::{Aiming, aim};
use gobo::scene::{Light, LightKind, Scene, View};
use gobo::shading::{Lighting, Renderer, Shading, Tiled};
use gobo::technique::{self, Spec};
use gobo::world::{Capacity, Count, LightAt, LightData, LightType, Number, Source, World};

/// Words from one of the caller's lights to the next, and words before the first.
pub const STRIDE: usize = 17;
pub const FIRST: usize = 5;

pub const AT: LightAt =
    LightAt { position: 12, direction: 32, radiance: 0, radius: Number::At(48), cos_cone: Number::At(56) };

pub fn types(lights: &[Light]) -> Vec<LightType> {
    let of = |light: &Light| match light.kind {
        LightKind::Directional { .. } => LightType::Directional,
        LightKind::Spot { .. } => LightType::Spot,
        LightKind::Point { .. } => LightType::Point,
        LightKind::Virtual { .. } => LightType::Virtual,
    };
    lights.iter().map(of).collect()
}

/// Returns lights in the caller's layout; numbers that a light lacks are NaN.
pub fn laid_out(lights: &[Light]) -> Vec<u32> {
    let mut words = vec![NAN; FIRST + STRIDE * lights.len()];
    for (i, (light, data)) in lights.iter().zip(LightData::of(lights, false)).enumerate() {
        let at = &mut words[FIRST + STRIDE * i..][..STRIDE];
        at[..3].copy_from_slice(&data.radiance.map(f32::to_bits));
        if light.position().is_some() {
            at[3..6].copy_from_slice(&data.position.map(f32::to_bits));
        }
        if data.kind != 2 {
            at[8..11].copy_from_slice(&data.direction.map(f32::to_bits));
        }
        match light.kind {
            LightKind::Directional { .. } => {}
            LightKind::Virtual { nearest, .. } => at[12] = (nearest as f32).to_bits(),
            _ => at[12] = (light.radius as f32).to_bits(),
        }
        if data.kind == 1 {
            at[14] = data.cos_cone.to_bits();
        }
    }
    words
}

pub fn source(context: &Context, lights: &[Light], on_device: bool) -> Source {
    Source {
        buffer: buffer(context, &laid_out(lights)),
        offset: 4 * FIRST as u64,
        stride: 4 * STRIDE as u32,
        count: count(context, lights.len(), on_device),
    }
}

/// Source of the lights: the host or a buffer.
#[derive(Clone, Copy, PartialEq)]
pub enum From {
    Host,
    Buffer { counts_itself: bool },
}

fn shine(context: &Context, commands: &mut Commands, world: &mut World, lights: &[Light], from: From) {
    let recorded = match from {
        From::Host => world.update_lights(commands, lights),
        From::Buffer { counts_itself } => {
            world.update_lights_from_buffer(commands, &source(context, lights, counts_itself), AT, &types(lights))
        }
    };
    recorded.expect("recorded");
}

/// Returns a world of buffers filled with the scene's casters, meshes and lights.
pub fn filled(context: &Context, scene: &Scene, from: From) -> World {
    let triangles: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let capacity = Capacity {
        particles: scene.particles.len() as u32,
        triangles: triangles as u32,
        lights: scene.lights.len() as u32,
        ..Capacity::default()
    };
    let mut world = World::of(context, capacity).expect("room");
    world.set_camera(scene.camera);
    world.set_box([-1.5; 3], [2.5; 3]).expect("a box");
    fill(context, &mut world, scene, from);
    world
}

fn fill(context: &Context, world: &mut World, scene: &Scene, from: From) {
    record(context, |commands| {
        shine(context, commands, world, &scene.lights, from);
        world.update_particles(commands, &buffers::source(context, &scene.particles, false), buffers::AT)?;
        if world.triangle_capacity() == 0 {
            return Ok(());
        }
        world.update_triangles(commands, &buffers::corners(context, &scene.meshes, false))
    });
}

/// Returns a light that is not dark.
pub fn light_of(kind: LightKind) -> Light {
    Light { kind, radiance: [0.9, 0.8, 0.7], radius: f64::INFINITY }
}

fn directional(direction: [f64; 3]) -> Light {
    light_of(LightKind::Directional { direction: DVec3::from(direction).normalize() })
}

/// Returns a spot whose aim equals the host's to the bit, because its roots and quotients are exact: it lies in a plane of two axes and its
/// cone has an exact width.
fn spot(position: [f64; 3], direction: [f64; 3]) -> Light {
    let (position, direction) = (DVec3::from(position), DVec3::from(direction).normalize());
    let at = |cone_degrees: f64| light_of(LightKind::Spot { position, direction, cone_degrees });
    let is_exact = |light: &Light| {
        let host = Map::aimed(&aim_of(&[*light]), 16, 16, 1)[0].caster_view;
        aim(host, &aiming(&LightData::of(&[*light], false)[0])) == host
    };
    (0..100).map(|i| at(70.0 + 0.1 * f64::from(i))).find(is_exact).expect("a cone")
}

fn aim_of(lights: &[Light]) -> gobo::scene::Aim<'_> {
    gobo::scene::Aim { lights, anchors: [DVec3::ZERO; 2], has_triangles: true }
}

pub fn aiming(data: &LightData) -> Aiming {
    Aiming {
        position: (data.kind != 0).then_some(data.position),
        direction: (data.kind < 2).then_some(data.direction),
        cos_cone: (data.kind == 1).then_some(data.cos_cone),
    }
}

/// Returns the scene under three lights that the device can aim exactly, and the same after everything has moved.
fn moving() -> [Scene; 2] {
    let point = |at: [f64; 3]| light_of(LightKind::Point { position: DVec3::from(at) });
    let first = vec![directional([0.0, -0.6, -0.8]), spot([0.4, 1.8, 2.4], [0.0, -0.6, -0.8]), point([0.9, 0.1, 0.3])];
    let next = vec![directional([0.6, 0.0, -0.8]), spot([-0.8, 0.2, 2.4], [0.6, 0.0, -0.8]), point([1.1, -0.2, 0.5])];
    [Scene { lights: first, ..scene(1, 150) }, Scene { lights: next, ..scene(2, 150) }]
}

fn answered(context: &Context, scene: &Scene, world: &World, spec: &Spec) -> Vec<Vec<f32>> {
    let mut opened = opened(context, world, spec);
    build(&mut opened, world, &spec.short());
    answers(context, opened.technique.as_ref(), scene.lights.len(), &points())
}

/// Returns which lights give the same look-ups as the host's to the bit: all if the device's roots and quotients are exact, otherwise only
/// point lights.
fn exact(context: &Context, lights: &[Light]) -> Vec<bool> {
    let is_cube = |light: &Light| light.map_count() > 1;
    lights.iter().map(|light| is_cube(light) || context.features().is_software()).collect()
}

/// Every path of every technique gives the same bytes as with the host's lights, also after all of them have moved.
#[test]
fn lights_of_buffers_answer_as_the_hosts_do() {
    if crate::support::is_long("lights_of_buffers_answer_as_the_hosts_do") {
        return;
    }
    let name = "lights_of_buffers_answer_as_the_hosts_do";
    gpu_test(name, |context| {
        let (scenes, points) = (moving(), points());
        let first = ["avsm:path=binned,size=28", "shadow-map:size=28", "voxel-grid:size=64"].map(spec);
        for spec in first.into_iter().chain(some(buffers::specs(name, context), 4)) {
            let what = spec.short();
            let expected = scenes.each_ref().map(|scene| {
                let world = filled(context, scene, From::Host);
                answered(context, scene, &world, &spec)
            });
            assert!(expected[0] != expected[1] && expected[0].concat().iter().any(|answer| *answer < 0.9), "{what}");
            for counts_itself in [false, true] {
                let from = From::Buffer { counts_itself };
                let mut world = filled(context, &scenes[0], from);
                assert!(!world.knows_lights());
                let mut opened = opened(context, &world, &spec);
                for (i, expected) in expected.iter().enumerate() {
                    if i > 0 {
                        fill(context, &mut world, &scenes[i], from);
                    }
                    build(&mut opened, &world, &what);
                    let is = answers(context, opened.technique.as_ref(), 3, &points);
                    for (light, is_exact) in exact(context, &scenes[i].lights).into_iter().enumerate() {
                        if is_exact {
                            let what =
                                format!("{what}, light {light}, state {i}, count on the device: {counts_itself}");
                            assert_alike(&spec, 150, &is[light], &expected[light], &what);
                        }
                    }
                    assert_eq!(build(&mut opened, &world, &what).passes, vec![], "{what}: nothing has moved");
                }
            }
        }
    });
}

/// Lights from the host and from a buffer give the same look-ups in techniques that need other kinds of light, or fewer lights.
#[test]
fn other_lights_answer_as_the_hosts_do() {
    let name = "other_lights_answer_as_the_hosts_do";
    gpu_test(name, |context| {
        let [scene, _] = moving();
        let patch = |position: [f64; 3], normal: DVec3| {
            light_of(LightKind::Virtual { position: DVec3::from(position), normal, nearest: 0.25 })
        };
        let patches = vec![patch([0.3, 0.2, 1.3], DVec3::NEG_Z), patch([-0.6, 0.3, 0.4], DVec3::X)];
        let cases = [
            ("ism:points=1024,size=32", Scene { particles: Vec::new(), lights: patches.clone(), ..scene.clone() }),
            (
                "ism:points=1024,size=32,adaptive=off",
                Scene { particles: Vec::new(), lights: patches.clone(), ..scene.clone() },
            ),
            ("avsm:size=28", Scene { lights: patches, ..scene.clone() }),
            ("shadow-map:size=28,cascades=3", Scene { lights: scene.lights[..1].to_vec(), ..scene.clone() }),
            ("half-angle:size=28", Scene { lights: scene.lights[1..2].to_vec(), ..scene.clone() }),
            ("ray-query", scene.clone()),
        ];
        for (text, scene) in cases.into_iter().filter(|(text, _)| text.starts_with("ism") || runs(name, context, text))
        {
            let spec = spec(text);
            let [expected, is] = [From::Host, From::Buffer { counts_itself: true }]
                .map(|from| answered(context, &scene, &filled(context, &scene, from), &spec));
            assert!(expected.concat().iter().any(|answer| *answer < 0.9), "{text}");
            for (light, is_exact) in exact(context, &scene.lights).into_iter().enumerate() {
                if is_exact {
                    assert_alike(&spec, 150, &is[light], &expected[light], &format!("{text}, light {light}"));
                }
            }
        }
    });
}

/// Many lights in tiles, through a grid: culling and shading read the gathered lights. Radii are powers of two, so that the quotients of
/// their squares are exact.
#[test]
fn many_lights_of_a_buffer_shade_as_the_hosts_do() {
    let name = "many_lights_of_a_buffer_shade_as_the_hosts_do";
    gpu_test(name, |context| {
        let mut random = Random::new(23);
        let lamp = |i: u32| {
            let position = DVec3::from(random.point(-1.0, 1.0).map(f64::from));
            Light { radius: [0.5, 1.0, 2.0][i as usize % 3], ..light_of(LightKind::Point { position }) }
        };
        let lights = (0..70).map(lamp).collect();
        let scene = Scene { lights, particles: Vec::new(), ..scene(4, 20) };
        let pictures = [From::Host, From::Buffer { counts_itself: true }].map(|from| {
            let world = filled(context, &scene, from);
            let mut opened = opened(context, &world, &spec("voxel-grid:size=64"));
            build(&mut opened, &world, name);
            let camera = View::camera(&scene.camera, &scene, [48, 32]);
            let renderer = Renderer::new(context, &world, &camera).expect("a renderer");
            let shading = Shading::Tiled(Tiled::default());
            renderer.picture_of(opened.technique.as_ref(), shading, Lighting::Fragment).expect("drawn")
        });
        assert!(pictures[0].pixels.iter().any(|pixel| *pixel != pictures[0].pixels[0]), "nothing is lit");
        if context.features().is_software() {
            assert!(pictures[0] == pictures[1], "another picture");
        }
    });
}

/// Virtual lights have the same positions as with the host's lights, and move with the lights that create them.
#[test]
fn virtual_lights_are_of_what_a_buffer_says() {
    let name = "virtual_lights_are_of_what_a_buffer_says";
    gpu_test(name, |context| {
        // Except on software devices, only point lights are bit-identical on host and device, and so are the surface points that they
        // light.
        let kinds = if context.features().is_software() { 0..3 } else { 2..3 };
        let scenes = moving().map(|scene| Scene { lights: scene.lights[kinds.clone()].to_vec(), ..scene });
        let made = |from: From| {
            let mut world = filled(context, &scenes[0], from);
            let mut vpls = Vpls::new(context, &world, 64).expect("virtual lights");
            scenes.each_ref().map(|scene| {
                fill(context, &mut world, scene, from);
                vpls.make(&world).expect("made");
                vpls.read().expect("read")
            })
        };
        let expected = made(From::Host);
        let radiance = |lights: &[Light]| lights.iter().map(|light| light.radiance[0]).sum::<f32>();
        assert!(expected.iter().all(|lights| radiance(lights) > 0.0) && expected[0] != expected[1], "they move");
        for counts_itself in [false, true] {
            assert!(made(From::Buffer { counts_itself }) == expected, "count on the device: {counts_itself}");
        }
    });
}

/// Switches from host to buffer, to fewer lights, and back: look-ups are always those of the current lights, to the bit.
#[test]
fn lights_of_a_buffer_come_and_go() {
    gpu_test("lights_of_a_buffer_come_and_go", |context| {
        let ([scene, _], spec) = (moving(), spec("avsm:size=28"));
        // The directions are oblique, so the host's and the device's views are not bit-identical.
        let slanted = Scene { lights: vec![directional([0.5, 0.3, -0.81]); 2], ..scene.clone() };
        let two = Scene { lights: vec![scene.lights[0], directional([0.6, 0.0, -0.8])], ..scene.clone() };
        let of = |scene: &Scene| answered(context, scene, &filled(context, scene, From::Host), &spec);
        let (host, device) = (of(&slanted), of(&two));
        let mut world = filled(context, &slanted, From::Host);
        let mut opened = opened(context, &world, &spec);
        let from = From::Buffer { counts_itself: true };
        for is_host in [true, false, true, false] {
            let (lit, expected, from) = if is_host { (&slanted, &host, From::Host) } else { (&two, &device, from) };
            record(context, |commands| {
                shine(context, commands, &mut world, &lit.lights, from);
                Ok(())
            });
            assert_eq!(world.knows_lights(), is_host);
            build(&mut opened, &world, "lit anew");
            let is = answers(context, opened.technique.as_ref(), 2, &points());
            if is_host || context.features().is_software() {
                assert_alike(&spec, 150, &is.concat(), &expected.concat(), &format!("of the host's: {is_host}"));
            }
        }
        // Keeps one of the two lights: first by a smaller count, then also by a shorter list of types.
        for fewer in 0..2 {
            let types = &types(&two.lights)[fewer..];
            let one = Source { count: count(context, 1, true), ..source(context, &two.lights, true) };
            record(context, |commands| world.update_lights_from_buffer(commands, &one, AT, types));
            build(&mut opened, &world, "one");
            let radiances =
                world.buffers().lights.read::<LightData>(2).expect("read").into_iter().map(|light| light.radiance);
            assert_eq!(radiances.collect::<Vec<_>>(), [two.lights[0].radiance, [0.0; 3]]);
            let is = answers(context, opened.technique.as_ref(), 1, &points());
            if context.features().is_software() {
                assert_alike(&spec, 150, &is[0], &device[0], "one of both");
            }
        }
    });
}

/// Errors that the host can detect are reported, and techniques that need the host's lights are refused by name.
#[test]
fn what_is_wrong_with_lights_of_a_buffer_is_said() {
    gpu_test("what_is_wrong_with_lights_of_a_buffer_is_said", |context| {
        let [scene, _] = moving();
        let mut world = filled(context, &scene, From::Host);
        let (all, kinds) = (source(context, &scene.lights, false), types(&scene.lights));
        let passes = context.submit(|commands| {
            let mut said = |source: &Source, at, kinds: &[LightType]| {
                cause(world.update_lights_from_buffer(commands, source, at, kinds))
            };
            assert!(
                said(&all, AT, &[&kinds[..], &kinds[..1]].concat()).contains("4 lights, and the world has room for 3")
            );
            assert!(said(&all, AT, &kinds[..2]).contains("3 lights, and types of 2"));
            let swapped = [kinds[2], kinds[1], kinds[0]];
            assert!(said(&all, AT, &swapped).contains("light 0 has another number of maps"));
            assert!(said(&Source { stride: 80, ..all.clone() }, AT, &kinds).contains("the buffer holds 2"));
            assert!(said(&all, LightAt { radiance: 2, ..AT }, &kinds).contains("2 bytes"));
            let outside = Count::Device { buffer: all.buffer.clone(), offset: all.buffer.bytes() };
            assert!(said(&Source { count: outside, ..all.clone() }, AT, &kinds).contains("a count"));
        });
        passes.expect("submitted");
        let is: Vec<LightData> = world.buffers().lights.read(3).expect("read");
        assert!(world.knows_lights() && is == LightData::of(&scene.lights, true), "nothing was recorded");
        let mut ours = super::world(context, &scene);
        let of_a_scene = context.try_submit(|commands| ours.update_lights_from_buffer(commands, &all, AT, &kinds));
        assert!(cause(of_a_scene.map(|_| ())).contains("a scene fills this world"));

        let needs = |world: &World, text: &str| match technique::open(context, world, &spec(text)) {
            Err(gobo::Error::Refused(needs)) => needs,
            Err(error) => panic!("{text}: {error}"),
            Ok(_) => "nothing".into(),
        };
        let sun = Scene { lights: scene.lights[..1].to_vec(), ..scene.clone() };
        let device = filled(context, &sun, From::Buffer { counts_itself: false });
        assert_eq!(needs(&device, "voxelized:size=64"), "lights that the host knows (World::update_lights)".into());
        // A baked technique is refused each time it is recorded, and bakes again once the host knows the lights.
        let mut known = filled(context, &sun, From::Host);
        let mut baked = opened(context, &known, &spec("voxelized:size=64"));
        build(&mut baked, &known, "voxelized");
        let its = source(context, &sun.lights, false);
        let kinds = types(&sun.lights);
        context.try_submit(|commands| known.update_lights_from_buffer(commands, &its, AT, &kinds)).expect("gathered");
        for _ in 0..2 {
            let recorded = context.try_submit(|commands| baked.technique.record(commands, &known));
            assert!(matches!(recorded, Err(gobo::Error::Refused(_))), "baked from lights of before");
        }
        context.try_submit(|commands| known.update_lights(commands, &sun.lights)).expect("copied");
        context.try_submit(|commands| baked.technique.record(commands, &known)).expect("the host knows them");
        let mut grid = opened(context, &device, &spec("voxel-grid:size=64"));
        build(&mut grid, &device, "voxel-grid");
        assert!(grid.technique.inspect().resolution().is_empty(), "it is not known where edges are seen from");
        assert_eq!(needs(&device, "ism"), gobo::Need::VirtualLights);
    });
}
