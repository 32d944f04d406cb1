//! Casters binned to tiles of the lights' maps, map after map: count, place, scatter. Shared by the techniques that walk
//! tiles, and by those that only want to know which casters meet some tile and which tiles have casters.

use super::SceneData;
use super::light::Maps;
use super::opaque::OpaqueMap;
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Context, Memory, Pass, Pipeline, Resource, shader};
use bytemuck::{Pod, Zeroable};

/// Texels a side of a tile. Twin: TILE_TEXELS in glsl/bins/tiles.glsl.
pub const TILE_TEXELS: u32 = 8;

/// Room behind the list, which workgroups past its end read: a row of them. Twin: BIN_GROUPS_X in glsl/bins/totals.glsl.
const PARTS_BEHIND: u64 = 64;

/// Entries a caster that the buffer starts with. It grows to what a scene demands.
const FIRST_ENTRIES: u64 = 8;

/// Bytes of an entry: key and caster.
const ENTRY_BYTES: u64 = 8;

/// Twin: BinTotals in glsl/bins/totals.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct BinTotals {
    /// Of all tiles of a map.
    pub entries: u32,
    /// Tiles with casters.
    pub tiles_used: u32,
    /// Parts of tiles that are built.
    pub parts: u32,
    /// VkDispatchIndirectCommand of a workgroup a listed part.
    pub groups_x: u32,
    /// Likewise.
    pub groups_y: u32,
    /// Likewise.
    pub groups_z: u32,
}

/// What a workgroup builds. Twin: TilePart in glsl/bins/totals.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TilePart {
    /// Row after row of tiles.
    pub tile: u32,
    /// Which part of it.
    pub part: u32,
    /// The first of the tile's entries.
    pub first: u32,
    /// Of them, as far as there is room for them.
    pub count: u32,
}

/// The bins and the passes that fill them.
pub struct Bins {
    context: Context,
    /// Tiles across and down a map.
    pub tiles: [u32; 2],
    map_count: u32,
    /// Casters of each tile: map after map, rows of tiles.
    pub counts: Buffer,
    /// The listed parts of tiles of a map.
    parts: Buffer,
    /// Where the next entry of each tile goes.
    cursors: Buffer,
    /// [`BinTotals`] of each map.
    totals: Buffer,
    entries: Buffer,
    /// Whether a caster of a map is in some tile.
    met: Buffer,
    /// z in the map's volume view behind which no light gets: map after map, rows of tiles.
    pub horizon: Buffer,
    /// Whether casters behind the horizon are left out.
    hide: bool,
    /// Threads a caster. Twin: TILE_LANES.
    lanes: u32,
    keeps_entries: bool,
    capacity: u32,
    /// What `totals` held after the first build. The casters do not change, nor does this.
    read: Option<Vec<BinTotals>>,
    /// Casters that were in some tile then, over all maps.
    met_casters: u64,
    scene: Bindings,
    bindings: Bindings,
    find_horizon: Pipeline,
    count: Pipeline,
    place: Pipeline,
    scatter: Pipeline,
    caster_count: u32,
}

/// What bins are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Use {
    /// Entries are wanted, and not only which casters and tiles meet.
    pub entries: bool,
    /// Casters that stand in the dark behind meshes may be left out.
    pub skip: bool,
    /// Texels around a tile from which look-ups read it.
    pub reach: u32,
    /// Workgroups a tile in [`Bins::per_part`]: of one with casters, of one without.
    pub parts: [u32; 2],
}

