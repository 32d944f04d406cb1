//! Code shared by techniques that work in world space: the grid of voxels occupied by meshes and filled by smoke and hair, rebuilt when the
//! world changes. It belongs to the world, not to a light: it costs the same for one light as for a thousand.

mod cells;
mod content;
mod lists;
mod masks;
mod media;
mod placement;
mod voxelize;

pub use self::content::Refinement;
pub use self::lists::{ListTotals, caster_share};
pub(crate) use self::media::faces;
pub use self::media::{MediaContent, media_limit};
pub use self::placement::Placement;
pub use self::voxelize::Voxelizer;

use self::content::{CasterVoxels, MeshVoxels};
use self::lists::{CastLists, Lists};
use self::masks::Masks;
use self::media::Media;
use self::voxelize::Voxelize;
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, groups, push_struct};
use crate::shaders::grid as shaders;
use crate::shaders::set;
use crate::world::{BuildStamp, Parts, World};
use bytemuck::{Pod, Zeroable};

/// Number of threads per workgroup in every pass.
const THREADS: u32 = 64;

/// Number of workgroups that find the bounds of meshes, smoke and hair.
const BOUNDS_GROUPS: u32 = 512;

/// Number of workgroups that share the triangles overlapping many voxels.
const LARGE_GROUPS: u32 = 1024;

/// Size in bytes of the two counts that precede a list of triangles or casters overlapping many voxels: how many of them are handled by one
/// workgroup each, and how many are handled by all workgroups together.
const LISTS_BYTES: u64 = 8;

/// The placement of a grid. Twin: Grid in glsl/grid/grid.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GridData {
    /// Low corner of the grid, in world units.
    pub origin: [f32; 3],
    /// Side of a voxel, in world units.
    pub voxel: f32,
    /// Number of voxels per world unit.
    pub per_unit: f32,
    /// Number of voxels per side.
    pub size: u32,
    /// Low corner of the box around all casters, in world units, as integers ordered like the floats.
    pub low: [u32; 3],
    /// High corner of that box, in the same form.
    pub high: [u32; 3],
}

/// Returns the number of 64-bit words per side of a level. A word has a bit per voxel, per brick of 4³ voxels, or per block of 16³.
const fn side(size: u32, level: u32) -> u32 {
    size >> (2 * level + 2)
}

/// Returns the number of voxels per side of a grid that needs `fitted` of them along the longest side of the box around all casters: a
/// power of two, and whole blocks of the highest level. The voxels beyond `fitted` stay empty. Twin: reference::twin::grid::Place::about.
pub fn voxels_per_side(fitted: u32) -> u32 {
    fitted.next_power_of_two().max(1 << (2 * GRID_LEVELS))
}

/// Number of levels of bits.
pub const GRID_LEVELS: u32 = 3;

/// Returns the number of 64-bit words in all levels.
pub fn grid_words(size: u32) -> u32 {
    (0..GRID_LEVELS).map(|level| side(size, level).pow(3)).sum()
}

push_struct! {
    /// Twin: GridPush in glsl/grid/build.glsl.
    struct GridPush {
        triangle_count: u32,
        caster_count: u32,
        threads: u32,
        level: u32,
        pairs_room: u32,
        share: u32,
        fitted: u32,
    }
}

/// A grid of voxels, and the passes that fill it. Sources: Schwarz and Seidel 2010 (voxels overlapped by a triangle); levels and clearing
/// are ours.
pub struct Grid {
    size: u32,
    data: Buffer,
    bits: Buffer,
    large: Buffer,
    place: Place,
    meshes: MeshVoxels,
    casters: CasterVoxels,
    clear: Kernel<GridPush>,
    voxelized: BuildStamp,
    deposited: BuildStamp,
}

/// The placement of a grid.
enum Place {
    /// Around all casters, with `voxels` voxels along the longest side of their box.
    Fitted { voxels: u32, bounds: Kernel<GridPush>, fit: Kernel<GridPush> },
    /// At a placement given by the caller.
    Given(GridData),
}

impl Place {
    fn new(context: &Context, world: &World, grid: &Bindings, plan: PlacePlan) -> Result<Self> {
        let voxels = match plan {
            PlacePlan::Fitted(voxels) => voxels,
            PlacePlan::Given(place) => return Ok(Self::Given(place)),
        };
        let casters = set::GridCasters { casters: &world.casters }.bind(context, "grid.casters")?;
        let constants = Constants::new();
        let bounds = Kernel::compute(context, &shaders::BOUNDS, &[grid, &casters], &constants)?;
        Ok(Self::Fitted { voxels, bounds, fit: Kernel::compute(context, &shaders::FIT, &[grid], &constants)? })
    }
}

