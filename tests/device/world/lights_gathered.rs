//! Lights gathered from the caller's buffers equal their twin, and views are aimed as the host aims them.

use super::buffers::{buffer, count, record, scene};
use super::gathered::word;
use super::lights_of_buffers::{AT, FIRST, From, STRIDE, aiming, filled, laid_out, light_of, source, types};
use super::{build, opened};
use crate::support::scenes::Random;
use crate::support::{gpu_test, some, spec};
use glam::DVec3;
use gobo::reference::twin::fit::aim;
use gobo::reference::twin::gather::{GatheredLight, LightWords, light};
use gobo::scene::{Light, LightKind, Scene};
use gobo::world::{Capacity, LightData, Source, World};

const WORDS: LightWords = LightWords { position: 3, direction: 8, radiance: 0, radius: Ok(12), cos_cone: Ok(14) };

/// Unit roundoff.
const U: f64 = 1.0 / (1 << 24) as f64;

/// For random lights, the device's views equal their twin's, and the host's in double precision up to single-precision rounding.
///
/// Error bounds, in units of the unit roundoff u: the direction is identical in both. `right`, perpendicular to it, is a / |a| with |a| ≥
/// 0.14. |a|² has an error of 2 u; its root halves that and adds, together with the quotient, the error that Vulkan allows, 7 units of 2 u.
/// So the error of `right` is at most 16 u on the device, and u on the host. `up` sums two products with `right`, each rounded by another
/// u: 36 u. A cone's width is c / √(1 − c²): rounding c changes it by a relative u / (c (1 − c²)), and the roots and quotients change it by
/// 20 u.
#[test]
fn views_are_aimed_as_the_host_aims() {
    if crate::support::is_costly("views_are_aimed_as_the_host_aims") {
        return;
    }
    gpu_test("views_are_aimed_as_the_host_aims", |context| {
        let mut random = Random::new(31);
        let mut any = |i: u32| {
            let unit = loop {
                let v = DVec3::from(random.point(-1.0, 1.0).map(f64::from));
                // One in three points roughly along z, where the other axis is chosen.
                let v = if i.is_multiple_of(3) { DVec3::new(0.1 * v.x, 0.1 * v.y, v.z) } else { v };
                let unit = v.normalize_or_zero().as_vec3().as_dvec3();
                if v.length() > 0.2 && (unit.z.abs() - 0.99).abs() > 1e-6 {
                    break unit;
                }
            };
            let position = DVec3::from(random.point(-9.0, 9.0).map(f64::from));
            light_of(match i % 5 {
                0 | 1 => LightKind::Directional { direction: unit },
                2 => LightKind::Point { position },
                _ => {
                    LightKind::Spot { position, direction: unit, cone_degrees: f64::from(random.between(20.0, 160.0)) }
                }
            })
        };
        let lights: Vec<_> = (0..25).map(&mut any).collect();
        let scene = Scene { lights, ..scene(6, 30) };
        let spec = spec("beer-shadow-map:size=8");
        let [host, device] = [From::Host, From::Buffer { counts_itself: false }].map(|from| {
            let world = filled(context, &scene, from);
            let mut opened = opened(context, &world, &spec);
            build(&mut opened, &world, "aimed");
            opened.technique.inspect().maps().to_vec()
        });
        assert_eq!(host.len(), device.len());
        let data = LightData::of(&scene.lights, true);
        let most =
            |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
        for (i, light) in data.iter().enumerate() {
            for map in light.first_map..light.first_map + light.map_count {
                let (host, device) = (&host[map as usize], &device[map as usize]);
                for (host, is) in [(host.caster_view, device.caster_view), (host.opaque, device.opaque)] {
                    let what = format!("{:?}: {is:?}, not {host:?}", scene.lights[i]);
                    let twin = aim(is, &aiming(light));
                    for (view, which) in [(host, "host"), (twin, "twin")] {
                        assert_eq!(is.forward, view.forward, "{what}, {which}");
                        assert!(most(is.right, view.right) <= 17.0 * U, "{what}, {which}");
                        assert!(most(is.up, view.up) <= 36.0 * U, "{what}, {which}");
                        if light.kind != 0 {
                            assert_eq!(is.origin, view.origin, "{what}, {which}");
                            let c = f64::from(light.cos_cone);
                            let off = if light.kind == 1 { 1.0 / (c * (1.0 - c * c)) + 20.0 } else { 0.0 };
                            let scale = f64::from(is.scale_x / view.scale_x);
                            assert!((scale - 1.0).abs() <= off * U && is.scale_x == is.scale_y, "{what}, {which}");
                        }
                    }
                }
            }
        }
    });
}

/// Returns one of the host's lights with random numbers.
fn random_light(random: &mut Random, i: u32) -> Light {
    let position = DVec3::from(random.point(-3.0, 3.0).map(f64::from));
    let unit = DVec3::from(random.point(-1.0, 1.0).map(f64::from)).normalize_or(DVec3::X);
    let radius = if i.is_multiple_of(4) { f64::INFINITY } else { f64::from(random.between(0.1, 9.0)) };
    let kind = match i % 7 {
        0 | 1 => LightKind::Directional { direction: unit },
        2 | 3 => LightKind::Spot { position, direction: unit, cone_degrees: f64::from(random.between(1.0, 170.0)) },
        4 | 5 => LightKind::Point { position },
        _ => LightKind::Virtual { position, normal: unit, nearest: f64::from(random.between(0.01, 1.0)) },
    };
    Light { kind, radiance: random.point(0.0, 3.0), radius }
}

