//! Per-cell sums (resolve=cells) by threads that test a batch of casters ahead of adding them, as on GPUs with many casters.

use crate::support::{gpu_test, ran, runs, scenes};
use gobo::gpu::{Buffer, Constants, Kernel};
use gobo::maps::{Bins, Entries, Maps, OpaqueMaps, Use};
use gobo::shaders::{avsm, constant, set};
use gobo::world::World;

/// Number of nodes per curve.
const NODES: u32 = 8;

/// Texels per side; not a multiple of the tile, so that some tiles are cut off.
const SIZE: u32 = 44;

/// Threads that test 32 casters before adding those that they may hit build the same curves as threads that test one at a time, and so do
/// more threads per texel: under a directional light and in perspective, with opaque casters, and with more casters than a batch.
#[test]
fn looking_ahead_changes_nothing() {
    if crate::support::is_costly("looking_ahead_changes_nothing") {
        return;
    }
    gpu_test("looking_ahead_changes_nothing", |context| {
        // Kernels that look ahead need no device feature beyond those of `batch=shared`.
        if !runs("looking_ahead_changes_nothing", context, "avsm:path=binned,resolve=cells,batch=shared") {
            return;
        }
        let spot = scenes::spot([0.3, 0.2, 0.9], 80.0, scenes::random());
        // 16 threads for each texel of half a tile.
        let threads = context.features().max_compute_workgroup_threads;
        let most = if threads < 512 { 4u32 } else { 16 };
        for scene in [scenes::random(), scenes::crowd(), scenes::opaque(), scenes::strands(), spot] {
            let world = World::new(context, &scene).expect("room for the scene");
            let mut maps = Maps::new(context, &world, SIZE, OpaqueMaps::SHARED).expect("room for the maps");
            let what =
                Use { entries: Entries::Summed, skip: false, reach: 1, parts: [2, 2], area: false, blocks: None };
            let mut bins = Bins::new(context, &world, &maps, what).expect("room for the bins");
            let record = |bins: &mut Bins, maps: &mut Maps| {
                ran(context, |commands| {
                    maps.record(commands, &world).expect("its lights");
                    bins.record(commands, &world);
                })
            };
            let mut frame = record(&mut bins, &mut maps);
            while bins.settle(frame).expect("room for the entries") {
                frame = record(&mut bins, &mut maps);
            }
            let words = 2 * (SIZE * SIZE * NODES * maps.count()) as usize;
            let [one, many, more] = [(1u32, 4u32), (32, 4), (32, most)].map(|(ahead, groups)| {
                let nodes = Buffer::with_data(context, "nodes", &vec![0u32; words]).expect("room");
                let set = set::Curves { nodes: &nodes, counts: &nodes, full_nodes: &nodes };
                let set = set.bind(context, "curves").expect("a set");
                let constants = Constants::new()
                    .set(constant::NODES, NODES)
                    .set(constant::WORK, NODES + 2)
                    .set(constant::GROUPS, groups)
                    .set(constant::BATCH, 32 * groups)
                    .set(constant::WORKGROUP, groups)
                    .set(constant::AHEAD, ahead);
                let sets = [maps.scene(), bins.set(), &set];
                let kernel = Kernel::compute(context, &avsm::CELLS_LANES_2, &sets, &constants).expect("made");
                context.submit(|c| c.pass("cells", |pass| bins.per_part(pass, &kernel, &()))).expect("done");
                nodes.read::<u32>(words).expect("read")
            });
            assert!(one.iter().filter(|word| **word != 0).count() > words / 8, "{}: curves", scene.name);
            assert!(one == many && one == more, "{}: other curves", scene.name);
        }
    });
}
