//! Bins the casters to tiles of all lights' maps: count, place, scatter. Some techniques walk the casters of each tile;
//! others only need to know which casters meet any tile, and which tiles have casters.

pub(super) mod compact;
pub(super) mod cull;
pub(super) mod threads;
pub(super) mod totals;
pub(super) mod uses;

use super::Maps;
use super::detail::{self, Detail, SLOTS};
use crate::gpu::{Bindings, Buffer, Commands, Context, Kernel, Memory, Pass, Push, ReadBack, groups, push_struct};
use crate::maps::bins::cull::Cull;
use crate::maps::bins::threads::Threads;
use crate::maps::bins::totals::{BinTotals, TilePart};
use crate::maps::bins::uses::{Entries, Use};
use crate::shaders;
use crate::shaders::constant::{AREA, DETAIL, EMPTY_PARTS, HIDE, KEYED, PARTS, REACH, TILED};
use crate::shaders::set;
use crate::world::World;
use crate::{Error, Less, Result, WayOut};
use std::collections::BTreeMap;

/// Texels per side of a tile. Twin: TILE_TEXELS in glsl/maps/bins/tiles.glsl.
pub const TILE_TEXELS: u32 = 8;

/// Workgroups per row of the dispatch over listed parts. Twin: BIN_GROUPS_X in glsl/maps/bins/totals.glsl.
const GROUPS_X: u64 = 64;

/// Padding of one row of workgroups after the list of parts, because workgroups past the list's end read it too.
const PARTS_BEHIND: u64 = GROUPS_X;

/// Number of workgroup rows that every device supports.
const MAX_ROWS: u64 = 65535;

/// Initial capacity of the entry buffer, in entries per caster. It grows as needed.
const FIRST_ENTRIES: u64 = 8;

/// Maximum size of the entries, in bytes, if every tile has the same capacity. If the size would be larger, entries are
/// counted first, which costs a pass over all casters but needs the least memory.
const MOST_ROOM_BYTES: u64 = 16 << 20;

/// A tile's capacity, in entries, is a multiple of this.
const ROOM_STEP: u32 = 32;

/// Bytes per entry: its sort key or its maximum optical depth, and its caster.
const ENTRY_BYTES: u64 = 8;

push_struct! {
    /// Twin: BinPush in glsl/maps/bins/tiles.glsl.
    pub(super) struct BinPush {
        caster_count: u32,
        /// Capacity of the buffer, in entries.
        capacity: u32,
        /// Capacity of each tile, in entries; 0 if entries are counted first.
        room: u32,
        /// The mark of casters that are in some tile.
        mark: u32,
        map_count: u32,
    }
}

/// The bins and the passes that fill them.
pub struct Bins {
    map_count: u32,
    tiles: [u32; 2],
    /// Number of casters per tile: map after map, rows of tiles. With detail, per word of the table of blocks.
    pub counts: Buffer,
    cull: Cull,
    lists: Lists,
    /// Present if each tile is only as fine as it needs to be.
    detail: Option<Detail>,
    /// Number of casters per workgroup in the passes over casters.
    casters_a_group: u32,
    caster_count: u32,
    set: Bindings,
    find_horizon: Kernel<BinPush>,
    count: Kernel<BinPush>,
    place: Kernel<BinPush>,
    scatter: Kernel<BinPush>,
}

/// The entries of tiles, and the parts of tiles to build.
struct Lists {
    context: Context,
    map_count: u32,
    /// Number of tiles per map; with detail, the maximum number of blocks per map.
    bins_per_map: u32,
    /// Number of tiles over all maps; with detail, the maximum number of blocks.
    rooms: u64,
    /// The listed parts of tiles.
    parts: Buffer,
    /// Position of each tile's next entry.
    cursors: Buffer,
    /// [`BinTotals`].
    totals: Buffer,
    /// Copies of the totals for the host.
    totalled: ReadBack,
    entries: Buffer,
    capacity: u32,
    /// Capacity of each tile, in entries; 0 if entries are counted first.
    room: u32,
    /// Whether all tiles may have the same capacity.
    may_have_room: bool,
    /// Whether parts are not listed if all tiles have the same capacity.
    unlisted: bool,
    keeps_entries: bool,
    lists_parts: bool,
    /// Whether parts of the fullest tiles are listed first, by a single workgroup.
    fullest_first: bool,
    /// Number of workgroups per tile or block that has casters.
    parts_a_block: u32,
    /// The totals of the last build.
    last: Option<BinTotals>,
}