/// The smoke and hair data planned for a new grid: see [`CasterVoxels`].
#[derive(Clone, Copy)]
enum CasterPlan {
    Nothing,
    Media(MediaContent),
    Lists,
}

/// The placement planned for a new grid: see [`Place`].
#[derive(Clone, Copy)]
enum PlacePlan {
    Fitted(u32),
    Given(GridData),
}

/// Bindings of a look-up. If the grid lacks a buffer, its bits are bound instead.
#[derive(Clone, Copy)]
pub struct GridBuffers<'a> {
    /// Holds a [`GridData`].
    pub data: &'a Buffer,
    /// A bit per voxel, set if a mesh overlaps the voxel, and the bits of the higher levels.
    pub bits: &'a Buffer,
    /// Optical depth of each voxel's smoke and hair.
    pub media: &'a Buffer,
    /// A bit per voxel, set if the voxel has smoke or hair, and the bits of the higher levels.
    pub media_bits: &'a Buffer,
    /// Cell counts for cone tracing, or the lists of triangles in a grid that has them.
    pub cells: &'a Buffer,
    /// The masks of occupied voxels.
    pub masks: &'a Buffer,
}

impl Grid {
    /// Creates a grid of `size` voxels per side, a power of two from 64 to 512, around all casters of `world`.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] if there is smoke or hair and the device cannot bind a buffer with one number per voxel,
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, size: u32, voxelizer: Voxelizer, finer: Refinement) -> Result<Self> {
        let has_casters = world.caster_capacity() > 0;
        let casters = if has_casters { CasterPlan::Media(MediaContent::default()) } else { CasterPlan::Nothing };
        Self::planned(context, world, PlacePlan::Fitted(size), Some((voxelizer, finer)), casters)
    }

    /// Creates a grid that lists the triangles and the casters of each voxel.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn listing(context: &Context, world: &World, size: u32) -> Result<Self> {
        let meshes = Some((Voxelizer::Listed, Refinement::Nothing));
        Self::planned(context, world, PlacePlan::Fitted(size), meshes, CasterPlan::Lists)
    }

    /// Creates a grid of smoke and hair only, with the data selected by `holds`, and `fitted` voxels along the longest side of the box
    /// around them ([`voxels_per_side`]).
    ///
    /// # Errors
    /// Same as [`Grid::new`].
    pub fn of_media(context: &Context, world: &World, fitted: u32, holds: MediaContent) -> Result<Self> {
        Self::planned(context, world, PlacePlan::Fitted(fitted), None, CasterPlan::Media(holds))
    }

    /// Creates a grid of the meshes only, at `place`. All meshes must be inside it, at least a voxel from its sides.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn of_meshes(context: &Context, world: &World, place: GridData) -> Result<Self> {
        let meshes = Some((Voxelizer::Compute, Refinement::Nothing));
        Self::planned(context, world, PlacePlan::Given(place), meshes, CasterPlan::Nothing)
    }

    /// Creates a grid; `meshes` is None for a grid without meshes.
    fn planned(
        context: &Context,
        world: &World,
        place: PlacePlan,
        meshes: Option<(Voxelizer, Refinement)>,
        casters: CasterPlan,
    ) -> Result<Self> {
        if !matches!(casters, CasterPlan::Nothing) {
            world.one_color("a grid keeps")?;
        }
        let size = voxels_per_side(match place {
            PlacePlan::Fitted(voxels) => voxels,
            PlacePlan::Given(place) => place.size,
        });
        let data = Buffer::new(context, "grid.data", size_of::<GridData>() as u64, Memory::Device)?;
        // Zeroed, since clearing passes only visit words that are not 0.
        let bits = Buffer::zeroed(context, "grid.bits", 8 * u64::from(grid_words(size)))?;
        let listed = LISTS_BYTES + 4 * u64::from(world.triangle_capacity().max(1));
        let large = Buffer::new(context, "grid.large", listed, Memory::Device)?;
        let set = set::Grid { grid: &data, grid_bits: &bits, triangles: &world.triangles, listed: &large };
        let set = set.bind(context, "grid")?;
        let of_place = match (meshes, place) {
            (None, _) => Parts::CASTERS,
            (Some(_), PlacePlan::Fitted(_)) => Parts::BOX,
            (Some(_), PlacePlan::Given(_)) => Parts::MESHES,
        };
        let of_meshes = if meshes.is_some() { Parts::MESHES.and(of_place) } else { of_place };
        Ok(Self {
            size,
            place: Place::new(context, world, &set, place)?,
            meshes: match meshes {
                Some(held) => MeshVoxels::new(context, world, size, &set, held)?,
                None => MeshVoxels::Nothing,
            },
            casters: match casters {
                CasterPlan::Nothing => CasterVoxels::Nothing,
                CasterPlan::Media(content) => CasterVoxels::Media(Media::new(context, world, size, &set, content)?),
                CasterPlan::Lists => CasterVoxels::Lists(CastLists::new(context, world, size, &data)?),
            },
            clear: Kernel::compute(context, &shaders::CLEAR, &[&set], &Constants::new())?,
            bits,
            large,
            data,
            voxelized: BuildStamp::of(of_meshes),
            deposited: BuildStamp::of(Parts::CASTERS.and(of_place)),
        })
    }

    /// Returns the bindings of a look-up.
    pub fn buffers(&self) -> GridBuffers<'_> {
        let bits = &self.bits;
        let (media, media_bits) = self.casters.media().map_or((bits, bits), |media| (&media.voxels, &media.bits));
        let (mut cells, mut masks) = (bits, bits);
        match &self.meshes {
            MeshVoxels::Bits(Voxelize::Listed(lists)) => cells = &lists.words,
            MeshVoxels::Counts(_, counted) => cells = &counted.counts,
            MeshVoxels::Masks(_, masked) => masks = &masked.words,
            MeshVoxels::Nothing | MeshVoxels::Bits(_) => {}
        }
        GridBuffers { data: &self.data, bits, media, media_bits, cells, masks }
    }

    /// Returns the bits and the lists of casters, in a grid that lists them.
    pub fn cast_buffers(&self) -> [&Buffer; 2] {
        self.casters.lists().map_or([&self.bits; 2], |cast| [&cast.bits, &cast.lists.words])
    }

    /// Returns whether the grid stores smoke and hair.
    pub fn has_media(&self) -> bool {
        self.casters.media().is_some()
    }

    /// Returns the number of bytes that a look-up needs.
    pub fn resident_bytes(&self) -> u64 {
        self.data.bytes() + self.bits.bytes() + self.meshes.resident_bytes() + self.casters.resident_bytes()
    }

    /// Returns the number of bytes that only a build needs.
    pub fn transient_bytes(&self) -> u64 {
        self.large.bytes() + self.meshes.transient_bytes() + self.casters.transient_bytes()
    }

    /// Reads back the grid's placement, after a build.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if it cannot be read back.
    pub fn data(&self) -> Result<GridData> {
        Ok(self.data.read(1)?[0])
    }

    /// Reads back the bits of all levels, after a build.
    ///
    /// # Errors
    /// Same as [`Grid::data`].
    pub fn bits(&self) -> Result<Vec<u64>> {
        self.bits.read(grid_words(self.size) as usize)
    }

    /// Reads back the optical depth of smoke and hair per voxel, brick by brick, and one bit per voxel that is set if the voxel has any,
    /// after a build. `None` if the world cannot have smoke or hair.
    ///
    /// # Errors
    /// Same as [`Grid::data`].
    pub fn media(&self) -> Result<Option<(Vec<u32>, Vec<u64>)>> {
        let Some(media) = self.casters.media() else { return Ok(None) };
        Ok(Some((media.voxels.read(self.size.pow(3) as usize)?, media.bits.read(grid_words(self.size) as usize)?)))
    }

    /// Reads back the directions of the strands in each voxel, in the layout of glsl/grid/directions.glsl, after a build; empty if the grid
    /// does not store directions.
    ///
    /// # Errors
    /// Same as [`Grid::data`].
    pub fn directions(&self) -> Result<Vec<i32>> {
        let directions = self.casters.media().and_then(Media::directions);
        directions.map_or(Ok(Vec::new()), |words| words.read(6 * self.size.pow(3) as usize))
    }

    /// Returns two buffers: the directions of strands in each voxel, and the greatest optical depth of any voxel. If the grid lacks one of
    /// them, the buffer of bits takes its place, since the shader's binding must not be empty.
    pub fn direction_buffers(&self) -> [&Buffer; 2] {
        let media = self.casters.media();
        [media.and_then(Media::directions), media.and_then(Media::most)].map(|held| held.unwrap_or(&self.bits))
    }

    /// Reads back the number of occupied voxels in each cell, after a build: first the cells of 8 voxels per side, then those of 16, and so
    /// on; empty in a grid without cell counts.
    ///
    /// # Errors
    /// Same as [`Grid::data`].
    pub fn cells(&self) -> Result<Vec<u32>> {
        self.meshes.cells().map_or(Ok(Vec::new()), |cells| cells.counts.read(cells::count(self.size) as usize))
    }

    /// Reads back the lists of triangles, in the layout of glsl/grid/lists/place.glsl, after a build; empty in a grid without lists.
    ///
    /// # Errors
    /// Same as [`Grid::data`].
    pub fn listed(&self) -> Result<Vec<u32>> {
        self.meshes.lists().map_or(Ok(Vec::new()), Lists::read)
    }

    /// Reads back the bits of the voxels overlapped by casters, and the lists of casters, after a build. These lists have the same layout
    /// as the lists of triangles. Empty in a grid without lists.
    ///
    /// # Errors
    /// Same as [`Grid::data`].
    pub fn listed_casters(&self) -> Result<(Vec<u64>, Vec<u32>)> {
        let Some(cast) = self.casters.lists() else { return Ok(Default::default()) };
        Ok((cast.bits.read(grid_words(self.size) as usize)?, cast.lists.read()?))
    }

    /// Returns the totals of the lists of casters, after a build.
    pub fn cast_totals(&self) -> Option<ListTotals> {
        self.casters.lists().map(|cast| cast.lists.last)
    }

    /// Returns the totals of the lists of triangles, after a build.
    pub fn list_totals(&self) -> Option<ListTotals> {
        self.meshes.lists().map(|lists| lists.last)
    }

    /// Reads back the masks, after a build: first, per brick, the number of occupied voxels before it; then the masks of the occupied
    /// voxels, two words each. Empty in a grid without masks.
    ///
    /// # Errors
    /// Same as [`Grid::data`].
    pub fn masks(&self) -> Result<Vec<u32>> {
        self.meshes.masks().map_or(Ok(Vec::new()), Masks::read)
    }

    /// Reads the counts of the completed frame `frame`. Returns whether buffers of lists or masks have grown, so that the build has to be
    /// recorded again.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] if the device cannot bind a buffer with that many masks, [`crate::Error::Gpu`] if memory runs out.
    pub fn settle(&mut self, frame: u64) -> Result<bool> {
        let mut grew = self.meshes.settle(frame)?;
        if let CasterVoxels::Lists(cast) = &mut self.casters {
            grew |= cast.lists.settle(frame)?;
        }
        if grew {
            self.voxelized.forget();
        }
        if grew && self.casters.lists().is_some() {
            self.deposited.forget();
        }
        Ok(grew)
    }

    /// Records the passes that fill the grid with the current casters. The voxels of meshes are rebuilt if the meshes or the grid's
    /// placement have changed, and the voxels of smoke and hair if the smoke, the hair or the grid's placement have changed. Smoke that
    /// moves without changing the box around all casters leaves the meshes' voxels as they are.
    pub fn record(&mut self, commands: &mut Commands, world: &World) {
        if self.voxelized.make(world) {
            self.clear(commands);
            self.place(commands, world);
            self.meshes.record(commands, world, self.size, &self.large);
        }
        match &self.casters {
            CasterVoxels::Media(media) if self.deposited.make(world) => {
                media.clear(commands);
                media.deposit(commands, world);
            }
            CasterVoxels::Lists(cast) if self.deposited.make(world) => cast.record(commands, world),
            _ => {}
        }
    }

    /// Makes the next recording fill the whole grid, even if nothing has changed.
    pub fn forget(&mut self) {
        self.voxelized.forget();
        self.deposited.forget();
    }

    /// Empties the grid and resets the casters' bounds; only words that are not 0 are set to 0.
    fn clear(&self, commands: &mut Commands) {
        let unknown = GridData { size: self.size, low: [u32::MAX; 3], ..GridData::zeroed() };
        let start = if let Place::Given(place) = self.place { place } else { unknown };
        let [x, y] = groups(u64::from(side(self.size, 1).pow(3)));
        let top = u64::from(side(self.size, 2).pow(3));
        commands.pass("grid.clear", |pass| {
            pass.update(&self.data, &[start]);
            pass.fill_part(&self.large, 0, LISTS_BYTES, 0);
        });
        commands.pass("grid.clear", |pass| {
            pass.dispatch(&self.clear, &GridPush::zeroed(), [x, y, 1]);
        });
        commands.pass("grid.clear", |pass| {
            pass.fill_part(&self.bits, self.bits.bytes() - 8 * top, 8 * top, 0);
        });
    }

    /// Fits the grid to all casters, unless its placement is given.
    fn place(&self, commands: &mut Commands, world: &World) {
        let Place::Fitted { voxels, bounds, fit } = &self.place else { return };
        let is_of_meshes = !matches!(self.meshes, MeshVoxels::Nothing);
        let triangle_count = if is_of_meshes { world.triangle_count() } else { 0 };
        let caster_count = world.caster_count();
        let bounds_groups = triangle_count.max(caster_count).div_ceil(THREADS).clamp(1, BOUNDS_GROUPS);
        let threads = THREADS * bounds_groups;
        let push = GridPush { triangle_count, caster_count, threads, fitted: *voxels, ..GridPush::zeroed() };
        commands.pass("grid.bounds", |pass| pass.dispatch(bounds, &push, [bounds_groups, 1, 1]));
        commands.pass("grid.fit", |pass| pass.dispatch(fit, &push, [1, 1, 1]));
    }
}
