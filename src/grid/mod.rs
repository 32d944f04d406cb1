//! Code shared by techniques that work in the world's space: the grid of voxels that meshes occupy and smoke and hair
//! fill, rebuilt where the world moves. It belongs to the world, not to a light: it costs the same for one light and
//! for a thousand.

mod cells;
mod content;
mod lists;
mod masks;
mod media;
mod placement;
mod voxelize;

pub use self::content::Refinement;
pub use self::lists::{ListTotals, caster_share};
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

/// Threads of every pass.
const THREADS: u32 = 64;

/// Workgroups that find the bounds of meshes, smoke and hair.
const BOUNDS_GROUPS: u32 = 512;

/// Workgroups that share the triangles that meet many voxels.
const LARGE_GROUPS: u32 = 1024;

/// Bytes of the two counts in front of a list of those triangles or casters that meet many voxels: how many of them one workgroup handles
/// each, and how many all workgroups handle together.
const LISTS_BYTES: u64 = 8;

/// The place of a grid. Twin: Grid in glsl/grid/grid.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GridData {
    /// Its corner, world units.
    pub origin: [f32; 3],
    /// A voxel's side, world units.
    pub voxel: f32,
    /// Voxels per world unit.
    pub per_unit: f32,
    /// Voxels per side.
    pub size: u32,
    /// The low corner of the box about all casters, world units, as whole numbers that have the order of the floats.
    pub low: [u32; 3],
    /// The high corner of that box, likewise.
    pub high: [u32; 3],
}

/// Words of 64 bits per side of a level, with a bit per voxel, per brick of 4³ voxels, or per block of 16³.
const fn side(size: u32, level: u32) -> u32 {
    size >> (2 * level + 2)
}

/// Voxels per side of a grid that has `fitted` of them along the longest side of the box about all casters: a power of two, and whole blocks
/// of the highest level. What is more than `fitted` stays empty. Twin: reference::twin::grid::Place::about.
pub fn voxels_per_side(fitted: u32) -> u32 {
    fitted.next_power_of_two().max(1 << (2 * GRID_LEVELS))
}

/// Levels of bits.
pub const GRID_LEVELS: u32 = 3;

/// Words of 64 bits of all levels.
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

/// A grid of voxels, and the passes that fill it. Sources: Schwarz and Seidel 2010 (voxels that meet a triangle); levels and clearing are
/// ours.
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

/// Where a grid is.
enum Place {
    /// About all casters, with `voxels` voxels along the longest side of the box about them.
    Fitted { voxels: u32, bounds: Kernel<GridPush>, fit: Kernel<GridPush> },
    /// Where the caller says.
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

/// What a new grid is to have of smoke and hair: see [`CasterVoxels`].
#[derive(Clone, Copy)]
enum CasterPlan {
    Nothing,
    Media(MediaContent),
    Lists,
}

/// Where a new grid is to be: see [`Place`].
#[derive(Clone, Copy)]
enum PlacePlan {
    Fitted(u32),
    Given(GridData),
}

/// Bindings of a look-up. Where the grid lacks a buffer, its bits are bound instead.
#[derive(Clone, Copy)]
pub struct GridBuffers<'a> {
    /// [`GridData`].
    pub data: &'a Buffer,
    /// A bit per voxel, set where a mesh meets the voxel, and the bits of the levels above.
    pub bits: &'a Buffer,
    /// Optical depth of each voxel's smoke and hair.
    pub media: &'a Buffer,
    /// A bit per voxel, set where the voxel has smoke or hair, and the bits of the levels above.
    pub media_bits: &'a Buffer,
    /// The counts of cells for cones, or the lists of triangles in a grid that has them.
    pub cells: &'a Buffer,
    /// The masks of occupied voxels.
    pub masks: &'a Buffer,
}