/// Returns the maximum number of entries that this device can bind.
fn limit(context: &Context) -> u64 {
    u64::from(context.features().max_storage_buffer_range) / ENTRY_BYTES
}

impl Bins {
    /// Creates bins over the volume maps.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out, or if there are more tiles than a dispatch supports.
    pub fn new(context: &Context, world: &World, maps: &Maps, what: Use) -> Result<Self> {
        let tiles = maps.tiles();
        let count = u64::from(maps.count());
        let bins_per_map = tiles[0] * tiles[1] * if what.blocks.is_some() { SLOTS } else { 1 };
        let bin_count = u64::from(bins_per_map) * count;
        let built = what.blocks.map_or(bin_count, u64::from);
        let parts_listed = built * u64::from(what.parts[0].max(what.parts[1]));
        if parts_listed > GROUPS_X * MAX_ROWS {
            return Err(Error::Gpu {
                operation: "list",
                name: "bins.parts".into(),
                cause: format!("{parts_listed} parts of tiles, and at most {} are dispatched", GROUPS_X * MAX_ROWS)
                    .into(),
                way_out: WayOut::Less(&[Less::Map, Less::Lights]),
            });
        }
        let buffer = |name, bytes| Buffer::new(context, name, bytes, Memory::Device);
        let counts = buffer("bins.counts", bin_count * 4)?;
        let totals = buffer("bins.totals", size_of::<BinTotals>() as u64)?;
        let threads = Threads::new(context, world, what, bins_per_map, maps.count());
        let casters = u64::from(world.caster_capacity());
        let wanted = if what.entries != Entries::None { casters * FIRST_ENTRIES } else { 1 };
        let capacity = wanted.clamp(1, limit(context)) as u32;
        let cull = Cull::new(context, world, maps, what.skip)?;
        let lists = Lists {
            context: context.clone(),
            map_count: maps.count(),
            bins_per_map,
            rooms: built,
            parts: buffer("bins.parts", (parts_listed + PARTS_BEHIND) * size_of::<TilePart>() as u64)?,
            cursors: buffer("bins.cursors", bin_count * 4)?,
            totalled: ReadBack::new(context, "bins.totalled", totals.bytes())?,
            totals,
            entries: buffer("bins.entries", u64::from(capacity) * ENTRY_BYTES)?,
            capacity,
            room: 0,
            may_have_room: what.entries != Entries::None && !threads.tallies,
            unlisted: false,
            keeps_entries: what.entries != Entries::None,
            lists_parts: what.parts != [0, 0],
            fullest_first: threads.fullest_first,
            parts_a_block: what.parts[0],
            last: None,
        };
        // Without detail, nothing reads the slots.
        let slots = if what.blocks.is_some() { detail::slots(context, maps)? } else { cull.horizon.clone() };
        let set = set::Bins {
            counts: &counts,
            parts: &lists.parts,
            cursors: &lists.cursors,
            totals: &lists.totals,
            entries: &lists.entries,
            met: &cull.met,
            horizon: &cull.horizon,
            slots: &slots,
        };
        let set = set.bind(context, "bins")?;
        let constants = threads
            .constants()
            .set(HIDE, cull.hides)
            .set(REACH, what.reach)
            .set(PARTS, what.parts[0])
            .set(EMPTY_PARTS, what.parts[1])
            .set(TILED, what.skip)
            .set(AREA, what.area)
            .set(KEYED, what.entries == Entries::Sorted)
            .set(DETAIL, what.blocks.is_some());
        let constants = maps.colored(&constants);
        let kernel = |shader| Kernel::compute(context, shader, &[maps.scene(), &set], &constants);
        let detailed = |blocks| Detail::new(context, maps, &set, slots, blocks, &threads, &constants);
        let detail = what.blocks.map(detailed).transpose()?;
        let [count_casters, scatter] = match (detail.is_some(), threads.tallies) {
            (true, _) => [&shaders::detail::COUNT, &shaders::detail::SCATTER],
            (_, true) => [&shaders::bins::COUNT_TALLY_1, &shaders::bins::SCATTER_TALLY_1],
            _ => [&shaders::bins::COUNT_TALLY_0, &shaders::bins::SCATTER_TALLY_0],
        };
        let place = match (&detail, threads.fullest_first) {
            (_, false) => kernel(&shaders::bins::PLACE)?,
            (None, _) => kernel(&shaders::bins::PLACE_FULLEST_LISTED_0)?,
            (Some(detail), _) => {
                let sets = [maps.scene(), &set, detail.set()];
                Kernel::compute(context, &shaders::bins::PLACE_FULLEST_LISTED_1, &sets, &constants)?
            }
        };
        Ok(Self {
            map_count: maps.count(),
            tiles,
            find_horizon: kernel(&shaders::bins::HORIZON)?,
            count: kernel(count_casters)?,
            place,
            scatter: kernel(scatter)?,
            counts,
            cull,
            lists,
            casters_a_group: threads.casters_a_group,
            detail,
            caster_count: world.caster_count(),
            set,
        })
    }

