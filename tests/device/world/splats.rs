//! Splats from the caller's buffers are packed as a scene's splats are, and give the same look-ups.

use super::buffers::{NAN, buffer, count, fill, points, record, refused_in};
use super::{answers, build, opened};
use crate::support::scenes::{self, Random};
use crate::support::{gpu_test, runs, spec};
use glam::Vec3;
use gobo::gpu::Context;
use gobo::reference::twin::gather::{SplatWords, splats};
use gobo::reference::twin::splat::shape;
use gobo::scene::{Caster, Scene, Splat};
use gobo::world::{Capacity, Number, Source, SplatAt, World};

/// Words from one of the caller's splats to the next, and words before the first.
const STRIDE: usize = 13;
const FIRST: usize = 2;

const AT: SplatAt = SplatAt { position: 4, deviations: 32, rotation: 16, opacity: Number::At(48) };
const WORDS: SplatWords =
    SplatWords { start: FIRST, stride: STRIDE, position: 1, deviations: 8, rotation: 4, opacity: Ok(12) };

/// Returns splats in the caller's layout, with NaN between their numbers.
fn laid_out(splats: &[Splat]) -> Vec<u32> {
    let mut words = vec![NAN; FIRST + STRIDE * splats.len()];
    for (i, g) in splats.iter().enumerate() {
        let at = &mut words[FIRST + STRIDE * i..][..STRIDE];
        at[1..4].copy_from_slice(&g.position.map(f32::to_bits));
        at[4..8].copy_from_slice(&g.rotation.map(f32::to_bits));
        at[8..11].copy_from_slice(&g.deviations.map(f32::to_bits));
        at[12] = g.opacity.to_bits();
    }
    words
}

fn source(context: &Context, splats: &[Splat], on_device: bool) -> Source {
    Source {
        buffer: buffer(context, &laid_out(splats)),
        offset: 4 * FIRST as u64,
        stride: 4 * STRIDE as u32,
        count: count(context, splats.len(), on_device),
    }
}

/// Draws splats of all shapes: needles, discs and balls, axis-aligned or rotated by quaternions of any length, translucent and opaque.
fn any(random: &mut Random, count: usize) -> Vec<Splat> {
    let one = |i: usize| {
        let long = 10f32.powf(random.between(-2.0, 1.0));
        let mut deviations =
            [0; 3].map(|_| long * 2f32.powf(-random.between(0.0, if i.is_multiple_of(3) { 14.0 } else { 4.0 })));
        if i.is_multiple_of(5) {
            deviations[i % 3] = deviations[(i + 1) % 3];
        }
        let scale = if i.is_multiple_of(4) { 1.0 } else { 10f32.powf(random.between(-3.0, 3.0)) };
        let rotation = match i % 7 {
            0 => [0.0, 0.0, 0.0, scale],
            1 => [scale, 0.0, 0.0, scale],
            _ => [0; 4].map(|_| scale * random.between(-1.0, 1.0)),
        };
        let opacity = match i % 9 {
            0 => 1.0,
            1 => 0.0,
            2 => 10f32.powf(random.between(-7.0, -1.0)),
            _ => random.between(0.0, 1.0),
        };
        Splat { position: random.point(-2.0, 2.0), deviations, rotation, opacity, color: [0.5; 3] }
    };
    (0..count).map(one).collect()
}

/// Returns splats each of which is invalid because of one number.
fn none() -> Vec<Splat> {
    let good = Splat {
        position: [0.0; 3],
        deviations: [0.3, 0.2, 0.1],
        rotation: [0.0, 0.0, 0.0, 1.0],
        opacity: 0.5,
        color: [0.5; 3],
    };
    let mut all = Vec::new();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        all.push(Splat { position: [0.0, bad, 0.0], ..good });
        all.push(Splat { deviations: [0.3, 0.2, bad], ..good });
        all.push(Splat { rotation: [0.0, 0.0, bad, 1.0], ..good });
        all.push(Splat { opacity: bad, ..good });
    }
    all.extend([0.0, -0.1].map(|bad| Splat { deviations: [bad, 0.2, 0.1], ..good }));
    all.extend([-0.1, 1.5].map(|opacity| Splat { opacity, ..good }));
    all.push(Splat { rotation: [0.0; 4], ..good });
    all
}

/// Returns the sine of the angle between two axes, whose sign does not matter.
fn apart(a: Vec3, b: Vec3) -> f32 {
    a.as_dvec3().cross(b.as_dvec3()).length() as f32
}

/// Asserts that two splats are equal up to quantization: each packed code may differ by 1. One code is 3.05e-5 on the octahedron, whose
/// points are at least 1/√3 from the origin and seen obliquely: an error bound of 7.5e-5 for the shortest axis, and 6.1e-5 more for the
/// longest axis, which is perpendicular to it. One code of a deviation is 1/4095 of 12 octaves. The error bound of the optical depth
/// through the centre along the shortest axis is the precision that Vulkan requires: 2⁻²¹ for a logarithm of at least 0.03, and 27 units
/// for 2⁻¹².
#[track_caller]
fn assert_alike(is: &Caster, expected: &Caster, what: &str) {
    assert_eq!(is.position.map(f32::to_bits), expected.position.map(f32::to_bits), "{what}");
    assert!((is.radius / expected.radius - 1.0).abs() < 2e-7, "{what}: {} {}", is.radius, expected.radius);
    assert!(is.is_splat() && expected.is_splat(), "{what}");
    let ((axes, long), (expected_axes, expected_long)) = (shape(is), shape(expected));
    for share in [0, 1, 2].map(|i| long[i] / expected_long[i]) {
        assert!((share.log2() * 4095.0 / 12.0).abs() < 1.01, "{what}: deviations {long} and {expected_long}");
    }
    for (axis, other) in axes.into_iter().zip(expected_axes) {
        assert!(apart(axis, other) < 1.4e-4, "{what}: axes {axes:?} and {expected_axes:?}");
    }
    let taken = (is.density * long.z) / (expected.density * expected_long.z);
    let nothing = is.density == 0.0 && expected.density == 0.0;
    assert!(nothing || (taken - 1.0).abs() < 2.5e-5, "{what}: {taken} times as much");
}

