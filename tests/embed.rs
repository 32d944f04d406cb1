//! The renderer of examples/engine, which uses Gobo as any other engine would: its answers must equal the program's, Gobo must neither
//! submit nor wait, memory must stay constant, and the validation layer must be silent. Also the engine of examples/minimal.rs.

#![cfg(feature = "program")]

mod support;

#[path = "embed/engine.rs"]
mod engine;
#[path = "embed/measure.rs"]
mod measure;
#[path = "embed/minimal.rs"]
mod minimal;
#[path = "../examples/engine/renderer/mod.rs"]
mod renderer;

use engine::{Engine, MOST_POINTS, Optional, Particle, Setup, Sun};
use gobo::gpu::{Buffer, Commands, Context, Features};
use gobo::query::Query;
use gobo::scene::{Camera, Light, LightKind, Scene};
use gobo::technique::{self, Spec};
use gobo::world::{Capacity, Count, LightAt, LightType, Number, Source, SphereAt, World};
use renderer::{Options, PARTICLES, TO_SUN};
use support::{all, gpu_test, log, skipped, some};

/// Techniques under test, with small settings.
const TECHNIQUES: [&str; 3] = ["avsm:nodes=8,size=64", "psm:size=64,slices=64", "beer-shadow-map:size=64"];

/// Rate at which a device turns the sun, if it does, in radians per second.
const TURN_PER_S: f32 = 0.4;

fn spec(text: &str) -> Spec {
    technique::parse(text, &[]).expect(text).remove(0)
}

fn setup(text: &str, optional: Optional, timestamps: bool) -> Setup {
    let options = Options { technique: spec(text), turn_per_s: 0.0, painted: false, size: [48, 36] };
    Setup { options, optional, timestamps, validation: true }
}

/// Runs an engine under the validation layer. By the time it has closed, the layer must have reported nothing, and Gobo must not have
/// called a function that submits or waits.
fn engine_test(name: &str, setup: &Setup, body: impl FnOnce(&mut Engine)) {
    let mut engine = Engine::open(setup).expect("a device of Vulkan 1.3 and the validation layer");
    log("exercised", name, &engine.renderer.gpu.name);
    body(&mut engine);
    let (said, counts) = (engine.said.clone(), engine.counts.clone());
    drop(engine);
    assert_eq!(said.all(), [""; 0], "{name}");
    assert!(counts.calls().is_empty(), "{name}: Gobo called {:?}", counts.calls());
}

/// Runs frames, and returns the time of the last, in seconds.
fn frames(engine: &mut Engine, count: u32) -> f32 {
    let time_s = |frame: u32| 2.0 + frame as f32 / 60.0;
    for frame in 0..count {
        engine.renderer.frame(time_s(frame)).expect("a frame");
    }
    time_s(count - 1)
}

/// Returns points in and around the smoke and on the ground: a low-discrepancy sequence from the generalized golden ratio (Roberts 2018).
fn points() -> Vec<[f32; 3]> {
    let part = |i: usize, by: f64| (0.5 + by * (i + 1) as f64).fract();
    let point = |i| {
        let [x, y, z] = [0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9].map(|by| part(i, by));
        let z = if i % 4 == 0 { 0.0 } else { 2.6 * z };
        [3.6 * x - 0.8, 2.0 * y - 1.0, z].map(|p| p as f32)
    };
    (0..MOST_POINTS as usize).map(point).collect()
}

/// Hashes a number to [0, 1), as in examples/engine/shaders/move.comp.
fn evenly(number: u32) -> f32 {
    let state = number.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (((word >> 22) ^ word) >> 8) as f32 / 16_777_216.0
}

/// Returns a particle's position at a time, as in the same shader.
fn place(i: u32, time_s: f32) -> [f32; 3] {
    let puff = i / 64;
    let age = (time_s * 0.125 + puff as f32 * 0.015_625).fract();
    let (turn, reach) = (std::f32::consts::TAU * evenly(puff), 0.05 + 0.3 * age);
    let centre = [reach * turn.cos() + 0.45 * age * age, reach * turn.sin(), 0.25 + 1.9 * age];
    let own = 0x10000 + 3 * i;
    let (around, height) = (std::f32::consts::TAU * evenly(own), 2.0 * evenly(own + 1) - 1.0);
    let (flat, far) = ((1.0 - height * height).sqrt(), (0.1 + 0.2 * age) * evenly(own + 2).cbrt());
    [centre[0] + far * flat * around.cos(), centre[1] + far * flat * around.sin(), centre[2] + far * height]
}

