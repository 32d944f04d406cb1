//! Launch parameters of the binning passes: threads per workgroup, casters per thread, and shader variants.

use crate::gpu::{Constants, Context, groups};
use crate::maps::detail::SLOTS;
use crate::maps::{Entries, Use};
use crate::shaders::constant::{TALLY_THREADS, TALLY_TURNS, THREADS, TILE_LANES, WORKGROUP};
use crate::world::World;

/// Minimum number of casters for workgroups to count in shared memory first. With that many, casters are small compared to a tile, and
/// threads would contend for the tiles' counts.
pub const MANY_CASTERS: u32 = 1 << 18;

/// For workgroups that first count in shared memory: `TALLY_CASTERS` is the number of casters per workgroup;
/// `TALLY_MOST_THREADS` is the number of threads, or fewer if the device allows fewer.
const TALLY_CASTERS: u32 = 1024;
const TALLY_MOST_THREADS: u32 = 512;

/// Maximum number of tiles per map that a workgroup can count in shared memory. Twin: the size of `tally` in glsl/maps/bins/tally.glsl.
const MOST_TALLIED: u32 = 4096;

/// Threads of a pass that runs as a single workgroup, if the device allows that many. Such a pass lists the tiles with the most casters
/// first, or chooses how fine tiles are.
const LONE_THREADS: u32 = 1024;

/// Bytes of shared memory that a workgroup of [`LONE_THREADS`] threads needs to choose how fine tiles are: 16 bytes per thread, plus
/// tables. With half as many threads, every device has enough.
const LONE_BYTES: u32 = LONE_THREADS * 16 + 5120;

/// Maximum number of workgroups in the pass that surveys casters, where each workgroup first accumulates sums in shared memory. Fewer
/// workgroups contend less when they add their sums to the tiles.
const MOST_SURVEYING: u64 = 256;

/// Maximum number of threads in a surveying workgroup, if the device allows that many, and of threads that share a caster in it.
const SURVEYING_THREADS: u32 = 256;
const SURVEYING_LANES: u32 = 4;

/// Maximum number of tiles per map that a surveying workgroup can hold in shared memory. Twin: MOST_TILES in glsl/maps/detail/survey.comp.
const MOST_SURVEYED: u32 = 1024;

/// Maximum number of tiles per thread when one workgroup lists the fullest tiles first. With more tiles, the order gains less and one
/// workgroup would take too long.
const MOST_TURNS: u64 = 16;

/// How casters are surveyed.
#[derive(Clone, Copy)]
pub(in crate::maps) struct Surveying {
    /// Whether a workgroup first accumulates sums in shared memory, and then adds them to the tiles.
    pub tallies: bool,
    /// Number of threads per workgroup.
    pub threads: u32,
    /// Maximum number of workgroups.
    most_groups: u64,
    /// Number of threads that share a caster.
    pub sharing: u32,
}

impl Surveying {
    /// Returns the workgroups for `casters` casters.
    pub fn groups(self, casters: u32) -> [u32; 2] {
        let all = (u64::from(casters) * u64::from(self.sharing)).div_ceil(self.threads.into());
        groups(all.min(self.most_groups))
    }
}

/// Decisions made before the passes are created.
pub(in crate::maps) struct Threads {
    /// Whether a workgroup first counts its casters' tiles in shared memory, and then adds its counts to the tiles' counts.
    pub tallies: bool,
    /// Whether tiles with the most casters are listed first.
    pub fullest_first: bool,
    /// Number of casters per workgroup in the passes over casters.
    pub casters_a_group: u32,
    pub surveying: Surveying,
    /// Number of threads that share a caster.
    lanes: u32,
    tally: u32,
    /// Number of threads in a pass that runs as a single workgroup.
    lone: u32,
}

impl Threads {
    /// Chooses threads for maps of `bins_per_map` bins each: tiles, or blocks of detail.
    pub fn new(context: &Context, world: &World, what: Use, bins_per_map: u32, map_count: u32) -> Self {
        let (software, most) = (context.features().is_software(), context.features().max_compute_workgroup_threads);
        let tallies = !software
            && what.blocks.is_none()
            && world.caster_capacity() >= MANY_CASTERS
            && bins_per_map <= MOST_TALLIED;
        let [lanes, casters_a_group] = match (software, tallies) {
            (true, _) => [1, 64],
            (_, true) => [1, TALLY_CASTERS],
            _ => [16, 64 / 16],
        };
        // A power of two, and thus a multiple of the number of slots per tile.
        let has_room = context.features().max_compute_shared_memory_bytes >= LONE_BYTES;
        let lone = 1 << most.min(if has_room { LONE_THREADS } else { LONE_THREADS / 2 }).ilog2();
        let bins = u64::from(bins_per_map) * u64::from(map_count);
        let listed = what.blocks.map_or(bins, u64::from);
        let fullest_first = !software && what.entries != Entries::None && listed <= MOST_TURNS * u64::from(lone);
        // A power of two, so that it divides the casters of a workgroup.
        let tally = 1 << most.min(TALLY_MOST_THREADS).ilog2();
        let alone = bins_per_map <= MOST_SURVEYED * SLOTS;
        let threads = if alone { most.min(SURVEYING_THREADS) } else { 64 };
        // A software driver may end long loops early, so on software devices the number of workgroups is unlimited, and
        // a thread loops no longer than in the other passes.
        let most_groups = if alone && !software { MOST_SURVEYING } else { u64::MAX };
        let surveying = Surveying { tallies: alone, threads, most_groups, sharing: lanes.min(SURVEYING_LANES) };
        Self { tallies, fullest_first, casters_a_group, surveying, lanes, tally, lone }
    }

    /// Returns the constants of the shaders that count, place and scatter, and of the shaders in glsl/maps/detail.
    pub fn constants(&self) -> Constants {
        Constants::new()
            .set(TILE_LANES, self.lanes)
            .set(TALLY_THREADS, self.tally)
            .set(TALLY_TURNS, TALLY_CASTERS / self.tally)
            .set(THREADS, self.lone)
            .set(WORKGROUP, self.lone)
    }
}