impl Grid {
    /// A grid of `size` voxels per side, a power of two from 64 to 512, about all casters of `world`.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] where there is smoke or hair and the device binds no buffer with one number per voxel,
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, world: &World, size: u32, voxelizer: Voxelizer, finer: Refinement) -> Result<Self> {
        let has_casters = world.caster_capacity() > 0;
        let casters = if has_casters { CasterPlan::Media(MediaContent::default()) } else { CasterPlan::Nothing };
        Self::planned(context, world, PlacePlan::Fitted(size), Some((voxelizer, finer)), casters)
    }

    /// A grid that lists the triangles and the casters of each voxel.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn listing(context: &Context, world: &World, size: u32) -> Result<Self> {
        let meshes = Some((Voxelizer::Listed, Refinement::Nothing));
        Self::planned(context, world, PlacePlan::Fitted(size), meshes, CasterPlan::Lists)
    }

    /// A grid of smoke and hair alone, with the data that `holds` names, and `fitted` voxels along the longest side of the box about these
    /// ([`voxels_per_side`]).
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn of_media(context: &Context, world: &World, fitted: u32, holds: MediaContent) -> Result<Self> {
        Self::planned(context, world, PlacePlan::Fitted(fitted), None, CasterPlan::Media(holds))
    }

    /// A grid of the meshes alone, at `place`. All meshes must lie inside it, at least a voxel from its sides.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn of_meshes(context: &Context, world: &World, place: GridData) -> Result<Self> {
        let meshes = Some((Voxelizer::Compute, Refinement::Nothing));
        Self::planned(context, world, PlacePlan::Given(place), meshes, CasterPlan::Nothing)
    }

    /// `meshes`: none for a grid without meshes.
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

    /// Bindings of a look-up.
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

    /// The bits and the lists of casters, in a grid that lists them.
    pub fn cast_buffers(&self) -> [&Buffer; 2] {
        self.casters.lists().map_or([&self.bits; 2], |cast| [&cast.bits, &cast.lists.words])
    }

    /// Whether the world may have smoke or hair.
    pub fn has_media(&self) -> bool {
        self.casters.media().is_some()
    }

    /// Bytes that a look-up needs.
    pub fn resident_bytes(&self) -> u64 {
        self.data.bytes() + self.bits.bytes() + self.meshes.resident_bytes() + self.casters.resident_bytes()
    }

    /// Bytes that only a build needs.
    pub fn transient_bytes(&self) -> u64 {
        self.large.bytes() + self.meshes.transient_bytes() + self.casters.transient_bytes()
    }

    /// The grid's place, after a build.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where it cannot be read back.
    pub fn data(&self) -> Result<GridData> {
        Ok(self.data.read(1)?[0])
    }

    /// The bits of all levels, after a build.
    ///
    /// # Errors
    /// As [`Grid::data`].
    pub fn bits(&self) -> Result<Vec<u64>> {
        self.bits.read(grid_words(self.size) as usize)
    }

    /// The optical depth of smoke and hair per voxel, brick by brick, and one bit per voxel that says whether it has any, after a build.
    /// `None` where the world may have neither smoke nor hair.
    ///
    /// # Errors
    /// As [`Grid::data`].
    pub fn media(&self) -> Result<Option<(Vec<u32>, Vec<u64>)>> {
        let Some(media) = self.casters.media() else { return Ok(None) };
        Ok(Some((media.voxels.read(self.size.pow(3) as usize)?, media.bits.read(grid_words(self.size) as usize)?)))
    }

    /// The directions of the strands in each voxel, in the layout of glsl/grid/directions.glsl, after a build; empty where the grid does
    /// not hold directions.
    ///
    /// # Errors
    /// As [`Grid::data`].
    pub fn directions(&self) -> Result<Vec<i32>> {
        let directions = self.casters.media().and_then(Media::directions);
        directions.map_or(Ok(Vec::new()), |words| words.read(6 * self.size.pow(3) as usize))
    }

    /// Two buffers: the directions of strands in each voxel, and the greatest optical depth of any voxel. Where the grid lacks one of them,
    /// the buffer of bits stands in its place, since a shader needs something bound there.
    pub fn direction_buffers(&self) -> [&Buffer; 2] {
        let media = self.casters.media();
        [media.and_then(Media::directions), media.and_then(Media::most)].map(|held| held.unwrap_or(&self.bits))
    }

    /// How many occupied voxels each cell has, after a build: first the cells of 8 voxels per side, then those of 16, and so on; empty in a
    /// grid without cones.
    ///
    /// # Errors
    /// As [`Grid::data`].
    pub fn cells(&self) -> Result<Vec<u32>> {
        self.meshes.cells().map_or(Ok(Vec::new()), |cells| cells.counts.read(cells::count(self.size) as usize))
    }

    /// The lists of triangles, in the layout of glsl/grid/lists/place.glsl, after a build; nothing in a grid without
    /// lists.
    ///
    /// # Errors
    /// As [`Grid::data`].
    pub fn listed(&self) -> Result<Vec<u32>> {
        self.meshes.lists().map_or(Ok(Vec::new()), Lists::read)
    }

    /// The bits of the voxels that casters meet, and the lists of casters, after a build. The lists have the layout of the lists of
    /// triangles. Empty in a grid without lists.
    ///
    /// # Errors
    /// As [`Grid::data`].
    pub fn listed_casters(&self) -> Result<(Vec<u64>, Vec<u32>)> {
        let Some(cast) = self.casters.lists() else { return Ok(Default::default()) };
        Ok((cast.bits.read(grid_words(self.size) as usize)?, cast.lists.read()?))
    }

    /// Totals of the lists of casters, after a build.
    pub fn cast_totals(&self) -> Option<ListTotals> {
        self.casters.lists().map(|cast| cast.lists.last)
    }

    /// Totals of the lists of triangles, after a build.
    pub fn list_totals(&self) -> Option<ListTotals> {
        self.meshes.lists().map(|lists| lists.last)
    }

    /// After a build: first, per brick, how many occupied voxels come before it; then the masks of the occupied voxels, two words each.
    /// Empty in a grid without masks.
    ///
    /// # Errors
    /// As [`Grid::data`].
    pub fn masks(&self) -> Result<Vec<u32>> {
        self.meshes.masks().map_or(Ok(Vec::new()), Masks::read)
    }

    /// Reads frame `frame`'s counts, after the frame is over. Returns whether buffers of lists or masks have grown, so
    /// that the build has to be recorded again.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] where the device binds no buffer of so many masks, [`crate::Error::Gpu`] where memory runs out.
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

    /// Records the passes that fill the grid with the present casters. The voxels of meshes are made anew if the meshes or the grid's place
    /// have changed; those of smoke and hair if the smoke, the hair or the grid's place have. Smoke that moves without changing the box
    /// about all casters leaves the meshes' voxels as they are.
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

    /// Makes the next recording fill the whole grid, whatever has changed.
    pub fn forget(&mut self) {
        self.voxelized.forget();
        self.deposited.forget();
    }

    /// Empties the grid and forgets the casters' bounds; only words that are not 0 are set to 0.
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

    /// Fits the grid to all casters, unless its place is given.
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