#[test]
fn particles_are_where_the_law_puts_them() {
    engine_test("particles_are_where_the_law_puts_them", &setup(TECHNIQUES[0], Optional::All, true), |engine| {
        let time_s = frames(engine, 3);
        let particles = engine.particles().expect("read");
        assert_eq!(particles.len(), PARTICLES as usize);
        for (i, particle) in particles.iter().enumerate() {
            let off = particle.position.iter().zip(place(i as u32, time_s)).map(|(is, law)| (is - law).abs());
            // Vulkan allows `sin` an absolute error of 2⁻¹¹.
            assert!(off.fold(0.0, f32::max) < 2e-3, "particle {i}: {particle:?}");
        }
    });
}

/// Returns a scene of the program with the same casters and the same light.
fn scene(particles: &[Particle]) -> Scene {
    let particle =
        |p: &Particle| gobo::scene::Particle { position: p.position, radius: p.radius, extinction: p.extinction };
    let direction = -TO_SUN.as_dvec3().normalize();
    let sun = LightKind::Directional { direction };
    Scene {
        name: "embed".into(),
        particles: particles.iter().map(particle).collect(),
        lights: vec![Light { kind: sun, radiance: [1.0; 3], radius: f64::INFINITY }],
        camera: Camera {
            position: -4.0 * glam::DVec3::Y,
            target: glam::DVec3::ZERO,
            up: glam::DVec3::Z,
            fov_y_degrees: 40.0,
        },
        ..Scene::default()
    }
}

/// The only light, known to the host or stored in a buffer.
#[derive(Clone, Copy)]
enum Shines {
    Host(Light),
    Buffer(Sun),
}

/// Creates a world with the same particles in a buffer, as in the engine, on the program's own device. Its views are relative to the centre
/// of the box.
fn of_a_buffer(
    context: &Context,
    particles: &[Particle],
    shines: Shines,
    boxed: Option<([f32; 3], [f32; 3])>,
) -> World {
    let count = particles.len() as u32;
    let capacity = Capacity { particles: count, lights: 1, ..Capacity::default() };
    let mut world = World::of(context, capacity).expect("room");
    if let Some((low, high)) = boxed {
        world.set_box(low, high).expect("a box");
    }
    let buffer = Buffer::with_data(context, "particles", particles).expect("room");
    let source = Source { buffer, offset: 0, stride: size_of::<Particle>() as u32, count: Count::Host(count) };
    let record = |commands: &mut Commands| {
        match shines {
            Shines::Host(light) => world.update_lights(commands, &[light]),
            Shines::Buffer(sun) => {
                let buffer = Buffer::with_data(context, "sun", &[sun]).expect("room");
                let source = Source { buffer, offset: 0, stride: size_of::<Sun>() as u32, count: Count::Host(1) };
                let none = Number::Is(1.0);
                let at = LightAt { position: 0, direction: 0, radiance: 12, radius: none, cos_cone: none };
                world.update_lights_from_buffer(commands, &source, at, &[LightType::Directional])
            }
        }
        .expect("recorded");
        world.update_particles(commands, &source, SphereAt::PARTICLE).expect("recorded");
    };
    context.submit(record).expect("submitted");
    world
}

/// Returns the program's answers for a world.
fn program(context: &Context, text: &str, world: &World, points: &[[f32; 3]]) -> Vec<f32> {
    let mut opened = technique::open(context, world, &spec(text)).expect(text);
    opened.build(world).expect("built");
    let query = Query::new(context, 0, points).expect("room");
    query.ask(&opened.technique.answer()).expect("answers")
}

/// Returns the engine's answers and its particles, after some frames.
fn answers(name: &str, setup: &Setup) -> (Vec<f32>, Vec<Particle>) {
    let mut all = (Vec::new(), Vec::new());
    engine_test(name, setup, |engine| {
        frames(engine, 5);
        all = (engine.ask(&points()).expect("answers"), engine.particles().expect("read"));
    });
    all
}

/// Returns the number of answers with different bits.
fn differing(ours: &[f32], theirs: &[f32]) -> usize {
    assert_eq!(ours.len(), theirs.len());
    ours.iter().zip(theirs).filter(|(a, b)| a.to_bits() != b.to_bits()).count()
}

/// Returns the spec with the setting that AVSM uses on devices without subgroups.
fn without_subgroups(text: &str) -> String {
    if text.starts_with("avsm") { format!("{text},batch=shared") } else { text.to_owned() }
}

