//! Casters of a tile, sorted by key, and those with equal keys by their contents.

use crate::support::scenes::{self, Random};
use crate::support::{built_avsm, gpu_test};
use gobo::scene::{Particle, Scene};
use gobo::technique::Technique;
use rand::seq::SliceRandom;

/// Spheres around a few shared centres, `alike` per centre, with different extinctions: all spheres at a centre have the same key.
fn stacks(name: &str, alike: usize, centres: usize) -> Scene {
    let mut random = Random::new(61 + alike as u64);
    let mut particles = Vec::new();
    for _ in 0..centres {
        let first = Particle { position: random.point(-0.8, 0.8), radius: random.between(0.3, 0.9), extinction: 0.0 };
        particles.extend((0..alike).map(|_| Particle { extinction: random.between(0.001, 0.02), ..first }));
    }
    scenes::directional(name, [0.3, 0.2, -0.9], particles)
}

/// Curves have the same bytes whatever order the casters are listed in, whether one thread sorts them or all do, and whether in shared
/// memory or in the entries' buffer.
#[test]
fn casters_of_the_same_key_are_sorted_too() {
    gpu_test("casters_of_the_same_key_are_sorted_too", |context| {
        for (alike, centres) in [(2, 60), (16, 12), (17, 12), (200, 3), (8, 200), (600, 3)] {
            let mut scene = stacks("stacks", alike, centres);
            let mut random = Random::new(62);
            let mut all = [Vec::new(), Vec::new()];
            for order in 0..4 {
                match order {
                    0 => {}
                    1 => scene.particles.reverse(),
                    _ => scene.particles.shuffle(&mut random.generator()),
                }
                for (all, batch) in all.iter_mut().zip(["auto", "shared"]) {
                    let text = format!("avsm:path=binned,resolve=streaming,nodes=8,size=8,batch={batch}");
                    let avsm = built_avsm(context, &scene, &text);
                    let counters = avsm.inspect().facts().expect("counted").counters;
                    assert!(counters["bin_entries"] as usize > alike * centres / 2, "{counters:?}");
                    all.push(crate::avsm::nodes(&avsm, 64, 8));
                }
            }
            for all in all {
                assert!(all[0].iter().any(|node| node.value > 0.0), "{alike}: curves");
                assert!(
                    all.iter().all(|nodes| *nodes == all[0]),
                    "{alike} of the same key: another order, other curves"
                );
            }
        }
    });
}