    /// Does not list parts if all tiles have the same capacity, for passes that do not need the list: see
    /// [`Bins::room`].
    pub fn unlisted(mut self) -> Self {
        self.lists.unlisted = true;
        self
    }

    /// Returns the capacity of each tile, in entries, if it is the same for all tiles; 0 if entries are counted first
    /// instead, and the parts of tiles are listed.
    pub fn room(&self) -> u32 {
        self.lists.room
    }

    /// Returns the number of tiles per map; with detail, the maximum number of blocks per map.
    pub fn bins_per_map(&self) -> u32 {
        self.lists.bins_per_map
    }

    /// Returns how fine each tile is; `None` if all tiles are equally fine.
    pub fn detail(&self) -> Option<&Detail> {
        self.detail.as_ref()
    }

    /// Returns the set with counts, listed parts, cursors, totals, entries, met, horizon and slots.
    pub fn set(&self) -> &Bindings {
        &self.set
    }

    /// Returns one word per current caster and map, map after map: 1 if the caster meets a tile of the map, else 0.
    /// Valid only if the bins keep no entries.
    pub fn met(&self) -> &Buffer {
        &self.cull.met
    }

    /// Returns, for each tile, the z in the map's volume view beyond which no light gets: map after map, rows of tiles.
    pub fn horizon(&self) -> &Buffer {
        &self.cull.horizon
    }

    /// Fills the bins of all maps. The opaque maps must have been drawn before.
    pub fn record(&mut self, commands: &mut Commands, world: &World) {
        self.caster_count = world.caster_count();
        self.cull.begin(self.lists.keeps_entries);
        commands.pass("bins.clear", |pass| {
            pass.fill(&self.counts, 0);
            pass.fill(&self.lists.totals, 0);
            self.cull.clear(pass);
            if let Some(detail) = &self.detail {
                pass.fill(detail.surveys(), 0);
            }
        });
        self.cull.horizon(commands, &self.find_horizon, &self.push(), self.tiles);
        if let Some(detail) = &self.detail {
            detail.survey(commands, &self.push());
            detail.choose(commands);
        }
        if self.lists.room != 0 {
            self.scatter(commands);
            if !self.lists.unlisted {
                self.place(commands);
            }
        } else {
            self.count(commands);
            if self.lists.lists_parts {
                self.place(commands);
            }
            if self.lists.keeps_entries {
                self.scatter(commands);
            }
        }
        commands.read_back(&self.lists.totals, &self.lists.totalled);
    }

    fn push(&self) -> BinPush {
        BinPush {
            caster_count: self.caster_count,
            capacity: self.lists.capacity,
            room: self.lists.room,
            mark: self.cull.mark,
            map_count: self.map_count,
        }
    }

    fn per_caster(&self, commands: &mut Commands, name: &str, kernel: &Kernel<BinPush>) {
        commands.pass(name, |pass| pass.dispatch(kernel, &self.push(), self.caster_groups()));
    }

    /// Returns the workgroups of a pass over all casters of all maps.
    fn caster_groups(&self) -> [u32; 3] {
        let [x, y] = groups(u64::from(self.caster_count.div_ceil(self.casters_a_group)));
        [x, y, self.map_count]
    }

