//! What is drawn by flux, against its twin, to the bit.

use super::{lit, made, plane, seen};
use crate::support::{gpu_test, scenes::Random};
use glam::DVec3;
use gobo::reference::twin::indirect::{draw, place, scan, sums};
use gobo::scene::LightKind;

/// Random fluxes, and such as are hard: none, one, all the same, past 32 bits in all and in steps of 2 to the 40, so small that a unit is
/// more than they are.
fn fluxes(texels: usize) -> Vec<(&'static str, Vec<f32>)> {
    let mut random = Random::new(11);
    let mut all = |of: &mut dyn FnMut(&mut Random, usize) -> f32| -> Vec<f32> {
        (0..texels).map(|i| of(&mut random, i)).collect()
    };
    vec![
        ("random", all(&mut |r, _| r.between(0.0, 3.0))),
        ("none", all(&mut |_, _| 0.0)),
        ("one", all(&mut |_, i| if i == 31_337 { 0.7 } else { 0.0 })),
        ("the last", all(&mut |_, i| if i + 1 == texels { 1e-9 } else { 0.0 })),
        ("the first", all(&mut |_, i| if i == 0 { 1e9 } else { 0.0 })),
        ("equal", all(&mut |_, _| 1.999_999_9)),
        ("steps", all(&mut |r, _| (2f32).powi(-(r.bits() as i32 & 31)) * 1e20)),
        ("tiny", all(&mut |r, _| r.between(0.0, 1e-35))),
        ("the least", all(&mut |r, i| if i % 3 == 0 { f32::from_bits(r.bits() & 7) } else { 0.0 })),
        ("sparse", all(&mut |r, _| if r.bits() % 977 == 0 { r.between(0.0, 1.0) } else { 0.0 })),
    ]
}

#[test]
fn drawing_equals_its_twin() {
    gpu_test("drawing_equals_its_twin", |context| {
        let down = LightKind::Directional { direction: DVec3::NEG_Z };
        for count in [64, 1000, 4096] {
            let vpls = made(context, &lit("plane", vec![plane([0.8; 3])], &[down]), count);
            let texels = vpls.seen().expect("read").fluxes.len();
            assert_eq!(texels, 1 << 16);
            for (name, fluxes) in fluxes(texels) {
                vpls.draw_from(&fluxes).expect("drawn");
                let seen = vpls.seen().expect("read");
                let twin = sums(&fluxes);
                assert_eq!(seen.sums, twin, "{name}");
                let starts: Vec<u64> =
                    seen.starts.iter().map(|[low, high]| u64::from(*high) << 32 | u64::from(*low)).collect();
                assert_eq!(starts, scan(&twin), "{name}");
                let picks: Vec<u32> = draw(&fluxes, count).iter().map(|pick| pick.unwrap_or(u32::MAX)).collect();
                assert!(seen.picks == picks, "{name}, {count}");
                if name == "equal" {
                    assert!(starts[starts.len() - 1] > 1 << 38, "past 32 bits");
                }
            }
        }
    });
}

/// In an even light the picture's parts have equally many lights: a sixteenth of them each sixteenth, which is a square.
#[test]
fn lights_are_stratified() {
    gpu_test("lights_are_stratified", |context| {
        let down = LightKind::Directional { direction: DVec3::NEG_Z };
        let scene = lit("plane", vec![plane([0.8; 3])], &[down]);
        for count in [64, 1000, 1024] {
            let seen = seen(context, &scene, count);
            let mut squares = [0u32; 16];
            for pick in &seen.picks {
                let (_, [x, y]) = place(*pick, seen.side_bits);
                squares[(y / 64 * 4 + x / 64) as usize] += 1;
            }
            // All texels are lit but those at the rim, if the fit leaves them out.
            let expected = f64::from(count) / 16.0;
            assert!(squares.iter().all(|n| (f64::from(*n) - expected).abs() <= 2.0), "{count}: {squares:?}");
        }
    });
}
