//! How the binning passes run: threads per workgroup, casters per thread, and the variants of the shaders.

use crate::gpu::{Constants, Context, groups};
use crate::maps::detail::SLOTS;
use crate::maps::{Entries, Use};
use crate::shaders::constant::{TALLY_THREADS, TALLY_TURNS, THREADS, TILE_LANES, WORKGROUP};
use crate::world::World;

/// The least number of casters with which a workgroup first counts in its own memory. With so many, casters are small
/// beside a tile, and threads would wait for each other at the tiles' counts.
pub const MANY_CASTERS: u32 = 1 << 18;

/// For workgroups that first count in their own memory: `TALLY_CASTERS` is how many casters each workgroup takes;
/// `TALLY_MOST_THREADS` is how many threads it has, or fewer where the device allows fewer.
const TALLY_CASTERS: u32 = 1024;
const TALLY_MOST_THREADS: u32 = 512;

/// Tiles of a map that a workgroup has room to count. Twin: the size of `tally` in glsl/maps/bins/tally.glsl.
const MOST_TALLIED: u32 = 4096;

/// Threads of a pass that is a single workgroup, where the device allows so many. Such a pass lists the tiles with the
/// most casters first, or chooses how fine tiles are.
const LONE_THREADS: u32 = 1024;

/// Shared memory that such a workgroup needs to choose how fine tiles are: 16 bytes per thread, and tables. With half
/// as many threads, every device has enough shared memory.
const LONE_BYTES: u32 = LONE_THREADS * 16 + 5120;

/// The most workgroups of the pass that surveys casters, where each workgroup first adds up in its own memory. The
/// fewer workgroups there are, the less they wait for each other when they add their sums to the tiles.
const MOST_SURVEYING: u64 = 256;

/// The most threads of a surveying workgroup, if the device takes so many, and the most threads that share a caster
/// there.
const SURVEYING_THREADS: u32 = 256;
const SURVEYING_LANES: u32 = 4;

/// Tiles of a map that a surveying workgroup has room for. Twin: MOST_TILES in glsl/maps/detail/survey.comp.
const MOST_SURVEYED: u32 = 1024;

/// The most tiles per thread when one workgroup lists the fullest tiles first. With more, the order gains less and one
/// workgroup would take too long.
const MOST_TURNS: u64 = 16;

/// How casters are surveyed.
#[derive(Clone, Copy)]
pub(in crate::maps) struct Surveying {
    /// Whether a workgroup first adds up in its own memory, and then adds its sums to the tiles.
    pub tallies: bool,
    /// Threads per workgroup.
    pub threads: u32,
    /// The most workgroups.
    most_groups: u64,
    /// Threads that share a caster.
    pub sharing: u32,
}

impl Surveying {
    /// Workgroups for `casters` casters.
    pub fn groups(self, casters: u32) -> [u32; 2] {
        let all = (u64::from(casters) * u64::from(self.sharing)).div_ceil(self.threads.into());
        groups(all.min(self.most_groups))
    }
}

/// Decisions that are taken before the passes are made.
pub(in crate::maps) struct Threads {
    /// Whether a workgroup first counts its casters' tiles in its own memory, and then adds its counts to the tiles'
    /// counts.
    pub tallies: bool,
    /// Whether tiles with the most casters are listed first.
    pub fullest_first: bool,
    /// Casters per workgroup of the passes over casters.
    pub casters_a_group: u32,
    pub surveying: Surveying,
    /// Threads that share a caster.
    lanes: u32,
    tally: u32,
    /// Threads of a pass that is one workgroup.
    lone: u32,
}

impl Threads {
    /// Threads for maps of `bins_per_map` bins each: tiles, or blocks of detail.
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
        // A power of two, and so a multiple of the slots of a tile.
        let has_room = context.features().max_compute_shared_memory_bytes >= LONE_BYTES;
        let lone = 1 << most.min(if has_room { LONE_THREADS } else { LONE_THREADS / 2 }).ilog2();
        let bins = u64::from(bins_per_map) * u64::from(map_count);
        let listed = what.blocks.map_or(bins, u64::from);
        let fullest_first = !software && what.entries != Entries::None && listed <= MOST_TURNS * u64::from(lone);
        // A power of two, so that it divides the casters of a workgroup.
        let tally = 1 << most.min(TALLY_MOST_THREADS).ilog2();
        let alone = bins_per_map <= MOST_SURVEYED * SLOTS;
        let threads = if alone { most.min(SURVEYING_THREADS) } else { 64 };
        // A software driver may end long loops early. So on software devices the number of workgroups is not limited,
        // and a thread loops no longer than in the other passes.
        let most_groups = if alone && !software { MOST_SURVEYING } else { u64::MAX };
        let surveying = Surveying { tallies: alone, threads, most_groups, sharing: lanes.min(SURVEYING_LANES) };
        Self { tallies, fullest_first, casters_a_group, surveying, lanes, tally, lone }
    }

    /// Constants of the shaders that count, place and scatter, and of those in glsl/maps/detail.
    pub fn constants(&self) -> Constants {
        Constants::new()
            .set(TILE_LANES, self.lanes)
            .set(TALLY_THREADS, self.tally)
            .set(TALLY_TURNS, TALLY_CASTERS / self.tally)
            .set(THREADS, self.lone)
            .set(WORKGROUP, self.lone)
    }
}