impl Bins {
    /// Bins over the volume maps.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &SceneData, maps: &Maps, opaque: &OpaqueMap, what: Use) -> Result<Self> {
        let tiles = maps.size().map(|texels| texels.div_ceil(TILE_TEXELS));
        let count = u64::from(maps.count());
        let words = u64::from(tiles[0]) * u64::from(tiles[1]) * 4;
        let buffer = |name, bytes| Buffer::new(context, name, bytes, Memory::Device);
        let counts = buffer("bins.counts", count * words)?;
        let most_parts =
            u64::from(tiles[0]) * u64::from(tiles[1]) * u64::from(what.parts[0].max(what.parts[1])) + PARTS_BEHIND;
        let parts = buffer("bins.parts", most_parts * size_of::<TilePart>() as u64)?;
        let cursors = buffer("bins.cursors", words)?;
        let totals = buffer("bins.totals", count * size_of::<BinTotals>() as u64)?;
        let limit = u64::from(context.features().max_storage_buffer_range) / ENTRY_BYTES;
        let wanted = if what.entries { u64::from(scene.caster_count) * FIRST_ENTRIES } else { 1 };
        let capacity = wanted.clamp(1, limit) as u32;
        let met = buffer("bins.met", count * u64::from(scene.caster_count.max(1)) * 4)?;
        let horizon = buffer("bins.horizon", count * words)?;
        let hide = what.skip && scene.triangle_count > 0;
        let entries = buffer("bins.entries", u64::from(capacity) * ENTRY_BYTES)?;
        let resources = [
            Resource::Buffer(maps.buffer.clone()),
            Resource::Buffer(scene.casters.clone()),
            Resource::Texture(opaque.image.clone()),
        ];
        let scene_bindings = Bindings::new(context, "bins.scene", &resources)?;
        let bindings = bindings(context, [&counts, &parts, &cursors, &totals, &entries, &met, &horizon])?;
        let sets = [&scene_bindings, &bindings];
        let lanes = if context.features().kind == "cpu" { 1 } else { 16 };
        let constants = [u32::from(hide), what.reach, lanes, what.parts[0], what.parts[1]];
        Ok(Self {
            context: context.clone(),
            tiles,
            map_count: maps.count(),
            find_horizon: Pipeline::compute(context, shader("bins/horizon.comp")?, &sets, &constants)?,
            count: Pipeline::compute(context, shader("bins/count.comp")?, &sets, &constants)?,
            place: Pipeline::compute(context, shader("bins/place.comp")?, &sets, &constants)?,
            scatter: Pipeline::compute(context, shader("bins/scatter.comp")?, &sets, &constants)?,
            counts,
            parts,
            cursors,
            totals,
            entries,
            met,
            horizon,
            hide,
            lanes,
            keeps_entries: what.entries,
            capacity,
            read: None,
            met_casters: 0,
            scene: scene_bindings,
            bindings,
            caster_count: scene.caster_count,
        })
    }

    /// The set with maps, casters and the opaque map.
    pub fn scene_bindings(&self) -> &Bindings {
        &self.scene
    }

    /// The set with counts, listed parts, cursors, totals, entries, met and horizon.
    pub fn bindings(&self) -> &Bindings {
        &self.bindings
    }

    fn per_caster(&self, commands: &mut Commands, map: u32, name: &str, pipeline: &Pipeline) {
        commands.pass(name, |pass| {
            let push = [map, self.caster_count, self.capacity];
            let groups = [(self.caster_count * self.lanes).div_ceil(64), 1, 1];
            pass.dispatch(pipeline, &[&self.scene, &self.bindings], bytemuck::bytes_of(&push), groups);
        });
    }

    /// Empties the bins of all maps.
    pub fn clear(&self, commands: &mut Commands) {
        commands.pass("bins.clear", |pass| {
            pass.fill(&self.counts, 0);
            pass.fill(&self.totals, 0);
            pass.fill(&self.met, 0);
        });
    }

    /// Finds how far light gets in each tile of a map. No pass where that does not matter.
    pub fn horizon(&self, commands: &mut Commands, map: u32) {
        if self.hide {
            commands.pass("bins.horizon", |pass| {
                let sets = [&self.scene, &self.bindings];
                let groups = [self.tiles[0], self.tiles[1], 1];
                pass.dispatch(&self.find_horizon, &sets, bytemuck::bytes_of(&map), groups);
            });
        }
    }

    /// Counts the casters of each tile of a map; those in no tile are culled here. Needs [`Bins::horizon`].
    pub fn count(&self, commands: &mut Commands, map: u32) {
        self.per_caster(commands, map, "bins.count", &self.count);
    }

    /// Finds each tile's place among the entries, and lists the parts of tiles of a map that are built.
    pub fn place(&self, commands: &mut Commands, map: u32) {
        commands.pass("bins.place", |pass| {
            let tiles = self.tiles[0] * self.tiles[1];
            let push = [map, tiles, self.capacity];
            let groups = [tiles.div_ceil(64), 1, 1];
            pass.dispatch(&self.place, &[&self.scene, &self.bindings], bytemuck::bytes_of(&push), groups);
        });
    }

    /// Runs a shader with a workgroup for each listed part of a tile of a map, and the map as push constant.
    pub fn per_part(&self, pass: &mut Pass, map: u32, pipeline: &Pipeline, sets: &[&Bindings]) {
        let totals = u64::from(map) * size_of::<BinTotals>() as u64;
        let groups = totals + std::mem::offset_of!(BinTotals, groups_x) as u64;
        pass.dispatch_indirect(pipeline, sets, bytemuck::bytes_of(&map), &self.totals, groups);
    }

    /// Writes the entries of a map, over those of the last.
    pub fn scatter(&self, commands: &mut Commands, map: u32) {
        self.per_caster(commands, map, "bins.scatter", &self.scatter);
    }

    /// Reads the totals of the first build. Where the entries did not fit, makes room and says that the build must run
    /// again.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device has no room for them.
    pub fn grow(&mut self) -> Result<bool> {
        if self.read.is_some() {
            return Ok(false);
        }
        let totals: Vec<BinTotals> = self.totals.read(self.map_count as usize)?;
        let entries = totals.iter().map(|t| t.entries).max().unwrap_or(0);
        self.read = Some(totals);
        let met: Vec<u32> = self.met.read(self.map_count as usize * self.caster_count as usize)?;
        self.met_casters = met.into_iter().map(u64::from).sum();
        if entries <= self.capacity || !self.keeps_entries {
            return Ok(false);
        }
        self.capacity = entries.saturating_add(entries / 8);
        let bytes = u64::from(self.capacity) * ENTRY_BYTES;
        self.entries = Buffer::new(&self.context, "bins.entries", bytes, Memory::Device)?;
        let buffers = [&self.counts, &self.parts, &self.cursors, &self.totals, &self.entries, &self.met, &self.horizon];
        self.bindings = bindings(&self.context, buffers)?;
        Ok(true)
    }

    /// Counts of a build over all maps, by name; a caster is culled once for each map that does not see it.
    pub fn counters(&self) -> [(String, u64); 5] {
        let sum = |of: fn(&BinTotals) -> u32| self.read.iter().flatten().map(|t| u64::from(of(t))).sum::<u64>();
        let (entries, used) = (sum(|t| t.entries), sum(|t| t.tiles_used));
        let culled = u64::from(self.caster_count) * u64::from(self.map_count) - self.met_casters;
        let all = u64::from(self.tiles[0]) * u64::from(self.tiles[1]) * u64::from(self.map_count);
        [
            ("bin_entries".into(), entries),
            ("culled_casters".into(), culled),
            ("tiles".into(), all),
            ("tiles_used".into(), used),
            ("tiles_skipped".into(), all - used),
        ]
    }

    /// Whether each texel is in a tile that has casters: map after map, rows of texels.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the counts cannot be read back.
    pub fn texels_in_use(&self, size: [u32; 2]) -> Result<Vec<bool>> {
        let tiles = (self.tiles[0] * self.tiles[1]) as usize;
        let counts: Vec<u32> = self.counts.read(self.map_count as usize * tiles)?;
        let tile = |i: u32| (i / size[0] / TILE_TEXELS * self.tiles[0] + i % size[0] / TILE_TEXELS) as usize;
        let map = |counts: &[u32]| (0..size[0] * size[1]).map(|i| counts[tile(i)] > 0).collect::<Vec<_>>();
        Ok(counts.chunks_exact(tiles).flat_map(map).collect())
    }

    /// All but the counts, which look-ups need.
    pub fn bytes_transient(&self) -> u64 {
        let buffers = [&self.parts, &self.cursors, &self.totals, &self.entries, &self.met, &self.horizon];
        buffers.into_iter().map(Buffer::bytes).sum()
    }
}

fn bindings(context: &Context, buffers: [&Buffer; 7]) -> Result<Bindings> {
    Bindings::new(context, "bins", &buffers.map(|b| Resource::Buffer(b.clone())))
}