    /// Counts the casters of each tile, and culls casters that are in no tile.
    fn count(&self, commands: &mut Commands) {
        self.per_caster(commands, "bins.count", &self.count);
    }

    /// Computes the index of each tile's first entry, and lists the parts of tiles to build.
    fn place(&self, commands: &mut Commands) {
        let [x, y] = groups(u64::from(self.lists.bins_per_map).div_ceil(64));
        let size = if self.lists.fullest_first { [1; 3] } else { [x, y, self.map_count] };
        commands.pass("bins.place", |pass| pass.dispatch(&self.place, &self.push(), size));
    }

    /// Writes the entries.
    fn scatter(&self, commands: &mut Commands) {
        self.per_caster(commands, "bins.scatter", &self.scatter);
    }

    /// Runs a shader with one workgroup per listed part of a tile.
    pub fn per_part<P: Push>(&self, pass: &mut Pass, kernel: &Kernel<P>, push: &P) {
        pass.dispatch_indirect(kernel, push, &self.lists.totals, std::mem::offset_of!(BinTotals, groups_x) as u64);
    }

    /// Reads the totals of the build of the completed frame `frame`. If the entries did not fit, enlarges their buffer
    /// and returns true: the build must run again.
    ///
    /// # Errors
    /// Same as [`Bins::make_room`].
    pub fn settle(&mut self, frame: u64) -> Result<bool> {
        let Some(totals) = self.lists.totalled.read::<BinTotals>(frame, 1)? else { return Ok(false) };
        let grew = self.make_room(totals.first().copied().unwrap_or_default())?;
        if grew {
            // Frames recorded earlier used a smaller buffer, so their totals do not show whether the entries fit now.
            self.lists.totalled.forget();
        }
        Ok(grew)
    }

    /// Enlarges the buffer for the entries of a build that counted `totals`, with the same capacity for each tile if
    /// possible. Returns whether the build must run again.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device has no room for them, [`Error::Refused`] if the driver ended loops over a tile's
    /// casters early.
    pub fn make_room(&mut self, totals: BinTotals) -> Result<bool> {
        let grew = self.lists.make_room(totals)?;
        if grew {
            self.set.replace(set::Bins::ENTRIES, &self.lists.entries)?;
        }
        Ok(grew)
    }

    /// Returns the counters of the last build over all maps, by name; empty before the first build. A caster counts as
    /// culled once for each map that does not see it.
    ///
    /// # Errors
    /// [`Error::Gpu`] if they cannot be read back.
    pub fn counters(&self) -> Result<BTreeMap<String, u64>> {
        let Some(last) = self.lists.last else { return Ok(BTreeMap::new()) };
        let casters = u64::from(self.caster_count) * u64::from(self.map_count);
        let met = self.cull.met_count(casters)?;
        let [entries, used] = self.lists.found(&last, &self.counts)?;
        let mut counters = BTreeMap::from([("bin_entries".into(), entries), ("culled_casters".into(), casters - met)]);
        if let Some(detail) = &self.detail {
            counters.insert("blocks".into(), u64::from(last.parts / self.lists.parts_a_block));
            counters.insert("blocks_at_most".into(), detail.block_count().into());
            counters.insert("blocks_used".into(), used);
        } else {
            let all = self.lists.rooms;
            counters.insert("tiles".into(), all);
            counters.insert("tiles_used".into(), used);
            counters.insert("tiles_skipped".into(), all - used);
        }
        Ok(counters)
    }

    /// Returns whether the tile of a texel has casters.
    ///
    /// # Errors
    /// [`Error::Gpu`] if its count cannot be read back.
    pub fn texel_in_use(&self, map: usize, [x, y]: [u32; 2]) -> Result<bool> {
        let tile = (map as u32 * self.tiles[1] + y / TILE_TEXELS) * self.tiles[0] + x / TILE_TEXELS;
        Ok(self.counts.read_from::<u32>(tile as usize, 1)? != [0])
    }

