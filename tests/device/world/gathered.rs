//! Gathering from the caller's buffers, which may hold any bits, and refusing invalid casters.

use super::buffers::{NAN, buffer, count, record, refused_in};
use crate::support::scenes::Random;
use crate::support::{gpu_test, some};
use gobo::reference::twin::gather::{CasterAt, Vertices, casters};
use gobo::scene::Caster;
use gobo::world::{Capacity, Corners, Number, Source, SphereAt, StrandAt, World};

/// Draws a word that a buffer may hold.
pub fn word(random: &mut Random, all: bool) -> u32 {
    let odd = [NAN, 0xFFFF_FFFF, 0x7F80_0000, 0xFF80_0000, 0x7F7F_FFFF, 0xFF7F_FFFF, 0x8000_0000, 0];
    let small = [1, 0x8000_0001, 0x0080_0000];
    match random.bits() % 40 {
        i if i < 8 => odd[i as usize],
        i if all && i < 11 => small[i as usize - 8],
        12 => random.between(-1.0, 1.0).to_bits(),
        _ => random.between(0.01, 2.0).to_bits(),
    }
}

/// Casters and triangles gathered from arbitrary bits equal their twins, byte for byte.
#[test]
fn what_is_gathered_equals_its_twin() {
    gpu_test("what_is_gathered_equals_its_twin", |context| {
        let mut random = Random::new(7);
        for (slots, live, stride) in some([(500, 300, 9), (64, 64, 8), (65, 0, 11), (3000, 2999, 5), (1, 1, 9)], 3) {
            let start = 3;
            let mut words: Vec<u32> = (0..start + stride * slots).map(|_| word(&mut random, true)).collect();
            let spheres = CasterAt { start, stride, position: 0, end: None, radius: Ok(4), density: Err(0.5) };
            let (expected, refused) = casters(&words, &spheres, slots, live);
            let capacity = Capacity {
                particles: slots as u32,
                strands: slots as u32,
                triangles: slots as u32,
                ..Capacity::default()
            };
            let mut world = World::of(context, capacity).expect("room");
            let from = |words: &[u32]| Source {
                buffer: buffer(context, words),
                offset: 4 * start as u64,
                stride: 4 * stride as u32,
                count: count(context, live, true),
            };
            let at = SphereAt { position: 0, radius: Number::At(16), extinction: Number::Is(0.5) };
            let frame = record(context, |commands| world.update_particles(commands, &from(&words), at));
            let is: Vec<Caster> = world.buffers().casters.read(slots).expect("read");
            assert!(bytemuck::cast_slice::<_, u8>(&is) == bytemuck::cast_slice::<_, u8>(&expected), "{slots} spheres");
            assert_eq!(refused_in(&world, frame)[0], refused);
            if stride >= 8 {
                // Denormals, which a device may flush, are not part of the contract.
                words = (0..start + stride * slots).map(|_| word(&mut random, false)).collect();
                let strands = CasterAt { end: Some(4), radius: Ok(3), density: Ok(7), ..spheres };
                let (expected, refused) = casters(&words, &strands, slots, live);
                let at = StrandAt { start: 0, end: 16, radius: Number::At(12), depth: Number::At(28) };
                let frame = record(context, |commands| world.update_strands(commands, &from(&words), at));
                let is: Vec<Caster> = world.buffers().casters.read_from(slots, slots).expect("read");
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
                    alpha: None,
                };
                let frame = record(context, |commands| world.update_triangles(commands, &corners));
                let is: Vec<[[f32; 3]; 4]> = world.buffers().triangles.read(slots).expect("read");
                let same = bytemuck::cast_slice::<_, u8>(&is) == bytemuck::cast_slice::<_, u8>(&expected);
                assert!(same, "{slots} triangles, {live} of them theirs, indices: {}", indices.is_some());
                assert_eq!(refused_in(&world, frame)[2], refused);
            }
        }
    });
}
