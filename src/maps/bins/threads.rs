//! How binning passes run: threads per workgroup, casters per thread, and which variants of the shaders.

use crate::gpu::{Constants, Context, groups};
use crate::maps::detail::SLOTS;
use crate::maps::{Entries, Use};
use crate::shaders::constant::{TALLY_THREADS, TALLY_TURNS, THREADS, TILE_LANES, WORKGROUP};
use crate::world::World;

/// From so many casters on they are small beside a tile, and threads wait for each other at the counts of tiles: a workgroup
/// then counts by itself before.
pub const MANY_CASTERS: u32 = 1 << 18;

/// Casters of such a workgroup, which has a thread for each, and threads, or as many as the device takes.
const TALLY_CASTERS: u32 = 1024;
const TALLY_MOST_THREADS: u32 = 512;

/// Tiles of a map that a workgroup has room to count. Twin: the size of `tally` in glsl/maps/bins/tally.glsl.
const MOST_TALLIED: u32 = 4096;

/// Threads of a pass of one workgroup, which lists the fullest tiles first or chooses how fine tiles are, or as many as the device
/// takes.
const LONE_THREADS: u32 = 1024;

/// Shared memory of so many that choose, 16 bytes each and tables; half as many fit into the shared memory of every
/// device.
const LONE_BYTES: u32 = LONE_THREADS * 16 + 5120;

/// The most workgroups that survey casters, each in its own memory first: with fewer they wait less for each other at
/// the end.
const MOST_SURVEYING: u64 = 256;

/// Threads of such a workgroup, or as many as the device takes, and threads that share a caster then, at most.
const SURVEYING_THREADS: u32 = 256;
const SURVEYING_LANES: u32 = 4;

/// Tiles of a map that such a workgroup has room for. Twin: MOST_TILES in glsl/maps/detail/survey.comp.
const MOST_SURVEYED: u32 = 1024;

/// Tiles of each when it lists them, at most: of more tiles each is less of the whole, and one workgroup would take too long.
const MOST_TURNS: u64 = 16;

/// How casters are surveyed.
#[derive(Clone, Copy)]
pub(in crate::maps) struct Surveying {
    /// A workgroup adds up by itself before it adds to the tiles.
    pub tallies: bool,
    /// Threads per workgroup.
    pub threads: u32,
    /// Workgroups, at most.
    most_groups: u64,
    /// That share a caster.
    pub sharing: u32,
}

impl Surveying {
    /// Workgroups for so many casters.
    pub fn groups(self, casters: u32) -> [u32; 2] {
        let all = (u64::from(casters) * u64::from(self.sharing)).div_ceil(self.threads.into());
        groups(all.min(self.most_groups))
    }
}

/// What is decided before the passes are made.
pub(in crate::maps) struct Threads {
    /// A workgroup counts its casters' tiles by itself before it adds them to the tiles' counts.
    pub tallies: bool,
    /// Tiles with the most casters are listed first.
    pub fullest_first: bool,
    /// Casters of a workgroup of the passes over them.
    pub casters_a_group: u32,
    pub surveying: Surveying,
    /// That share a caster.
    lanes: u32,
    tally: u32,
    /// Threads of a pass that is one workgroup.
    lone: u32,
}

impl Threads {
    /// Threads for maps of so many bins each: tiles, or blocks of detail.
    pub fn new(context: &Context, world: &World, what: Use, bins_a_map: u32, map_count: u32) -> Self {
        let (software, most) = (context.features().is_software(), context.features().max_compute_workgroup_threads);
        let tallies =
            !software && what.blocks.is_none() && world.caster_capacity() >= MANY_CASTERS && bins_a_map <= MOST_TALLIED;
        let [lanes, casters_a_group] = match (software, tallies) {
            (true, _) => [1, 64],
            (_, true) => [1, TALLY_CASTERS],
            _ => [16, 64 / 16],
        };
        // A power of two, which slots of tiles divide.
        let has_room = context.features().max_compute_shared_memory_bytes >= LONE_BYTES;
        let lone = 1 << most.min(if has_room { LONE_THREADS } else { LONE_THREADS / 2 }).ilog2();
        let bins = u64::from(bins_a_map) * u64::from(map_count);
        let listed = what.blocks.map_or(bins, u64::from);
        let fullest_first = !software && what.entries != Entries::None && listed <= MOST_TURNS * u64::from(lone);
        // A power of two, which divides the casters.
        let tally = 1 << most.min(TALLY_MOST_THREADS).ilog2();
        let alone = bins_a_map <= MOST_SURVEYED * SLOTS;
        let threads = if alone { most.min(SURVEYING_THREADS) } else { 64 };
        // A software driver may end loops of many rounds, of which a thread then has no more than in the other passes.
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
