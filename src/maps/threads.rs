//! How the passes that bin run: threads of a workgroup, casters of a thread, and which of their shaders suit.

use super::Use;
use crate::gpu::{Constants, Context};
use crate::shaders::constant::{TALLY_THREADS, TALLY_TURNS, THREADS, TILE_LANES, WORKGROUP};
use crate::world::World;

/// From so many casters on they are small beside a tile, and threads wait for each other at the counts of tiles: a workgroup
/// then counts by itself before.
pub const MANY_CASTERS: u32 = 1 << 18;

/// Casters of such a workgroup, which has a thread for each, and threads, or as many as the device takes.
const TALLY_CASTERS: u32 = 1024;
const TALLY_MOST_THREADS: u32 = 512;

/// Tiles of a map that a workgroup has room to count. Twin: the size of `tally` in glsl/bins/tally.glsl.
const MOST_TALLIED: u32 = 4096;

/// Threads of a pass of one workgroup, which lists the fullest tiles first or chooses how fine tiles are, or as many as the device
/// takes.
const LONE_THREADS: u32 = 1024;

/// Tiles of each when it lists them, at most: of more tiles each is less of the whole, and one workgroup would take too long.
const MOST_TURNS: u64 = 16;

/// What is decided before the passes are made.
pub(super) struct Threads {
    /// A workgroup counts its casters' tiles by itself before it adds them to the tiles' counts.
    pub tallies: bool,
    /// Tiles with the most casters are listed first.
    pub fullest_first: bool,
    /// Casters of a workgroup of the passes over them.
    pub casters_a_group: u32,
    /// That share a caster.
    lanes: u32,
    tally: u32,
    /// Of a pass of one workgroup.
    lone: u32,
}

impl Threads {
    /// Of maps of so many bins each: tiles, or with detail blocks.
    pub fn new(context: &Context, world: &World, what: Use, bins_a_map: u32, map_count: u32) -> Self {
        let (software, most) = (context.features().is_software(), context.features().max_compute_workgroup_threads);
        let tallies =
            !software && what.blocks.is_none() && world.caster_capacity() >= MANY_CASTERS && bins_a_map <= MOST_TALLIED;
        let [lanes, casters_a_group] = match (software, tallies) {
            (true, _) => [1, 64],
            (_, true) => [1, TALLY_CASTERS],
            _ => [16, 64 / 16],
        };
        let lone = most.min(LONE_THREADS);
        let bins = u64::from(bins_a_map) * u64::from(map_count);
        // Blocks are as fine as they have casters.
        let fullest_first = !software && what.entries && what.blocks.is_none() && bins <= MOST_TURNS * u64::from(lone);
        // A power of two, which divides the casters.
        let tally = 1 << most.min(TALLY_MOST_THREADS).ilog2();
        Self { tallies, fullest_first, casters_a_group, lanes, tally, lone }
    }

    /// Of the shaders that count, place and scatter, and of those in glsl/detail.
    pub fn constants(&self) -> Constants {
        Constants::new()
            .set(TILE_LANES, self.lanes)
            .set(TALLY_THREADS, self.tally)
            .set(TALLY_TURNS, TALLY_CASTERS / self.tally)
            .set(THREADS, self.lone)
            .set(WORKGROUP, self.lone)
    }
}