/// Splats are packed as by their twin in f32, and as a scene packs them in f64; invalid ones are counted and cast nothing.
#[test]
fn splats_of_a_buffer_are_packed() {
    gpu_test("splats_of_a_buffer_are_packed", |context| {
        let mut random = Random::new(12);
        let mut theirs = any(&mut random, 900);
        let none = none();
        for (i, bad) in none.iter().enumerate() {
            theirs.insert(37 * i, *bad);
        }
        let (live, slots) = (theirs.len(), theirs.len() + 70);
        let capacity = Capacity { particles: 5, strands: 3, splats: slots as u32, ..Capacity::default() };
        for on_device in [false, true] {
            let mut world = World::of(context, capacity).expect("room");
            let source = source(context, &theirs, on_device);
            let frame = record(context, |commands| world.update_splats(commands, &source, AT));
            let gathered = world.gathered(frame).expect("read").expect("the last that gathered");
            assert_eq!((gathered.asked[3], refused_in(&world, frame)[3]), (live as u32, none.len() as u32));
            let (expected, refused) = splats(&laid_out(&theirs), &WORDS, slots, live);
            assert_eq!(refused, none.len() as u32);
            let all: Vec<Caster> = world.buffers().casters.read(8 + slots).expect("read");
            let nothing = Caster { position: [0.0; 3], radius: 0.0, axis: [0.0; 3], density: 0.0 };
            assert!(all[..8].iter().all(|caster| *caster == nothing), "smoke and hair that nobody has written");
            let mut same = 0;
            for (i, (is, expected)) in all[8..].iter().zip(&expected).enumerate() {
                let what = format!("splat {i}, {:?}, count on the device: {on_device}", theirs.get(i));
                if expected.radius == 0.0 {
                    assert!(*is == nothing, "{what}: {is:?}");
                    continue;
                }
                same += usize::from(is.axis.map(f32::to_bits) == expected.axis.map(f32::to_bits));
                assert_alike(is, expected, &what);
                assert_alike(is, &Caster::from(&theirs[i]), &what);
            }
            assert!(10 * same > 9 * (live - none.len()), "only {same} have the twin's bits");
        }
    });
}

/// Shadows of the splats, and of smoke and hair beside them, equal those in a scene of the same casters, up to the rounding of extinctions.
#[test]
fn splats_answer_as_a_scene_does() {
    if crate::support::is_costly("splats_answer_as_a_scene_does") {
        return;
    }
    gpu_test("splats_answer_as_a_scene_does", |context| {
        let mut scene = Scene { splats: scenes::splats().splats, ..scenes::locks() };
        // Views of a light with a position are measured from it, in both worlds.
        scene.lights = scenes::spot([0.4, 2.0, 3.0], 70.0, scene.clone()).lights;
        let at = scene.particles.len();
        // Keeps only the splats that host and device pack identically: if the last bit of a direction differs, the splat has another shape.
        let packed = |scene: &Scene, on_device| {
            let capacity = Capacity { particles: 70, splats: 80, lights: 1, ..Capacity::default() };
            let mut world = World::of(context, capacity).expect("room");
            fill(context, &mut world, &Scene { strands: Vec::new(), ..scene.clone() }, on_device);
            let splats = source(context, &scene.splats, on_device);
            record(context, |commands| world.update_splats(commands, &splats, AT));
            world
        };
        let first: Vec<Caster> = packed(&scene, true).buffers().casters.read(150).expect("read");
        let all = scene.splats.len();
        let is_alike =
            |(i, g): (usize, &Splat)| first[70 + i].axis.map(f32::to_bits) == Caster::from(g).axis.map(f32::to_bits);
        scene.splats = scene.splats.iter().enumerate().filter(|one| is_alike(*one)).map(|(_, g)| *g).collect();
        scene.strands.clear();
        assert!(10 * scene.splats.len() > 8 * all && at < 70, "{} of {all}", scene.splats.len());
        let points = points();
        for text in ["layers:size=28,path=binned", "grid-query", "uncompressed:size=28"] {
            if !runs("splats_answer_as_a_scene_does", context, text) {
                continue;
            }
            let ours = super::world(context, &scene);
            for on_device in [false, true] {
                let theirs = packed(&scene, on_device);
                let [expected, is] = [&ours, &theirs].map(|world| {
                    let mut opened = opened(context, world, &spec(text));
                    build(&mut opened, world, text);
                    answers(context, opened.technique.as_ref(), 1, &points).concat()
                });
                assert!(expected.iter().filter(|answer| **answer < 0.5).count() > 20, "{text}: too little shadow");
                for (is, expected) in is.iter().zip(&expected) {
                    assert!((is - expected).abs() < 2e-5, "{text}: {is}, not {expected}, on the device: {on_device}");
                }
            }
        }
    });
}