/// Returns the placeholder of a light that was not gathered.
fn nothing(kind: u32) -> GatheredLight {
    let stands = |is: bool, of: [f32; 3]| if is { of } else { [0.0; 3] };
    GatheredLight {
        position: [0.0; 3],
        direction: stands(kind != 2, [0.0, 0.0, -1.0]),
        cos_cone: [-2.0, std::f32::consts::FRAC_1_SQRT_2, -2.0, 0.0][kind as usize],
        radiance: [0.0; 3],
        falloff: if kind == 3 { 1.0 } else { 0.0 },
    }
}

/// Lights gathered from arbitrary bits equal their twin, up to the rounding of a quotient. Invalid ones, and those past the count, are
/// dark, and counted.
#[test]
fn lights_of_a_buffer_equal_their_twin() {
    gpu_test("lights_of_a_buffer_equal_their_twin", |context| {
        let mut random = Random::new(17);
        for (slots, live) in some([(300, 260), (64, 64), (1, 0), (65, 70)], 3) {
            let lights: Vec<_> = (0..slots as u32).map(|i| random_light(&mut random, i)).collect();
            let mut words = laid_out(&lights);
            let odd = words.len() / 12;
            for _ in 0..odd {
                let at = FIRST + random.bits() as usize % (words.len() - FIRST);
                words[at] = word(&mut random, false);
            }
            let capacity = Capacity { lights: slots as u32, ..Capacity::default() };
            let mut world = World::of(context, capacity).expect("room");
            let source = Source { buffer: buffer(context, &words), ..source(context, &lights, true) };
            let source = Source { count: count(context, live, true), ..source };
            let frame =
                record(context, |commands| world.update_lights_from_buffer(commands, &source, AT, &types(&lights)));
            let all: Vec<LightData> = world.buffers().lights.read(slots).expect("read");
            let mut refused = 0;
            for (i, (is, told)) in all.iter().zip(LightData::of(&lights, false)).enumerate() {
                let theirs = light(&words, FIRST + STRIDE * i, &WORDS, told.kind).filter(|_| i < live);
                refused += u32::from(i < live && theirs.is_none());
                let expected = theirs.unwrap_or(nothing(told.kind));
                let LightData { position, direction, cos_cone, radiance, falloff, .. } = *is;
                let is_rest = GatheredLight { position, direction, cos_cone, radiance, falloff: expected.falloff };
                assert_eq!(is_rest, expected, "light {i}");
                // Error bound: a rounded product, a quotient with an error of at most 2.5 ulp, and the host's own rounding.
                let off = (f64::from(falloff) - f64::from(expected.falloff)).abs();
                assert!(off <= 8.0 * U * f64::from(expected.falloff), "light {i}: {falloff}, {expected:?}");
                let rest = |data: &LightData| (data.kind, data.first_map, data.map_count, data.has_opaque);
                assert_eq!(rest(is), rest(&told), "light {i}");
            }
            let gathered = world.gathered(frame).expect("read").expect("gathered");
            assert_eq!((gathered.asked[4], gathered.refused[4]), (live as u32, refused), "{slots}");
            assert!(slots < 300 || (20..200).contains(&refused), "{refused} of {live} are none");
        }
    });
}

/// One number out of range makes a light invalid; a number at the limit, or one that its kind does not use, does not.
#[test]
fn ranges_of_lights_end_where_they_say() {
    let good = random_light(&mut Random::new(3), 2);
    let words = laid_out(&[good]);
    let is = |word: usize, value: f32, kind: u32| {
        let mut words = words.clone();
        words[FIRST + word] = value.to_bits();
        light(&words, FIRST, &WORDS, kind).is_some()
    };
    assert!(light(&words, FIRST, &WORDS, 1).is_some());
    for (word, value, kind) in [
        (3, f32::NAN, 1),
        (4, f32::INFINITY, 2),
        (0, -0.1, 0),
        (1, f32::INFINITY, 0),
        (12, 0.0, 2),
        (12, -1.0, 1),
        (12, 1e-19, 2),
        (12, f32::NAN, 1),
        (12, f32::INFINITY, 3),
        (14, 1.0, 1),
        (14, 0.08, 1),
        (14, f32::NAN, 1),
        (8, 2.0, 0),
        (8, f32::NAN, 3),
    ] {
        assert!(!is(word, value, kind), "word {word} is {value}, kind {kind}");
    }
    for (word, value, kind) in [
        (3, f32::NAN, 0),
        (12, 0.0, 0),
        (12, f32::INFINITY, 1),
        (12, 3e38, 2),
        (14, 1.0, 2),
        (14, f32::NAN, 3),
        (8, f32::NAN, 2),
        (0, 0.0, 1),
    ] {
        assert!(is(word, value, kind), "word {word} is {value}, kind {kind}");
    }
}
