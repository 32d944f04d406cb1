//! Drawing lights by flux, against its twin, to the bit.

use super::{lit, made, plane};
use crate::support::{gpu_test, scenes::Random};
use glam::DVec3;
use gobo::reference::twin::indirect::{draw, place, scan, sums};
use gobo::scene::LightKind;

/// Fluxes: random ones, and hard cases: all zero, a single nonzero one, all equal, a wide range of magnitudes, and denormals.
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
                let twin = sums(&fluxes, seen.side_bits);
                assert_eq!(seen.sums, twin, "{name}");
                let starts: Vec<u64> =
                    seen.starts.iter().map(|[low, high]| u64::from(*high) << 32 | u64::from(*low)).collect();
                assert_eq!(starts, scan(&twin), "{name}");
                let picks: Vec<u32> =
                    draw(&fluxes, seen.side_bits, count).iter().map(|pick| pick.unwrap_or(u32::MAX)).collect();
                assert!(seen.picks == picks, "{name}, {count}");
                if name == "equal" {
                    assert!(starts[starts.len() - 1] > 1 << 38, "past 32 bits");
                }
            }
        }
    });
}

/// Under even light, and under light that is brighter on one half, each sixteenth of a map gets lights in proportion to its flux.
#[test]
fn lights_are_stratified() {
    gpu_test("lights_are_stratified", |context| {
        let down = LightKind::Directional { direction: DVec3::NEG_Z };
        let vpls = made(context, &lit("plane", vec![plane([0.8; 3])], &[down]), 1024);
        for (left, right) in [(1.0, 1.0), (3.0, 1.0)] {
            let fluxes: Vec<f32> = (0..1 << 16).map(|i| if i % 256 < 128 { left } else { right }).collect();
            vpls.draw_from(&fluxes).expect("drawn");
            let seen = vpls.seen().expect("read");
            let mut squares = [0u32; 16];
            for pick in &seen.picks {
                let (_, [x, y]) = place(*pick, seen.side_bits);
                squares[(y / 64 * 4 + x / 64) as usize] += 1;
            }
            for (i, lights) in squares.iter().enumerate() {
                let expected = 128.0 / (left + right) * if i % 4 < 2 { left } else { right };
                // Independent draws would be off by the square root of the count, 7 and more.
                assert!((*lights as f32 - expected).abs() <= 4.0, "{squares:?}");
            }
        }
    });
}
