//! Possible savings of one node table for many sun directions: nodes that the trees of several lights have in common.

use super::{Baked, PLAIN, Settings, as_baked, baked, shapes};
use crate::support::{gpu_test, some};
use glam::DVec3;
use gobo::gpu::Context;
use gobo::scene::{Light, LightKind, Scene};
use std::collections::HashMap;

/// Returns sixteen suns, the first at `first` degrees above the horizon, then one every `apart` degrees.
fn suns(first: f64, apart: f64) -> Vec<Light> {
    let sun = |i: u32| {
        let (sin, cos) = (first + apart * f64::from(i)).to_radians().sin_cos();
        let direction = DVec3::new(cos, 0.35, -sin).normalize();
        Light { kind: LightKind::Directional { direction }, radiance: [1.0; 3], radius: f64::INFINITY }
    };
    (0..16).map(sun).collect()
}

/// Returns `count` bits of words, starting at bit `from`.
fn bits(words: &[u32], from: u64, count: u32) -> u32 {
    (0..count).map(|b| (words[((from + u64::from(b)) / 32) as usize] >> ((from + u64::from(b)) % 32) & 1) << b).sum()
}

/// Distinct nodes, level by level: a leaf's bits, or a mask and the numbers of its children.
struct Table(Vec<HashMap<Vec<u32>, u32>>);

impl Table {
    /// Adds a graph's nodes, and counts them per level.
    fn add(&mut self, graph: &Baked, counts: &mut [usize]) {
        // Maps pointers to nodes of the level below to their numbers in this table.
        let mut below: HashMap<u32, u32> = HashMap::new();
        for (level, table) in self.0.iter_mut().enumerate() {
            let begin = 32 * u64::from(graph.at[level]);
            let end = 32 * u64::from(*graph.at.get(level + 1).unwrap_or(&graph.shortcuts));
            let (mut here, mut at) = (HashMap::new(), begin);
            // A mask is never 0, except as padding of a word.
            while at < end && (level == 0 || bits(&graph.words, at, 16) != 0) {
                let name = (at - begin) / if level == 0 { 64 } else { 16 };
                let node = if level == 0 {
                    vec![bits(&graph.words, at, 32), bits(&graph.words, at + 32, 32)]
                } else {
                    let (mask, pointer) = (bits(&graph.words, at, 16), graph.pointer_bits[level]);
                    let children = (mask & (mask >> 1) & 0x5555).count_ones();
                    let child = |c: u32| below[&bits(&graph.words, at + 16 + u64::from(c * pointer), pointer)];
                    std::iter::once(mask).chain((0..children).map(child)).collect()
                };
                let pointers = (node.len() as u64 - 1) * u64::from(graph.pointer_bits[level]);
                at += if level == 0 { 64 } else { (16 + pointers).next_multiple_of(16) };
                let next = table.len() as u32;
                here.insert(name as u32, *table.entry(node).or_insert(next));
                counts[level] += 1;
            }
            below = here;
        }
    }

    /// Returns the number of nodes per level.
    fn counts(&self) -> Vec<usize> {
        self.0.iter().map(HashMap::len).collect()
    }

    /// Returns the size if packed like a graph, with pointers as wide as the level below needs, in units of 16 bits.
    fn bytes(&self) -> u64 {
        let (mut bytes, mut units) = (8 * self.0[0].len() as u64, self.0[0].len() as u64);
        for level in &self.0[1..] {
            let pointer = u64::BITS - units.saturating_sub(1).max(1).leading_zeros();
            let of = |node: &Vec<u32>| (16 + u64::from(pointer) * (node.len() as u64 - 1)).div_ceil(16);
            units = level.keys().map(of).sum();
            bytes += 2 * units;
        }
        bytes
    }
}

/// Returns the bytes of all lights' trees; the numbers of nodes per level, separately and shared; and the bytes if shared.
fn shared(context: &Context, scene: &Scene, size: u32) -> (u64, [Vec<usize>; 2], u64) {
    let settings = Settings { size, keep_columns: false, ..PLAIN };
    let opened = baked(context, scene, settings);
    let graphs: Vec<_> = (0..scene.lights.len()).map(|light| as_baked(&opened.technique, light, settings)).collect();
    let mut table = Table(vec![HashMap::new(); graphs[0].at.len()]);
    let mut one_by_one = vec![0; table.0.len()];
    graphs.iter().for_each(|graph| table.add(graph, &mut one_by_one));
    let cells =
        4 * graphs.len() as u64 * (graphs[0].words.len() as u64 - u64::from(graphs[graphs.len() - 1].shortcuts));
    (4 * graphs[0].words.len() as u64, [one_by_one, table.counts()], table.bytes() + cells)
}

/// Trees of the same direction share all nodes, and take the bytes of one. Those of different directions share little more than some leaves
/// and bricks: for sixteen at 1024, a common table would save an eighth; at 256, wider pointers cost more than it saves. So each light has
/// its own table.
#[test]
fn directions_have_little_in_common() {
    if crate::support::is_costly("directions_have_little_in_common") {
        return;
    }
    gpu_test("directions_have_little_in_common", |context| {
        let mut scene = shapes::houses();
        scene.lights = vec![scene.lights[0]; 3];
        let (all, [one_by_one, once], together) = shared(context, &scene, 256);
        assert_eq!(one_by_one, once.iter().map(|nodes| 3 * nodes).collect::<Vec<_>>());
        // Each tree has its own cells, and a level may end in half a word.
        assert!(together < all / 3 + 2 * 4 * 4096 + 64 && together > all / 3, "{all} and {together} bytes");
        let houses = || Scene::load("houses", 0.0).expect("built in");
        for (size, first, apart) in some([(256, 15.0, 10.0), (1024, 15.0, 10.0)], 1) {
            let (all, [one_by_one, once], together) =
                shared(context, &Scene { lights: suns(first, apart), ..houses() }, size);
            let share = together as f64 / all as f64;
            println!("houses, 16 suns {apart} degrees apart, {size}: {all} bytes, nodes {one_by_one:?}");
            println!("  shared {once:?}, {together} bytes, {share:.3}");
            assert!(share > 0.75, "{size}: shared nodes take {share} of the bytes");
        }
    });
}
