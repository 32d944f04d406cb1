//! Particles binned to tiles of the light's map: count, scan, scatter. Shared by the techniques that walk tiles.

use super::{LightData, SceneData};
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Context, Memory, Pipeline, Resource, shader};

/// Texels a side of a tile. Twin: TILE_TEXELS in glsl/bins/tiles.glsl.
pub const TILE_TEXELS: u32 = 8;

/// Entries a particle that the buffer starts with. It grows to what a scene demands.
const FIRST_ENTRIES: u64 = 8;

/// Bytes of an entry: key and particle.
const ENTRY_BYTES: u64 = 8;

/// The bins and the passes that fill them.
pub struct Bins {
    context: Context,
    /// Tiles across and down.
    pub tiles: [u32; 2],
    /// Particles of each tile, rows of tiles.
    pub counts: Buffer,
    offsets: Buffer,
    cursors: Buffer,
    /// Entries in all, particles in no tile, tiles with particles.
    totals: Buffer,
    entries: Buffer,
    capacity: u32,
    /// What `totals` held after the first build. The casters do not change, nor does this.
    read: Option<[u32; 3]>,
    scene: Bindings,
    bindings: Bindings,
    count: Pipeline,
    scan: Pipeline,
    scatter: Pipeline,
    particle_count: u32,
}

impl Bins {
    /// Bins over the light's volume map.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &SceneData, light: &LightData, lights: &Buffer) -> Result<Self> {
        let tiles = [light.volume.width.div_ceil(TILE_TEXELS), light.volume.height.div_ceil(TILE_TEXELS)];
        let words = u64::from(tiles[0]) * u64::from(tiles[1]) * 4;
        let buffer = |name, bytes| Buffer::new(context, name, bytes, Memory::Device);
        let counts = buffer("bins.counts", words)?;
        let offsets = buffer("bins.offsets", words)?;
        let cursors = buffer("bins.cursors", words)?;
        let totals = buffer("bins.totals", 12)?;
        let limit = u64::from(context.features().max_storage_buffer_range) / ENTRY_BYTES;
        let capacity = (u64::from(scene.particle_count) * FIRST_ENTRIES).clamp(64, limit) as u32;
        let entries = buffer("bins.entries", u64::from(capacity) * ENTRY_BYTES)?;
        let resources = [Resource::Buffer(lights.clone()), Resource::Buffer(scene.particles.clone())];
        let scene_bindings = Bindings::new(context, "bins.scene", &resources)?;
        let bindings = bindings(context, [&counts, &offsets, &cursors, &totals, &entries])?;
        let sets = [&scene_bindings, &bindings];
        Ok(Self {
            context: context.clone(),
            tiles,
            count: Pipeline::compute(context, shader("bins/count.comp")?, &sets, &[])?,
            scan: Pipeline::compute(context, shader("bins/scan.comp")?, &sets, &[])?,
            scatter: Pipeline::compute(context, shader("bins/scatter.comp")?, &sets, &[])?,
            counts,
            offsets,
            cursors,
            totals,
            entries,
            capacity,
            read: None,
            scene: scene_bindings,
            bindings,
            particle_count: scene.particle_count,
        })
    }

    /// The set with lights and particles.
    pub fn scene_bindings(&self) -> &Bindings {
        &self.scene
    }

    /// The set with counts, offsets, cursors, totals and entries.
    pub fn bindings(&self) -> &Bindings {
        &self.bindings
    }

    fn per_particle(&self, commands: &mut Commands, name: &str, pipeline: &Pipeline) {
        commands.pass(name, |pass| {
            let push = [self.particle_count, self.capacity];
            let groups = [self.particle_count.div_ceil(64), 1, 1];
            pass.dispatch(pipeline, &[&self.scene, &self.bindings], bytemuck::bytes_of(&push), groups);
        });
    }

    /// Empties the bins.
    pub fn clear(&self, commands: &mut Commands) {
        commands.pass("bins.clear", |pass| {
            pass.fill(&self.counts, 0);
            pass.fill(&self.totals, 0);
        });
    }

    /// Counts the particles of each tile; those in no tile are culled here.
    pub fn count(&self, commands: &mut Commands) {
        self.per_particle(commands, "bins.count", &self.count);
    }

    /// Finds each tile's place among the entries.
    pub fn scan(&self, commands: &mut Commands) {
        commands.pass("bins.scan", |pass| {
            let push = self.tiles[0] * self.tiles[1];
            pass.dispatch(&self.scan, &[&self.scene, &self.bindings], bytemuck::bytes_of(&push), [1, 1, 1]);
        });
    }

    /// Writes the entries.
    pub fn scatter(&self, commands: &mut Commands) {
        self.per_particle(commands, "bins.scatter", &self.scatter);
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
        let totals = self.totals.read::<u32>(3)?;
        let entries = totals[0];
        self.read = totals.try_into().ok();
        if entries <= self.capacity {
            return Ok(false);
        }
        self.capacity = entries.saturating_add(entries / 8);
        let bytes = u64::from(self.capacity) * ENTRY_BYTES;
        self.entries = Buffer::new(&self.context, "bins.entries", bytes, Memory::Device)?;
        let buffers = [&self.counts, &self.offsets, &self.cursors, &self.totals, &self.entries];
        self.bindings = bindings(&self.context, buffers)?;
        Ok(true)
    }

    /// Counts of a build, by name.
    pub fn counters(&self) -> [(String, u64); 5] {
        let [entries, culled, used] = self.read.unwrap_or_default().map(u64::from);
        let all = u64::from(self.tiles[0]) * u64::from(self.tiles[1]);
        [
            ("bin_entries".into(), entries),
            ("culled_particles".into(), culled),
            ("tiles".into(), all),
            ("tiles_used".into(), used),
            ("tiles_skipped".into(), all - used),
        ]
    }

    /// Whether each texel is in a tile that has particles, rows of texels.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the counts cannot be read back.
    pub fn texels_in_use(&self, size: [u32; 2]) -> Result<Vec<bool>> {
        let counts: Vec<u32> = self.counts.read((self.tiles[0] * self.tiles[1]) as usize)?;
        let tile = |x: u32, y: u32| (y / TILE_TEXELS * self.tiles[0] + x / TILE_TEXELS) as usize;
        Ok((0..size[0] * size[1]).map(|i| counts[tile(i % size[0], i / size[0])] > 0).collect())
    }

    /// All but the counts, which look-ups need.
    pub fn bytes_transient(&self) -> u64 {
        self.offsets.bytes() + self.cursors.bytes() + self.totals.bytes() + self.entries.bytes()
    }
}

fn bindings(context: &Context, buffers: [&Buffer; 5]) -> Result<Bindings> {
    Bindings::new(context, "bins", &buffers.map(|b| Resource::Buffer(b.clone())))
}