/// The engine's answers must equal, to the bit, those of a world filled from a buffer on the program's own device. That world's answers
/// must equal those of a host scene if both use the same origin, which for a scene is its first caster along x.
#[test]
fn answers_are_the_programs() {
    if crate::support::is_costly("answers_are_the_programs") {
        return;
    }
    gpu_test("answers_are_the_programs", |context| {
        let points = points();
        for name in TECHNIQUES {
            let (ours, mut particles) = answers(name, &setup(name, Optional::All, true));
            let sun = Shines::Host(scene(&particles).lights[0]);
            let alike = program(context, name, &of_a_buffer(context, &particles, sun, None), &points);
            assert_eq!(differing(&ours, &alike), 0, "{name}: the same world on the program's own device");
            let shadowed = ours.iter().filter(|answer| **answer < 0.5).count();
            assert!(shadowed > points.len() / 50, "{name}: {shadowed} of {} points are in shadow", points.len());

            particles.push(Particle { position: [-4.0, 0.0, 0.0], radius: 0.25, extinction: 1.0, age: 0.0 });
            let boxed = ([-16.0, -12.0, -12.0], [8.0, 12.0, 12.0]);
            let buffer = program(context, name, &of_a_buffer(context, &particles, sun, Some(boxed)), &points);
            let scene = World::new(context, &scene(&particles)).expect("room");
            assert_eq!(differing(&buffer, &program(context, name, &scene, &points)), 0, "{name}: a scene");
            assert!(differing(&buffer, &alike) > 0, "{name}: another caster changes nothing");
        }
    });
}

/// A light turned by the renderer's own shader, which the host never sees: answers must equal those of such a light on the program's own
/// device, to the bit, and differ from those of the static light.
#[test]
fn a_light_that_the_device_turns() {
    if crate::support::is_costly("a_light_that_the_device_turns") {
        return;
    }
    const TEST: &str = "a_light_that_the_device_turns";
    gpu_test(TEST, |context| {
        let points = points();
        for name in some(TECHNIQUES, 2) {
            let mut turning = setup(name, Optional::All, true);
            turning.options.turn_per_s = TURN_PER_S;
            engine_test(TEST, &turning, |engine| {
                let time_s = frames(engine, 5);
                let (ours, particles, sun) = (
                    engine.ask(&points).expect("answers"),
                    engine.particles().expect("read"),
                    engine.sun().expect("read"),
                );
                let turned = glam::Quat::from_rotation_z(TURN_PER_S * time_s) * -TO_SUN.normalize();
                // Vulkan allows `sin` an absolute error of 2⁻¹¹.
                assert!((glam::Vec3::from(sun.direction) - turned).length() < 2e-3, "{sun:?}, not {turned}");
                let is = |shines| program(context, name, &of_a_buffer(context, &particles, shines, None), &points);
                assert_eq!(differing(&ours, &is(Shines::Buffer(sun))), 0, "{name}: such a light of the program's");
                let stands = is(Shines::Host(scene(&particles).lights[0]));
                assert!(differing(&ours, &stands) > points.len() / 50, "{name}: the light has not turned");
            });
        }
    });
}

/// Features that are not enabled must not be used, and answers must not depend on them, to the bit. Without subgroups AVSM sums in another
/// order, which may also be requested on devices with subgroups.
#[test]
fn a_lesser_device_answers_alike() {
    if crate::support::is_costly("a_lesser_device_answers_alike") {
        return;
    }
    const TEST: &str = "a_lesser_device_answers_alike";
    let devices = gobo::gpu::devices().expect("devices");
    let has_interlock = devices.iter().all(|device| device.fragment_shader_pixel_interlock);
    if !has_interlock {
        skipped(TEST, "the part without interlock needs fragmentShaderPixelInterlock to switch off");
    }
    for name in some(TECHNIQUES, 1) {
        let of = |text: &str, optional, timestamps| answers(name, &setup(text, optional, timestamps)).0;
        let whole = of(name, Optional::All, true);
        let mut lessers = vec![(Optional::All, false)];
        if has_interlock {
            lessers.insert(0, (Optional::NoInterlock, false));
        }
        for (optional, timestamps) in some(lessers, 1) {
            let lesser = of(name, optional, timestamps);
            assert_eq!(differing(&whole, &lesser), 0, "{name}, {optional:?}");
        }
        let asked = of(&without_subgroups(name), Optional::All, true);
        for timestamps in some([false, true], 1) {
            let nothing = of(name, Optional::Nothing, timestamps);
            assert_eq!(differing(&asked, &nothing), 0, "{name}, nothing optional, timestamps: {timestamps}");
        }
    }
}

