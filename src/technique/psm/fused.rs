//! path=fused: one workgroup adds up half a tile's casters in shared memory and writes each voxel once. Source: ours.

use super::volume::Volume;
use crate::Result;
use crate::gpu::{Commands, Constants, Context, Image, Kernel, groups, push_struct};
use crate::maps::{Bins, Entries, Maps, Use};
use crate::shaders::constant::{BATCH, BATCH_AXES, ROWS, THREADS, WORKGROUP};
use crate::shaders::psm;
use crate::shaders::set;
use crate::world::World;

/// Workgroups per tile: two, of half a tile each, if the tile has casters; one if the tile has none and is only overwritten.
const PARTS: [u32; 2] = [2, 1];

/// `ROWS_AT_A_TIME`: number of rows of 8 texels that each workgroup builds at the same time, out of the four rows of half a tile.
/// `SLICE_BYTES`: bytes of shared memory per slice for these texels.
const ROWS_AT_A_TIME: u32 = 2;
pub const SLICE_BYTES: u32 = ROWS_AT_A_TIME * 8 * 4;

/// `BATCH_CASTERS`: number of casters held in shared memory at a time, if they fit; less than the number of threads. `CASTER_BYTES`: bytes
/// per caster. `AXIS_BYTES`: further bytes per caster if there are strands or splats. Without strands and splats, two workgroups fit into
/// some 48 KiB of shared memory.
const BATCH_CASTERS: u32 = 240;
const CASTER_BYTES: u32 = 24;
const AXIS_BYTES: u32 = 16;

/// Remaining bytes of shared memory: the caster counts of this batch and of the next; space for one caster, which is always reserved;
/// padding to a multiple of 16.
pub const OTHER_BYTES: u32 = 8 + CASTER_BYTES + AXIS_BYTES + 16;

/// Minimum and maximum number of threads per workgroup; the number is always a multiple of the minimum.
const LEAST_AND_MOST_THREADS: [u32; 2] = [ROWS_AT_A_TIME * 8, 256];

push_struct! {
    /// Twin: PartPush in glsl/technique/psm/fused.comp.
    struct PartPush {
        /// Capacity of each tile, in entries, if it is the same for all tiles, else 0.
        room: u32,
        /// Tiles per map.
        tile_count: u32,
    }
}

/// The build state of this path.
pub struct Fused {
    pub bins: Bins,
    map_count: u32,
    kernel: Kernel<PartPush>,
}

/// Returns the number of threads per workgroup that suits the device.
pub fn threads(context: &Context) -> u32 {
    let [least, most] = LEAST_AND_MOST_THREADS;
    // Threads of a software device do not run at the same time, and each has a cost.
    let room = if context.features().is_software() { least } else { context.features().max_compute_workgroup_threads };
    (room / least * least).clamp(least, most)
}

/// Returns how many casters shared memory holds besides the slices: `BATCH_CASTERS` or, if lower, the number of threads minus 2; half or a
/// quarter of that if shared memory is too small; or 0. With the minimum number of threads it is 0: software devices use that number, and
/// their threads, which take turns, gain nothing from shared memory.
fn batch(context: &Context, slices: u32, threads: u32, axes: bool) -> u32 {
    if threads == LEAST_AND_MOST_THREADS[0] {
        return 0;
    }
    let most = BATCH_CASTERS.min(threads - 2);
    let bytes = CASTER_BYTES + if axes { AXIS_BYTES } else { 0 };
    let has = context.features().max_compute_shared_memory_bytes;
    let fits = |casters: &u32| slices * SLICE_BYTES + casters * bytes + OTHER_BYTES <= has;
    [most, most / 2, most / 4].into_iter().find(fits).unwrap_or(0)
}

impl Fused {
    pub fn new(
        context: &Context,
        world: &World,
        maps: &Maps,
        (layout, skip): (&Volume, bool),
        volume: &Image,
        constants: &Constants,
        threads: u32,
    ) -> Result<Self> {
        let what = Use {
            entries: Entries::Summed,
            skip,
            reach: layout.filter.reach(),
            parts: PARTS,
            area: false,
            blocks: None,
        };
        let bins = Bins::new(context, world, maps, what)?.unlisted();
        let storage = set::PsmVolume { volume }.bind(context, "psm.volume")?;
        let shader = if layout.is_8_bit() { &psm::FUSED_BITS_8 } else { &psm::FUSED_BITS_16 };
        let axes = world.has_strands() || world.has_splats_or_cells() || world.has_sheets();
        let batch = batch(context, layout.slices, threads, axes);
        let constants = constants
            .clone()
            .set(ROWS, ROWS_AT_A_TIME)
            .set(THREADS, threads)
            .set(WORKGROUP, threads)
            .set(BATCH, batch)
            .set(BATCH_AXES, if axes { batch } else { 0 });
        let kernel = Kernel::compute(context, shader, &[maps.scene(), bins.set(), &storage], &constants)?;
        Ok(Self { bins, map_count: maps.count(), kernel })
    }

    pub fn record(&mut self, commands: &mut Commands, world: &World) {
        self.bins.record(commands, world);
        let (room, tile_count) = (self.bins.room(), self.bins.bins_per_map());
        let push = PartPush { room, tile_count };
        // Two workgroups per tile, or one per part if parts of tiles are listed.
        let [x, y] = groups(2 * u64::from(tile_count));
        commands.pass("psm.fused", |pass| match room {
            0 => self.bins.per_part(pass, &self.kernel, &push),
            _ => pass.dispatch(&self.kernel, &push, [x, y, self.map_count]),
        });
    }
}