    /// Returns, for each texel, whether it is in a tile that has casters: map after map, rows of texels.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the counts cannot be read back.
    pub fn texels_in_use(&self, size: [u32; 2]) -> Result<Vec<bool>> {
        let tiles = (self.tiles[0] * self.tiles[1]) as usize;
        let counts: Vec<u32> = self.counts.read(self.map_count as usize * tiles)?;
        let tile = |i: u32| (i / size[0] / TILE_TEXELS * self.tiles[0] + i % size[0] / TILE_TEXELS) as usize;
        let map = |counts: &[u32]| (0..size[0] * size[1]).map(|i| counts[tile(i)] > 0).collect::<Vec<_>>();
        Ok(counts.chunks_exact(tiles).flat_map(map).collect())
    }

    /// Returns the bytes of all buffers except the counts, which look-ups may need. With detail, the counts are
    /// included, because look-ups need the slots instead.
    pub fn bytes_transient(&self) -> u64 {
        let detail = self.detail.as_ref().map_or(0, |d| d.bytes_transient() + self.counts.bytes());
        self.lists.bytes() + self.cull.bytes() + detail
    }
}

impl Lists {
    /// Same as [`Bins::make_room`], but does not put the new buffer into the set.
    fn make_room(&mut self, totals: BinTotals) -> Result<bool> {
        self.last = Some(totals);
        if totals.cut_short != 0 {
            return Err(super::cut_short("a tile"));
        }
        let entries = totals.all_entries();
        if !self.keeps_entries || (self.room != 0 && totals.fullest <= self.room) {
            return Ok(false);
        }
        // While all tiles have the same capacity, entries are not counted first.
        let had_room = self.room != 0;
        if self.take_room(&totals)? {
            return Ok(true);
        }
        if entries <= self.capacity.into() {
            return Ok(had_room);
        }
        // Allocate an eighth more than needed, so that an animated scene does not grow the buffer every frame. The
        // device's buffer size limit caps the surplus. If the needed size itself exceeds the limit, creating the buffer
        // fails.
        let wanted = (entries + entries / 8).min(limit(&self.context)).max(entries);
        self.entries = Buffer::new(&self.context, "bins.entries", wanted * ENTRY_BYTES, Memory::Device)?;
        self.capacity = wanted as u32;
        Ok(true)
    }

    /// Returns the capacity that each tile should have, in entries, after a build that counted `totals`: a quarter more
    /// entries than the fullest tile has, so that an animated scene does not grow the buffer every frame. 0 if this
    /// takes too much memory.
    fn room_for(&self, totals: &BinTotals) -> u32 {
        let most = u64::from(totals.fullest) + u64::from(totals.fullest / 4);
        let room = most.next_multiple_of(ROOM_STEP.into());
        let bytes = room * self.rooms * ENTRY_BYTES;
        let fits = bytes <= MOST_ROOM_BYTES.min(limit(&self.context) * ENTRY_BYTES);
        if self.may_have_room && fits { room as u32 } else { 0 }
    }

    /// Gives each tile the same capacity after a build that counted `totals`; false if that takes too much memory.
    fn take_room(&mut self, totals: &BinTotals) -> Result<bool> {
        self.room = self.room_for(totals);
        let wanted = u64::from(self.room) * self.rooms;
        if wanted == 0 {
            return Ok(false);
        }
        let Ok(entries) = Buffer::new(&self.context, "bins.entries", wanted * ENTRY_BYTES, Memory::Device) else {
            (self.room, self.may_have_room) = (0, false);
            return Ok(false);
        };
        (self.entries, self.capacity) = (entries, wanted as u32);
        Ok(true)
    }

    /// Returns the number of entries, and of tiles with casters, in the last build. If parts are not listed, `totals`
    /// lacks both numbers, and they are derived from `counts`.
    fn found(&self, totals: &BinTotals, counts: &Buffer) -> Result<[u64; 2]> {
        if self.room == 0 {
            return Ok([totals.all_entries(), totals.tiles_used.into()]);
        }
        let counts: Vec<u32> = counts.read(self.bins_per_map as usize * self.map_count as usize)?;
        let used = counts.iter().filter(|count| **count > 0).count() as u64;
        Ok([counts.iter().map(|count| u64::from(*count)).sum(), used])
    }

    fn bytes(&self) -> u64 {
        [&self.parts, &self.cursors, &self.totals, &self.entries].into_iter().map(Buffer::bytes).sum()
    }
}