/// Checks the counter itself: it must count each call that submits or waits, but not those of the renderer, which submits every frame.
#[test]
#[allow(unsafe_code)]
fn what_submits_or_waits_is_counted() {
    use ash::vk;
    let mut engine = Engine::open(&setup(TECHNIQUES[2], Optional::All, true)).expect("a device");
    frames(&mut engine, 3);
    engine.renderer.run(|_, _| {}).expect("frames end");
    let (device, queue, counts) = (engine.renderer.gpu.lent.clone(), engine.renderer.gpu.queue, engine.counts.clone());
    assert!(counts.calls().is_empty(), "the renderer's own are not counted");
    // SAFETY: no frame is running, the submissions are empty, and the fence is no longer in use when it is destroyed.
    unsafe {
        device.queue_submit(queue, &[], vk::Fence::null()).expect("submitted");
        device.queue_submit2(queue, &[], vk::Fence::null()).expect("submitted");
        device.queue_submit2(queue, &[], vk::Fence::null()).expect("submitted");
        device.queue_wait_idle(queue).expect("idle");
        device.device_wait_idle().expect("idle");
        let info = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
        let fence = device.create_fence(&info, None).expect("a fence");
        device.wait_for_fences(&[fence], true, 0).expect("signalled");
        assert!(device.get_fence_status(fence).expect("signalled"));
        device.destroy_fence(fence, None);
    }
    let expected = [
        ("vkQueueSubmit", 1),
        ("vkQueueSubmit2", 2),
        ("vkQueueWaitIdle", 1),
        ("vkDeviceWaitIdle", 1),
        ("vkWaitForFences", 1),
    ];
    assert_eq!(counts.calls(), expected);
    let said = engine.said.clone();
    drop(engine);
    assert_eq!(said.all(), [""; 0]);
}

/// A path that needs a feature that is not enabled must be refused, and the feature named.
#[test]
fn what_is_not_switched_on_is_refused_by_name() {
    let refused = |text, optional| {
        let error = Engine::open(&setup(text, optional, true)).err();
        error.expect("refused").to_string()
    };
    // Features that the device itself lacks are named first.
    let stores = gobo::gpu::devices().expect("devices").iter().all(|device| device.fragment_stores_and_atomics);
    let said = refused("avsm:path=interlock,size=64", Optional::NoInterlock);
    let named = if stores { "fragmentShaderPixelInterlock" } else { "fragmentStoresAndAtomics" };
    assert!(said.contains(named), "{said}");
    let said = refused("avsm:path=raster-order,size=64", Optional::Nothing);
    assert!(said.contains("rasterizationOrderColorAttachmentAccess"), "{said}");
}

/// On a device with interlock, the path that needs it must run in an engine too.
#[test]
fn interlock_where_the_device_has_it() {
    const TEST: &str = "interlock_where_the_device_has_it";
    let devices: Vec<Features> = gobo::gpu::devices().expect("devices");
    if !devices.iter().all(|device| device.fragment_shader_pixel_interlock) {
        return skipped(TEST, "needs fragmentShaderPixelInterlock");
    }
    let (answers, _) = answers(TEST, &setup("avsm:path=interlock,size=64", Optional::All, true));
    assert!(answers.iter().any(|answer| *answer < 0.5));
}

/// Memory after 1,000 frames must equal memory after 100; in short runs, and for all but the first technique, 50 and 10 frames are
/// compared.
#[test]
fn a_thousand_frames_take_no_more_memory() {
    if crate::support::is_costly("a_thousand_frames_take_no_more_memory") {
        return;
    }
    for (i, name) in some(TECHNIQUES, 1).into_iter().enumerate() {
        let [before, after] = if all() && i == 0 { [100, 900] } else { [10, 40] };
        // For the first technique, Gobo also paints the picture.
        let mut painted = setup(name, Optional::All, true);
        painted.options.painted = i == 0;
        engine_test(name, &painted, |engine| {
            let bytes = |engine: &Engine| (engine.allocated_bytes(), engine.renderer.shadows.context.allocated_bytes());
            frames(engine, before);
            let held = bytes(engine);
            frames(engine, after);
            assert_eq!(bytes(engine), held, "{name}");
        });
    }
}

/// Gobo's picture in the renderer's frame must show smoke before the sky where the renderer's own does.
#[test]
fn smoke_is_where_the_renderer_draws_it() {
    let picture = |painted| {
        let mut pixels = Vec::new();
        let mut setup = setup(TECHNIQUES[0], Optional::All, true);
        setup.options.painted = painted;
        engine_test("smoke_is_where_the_renderer_draws_it", &setup, |engine| {
            frames(engine, 5);
            pixels = engine.renderer.picture().expect("read");
        });
        pixels
    };
    let [drawn, painted] = [false, true].map(picture);
    // Whether a pixel differs from the sky, which is uniform along a row of the upper third.
    let smoky = |pixels: &[u8], i: usize| {
        let pixel = |i: usize| &pixels[4 * i..4 * i + 3];
        pixel(i).iter().zip(pixel(i / 48 * 48)).any(|(a, b)| a.abs_diff(*b) > 6)
    };
    let upper = || (0..48 * 12).filter(|i| i % 48 != 0);
    let both = upper().filter(|&i| smoky(&drawn, i) && smoky(&painted, i)).count();
    let one = upper().filter(|&i| smoky(&drawn, i) != smoky(&painted, i)).count();
    println!("{both} pixels have smoke in both, {one} in one");
    assert!(both > 30 && one * 5 < both, "{both} pixels have smoke in both, {one} in one");
}
