//! What techniques share that stands in the world's space: the grid of voxels that meshes occupy, made anew each frame. It is
//! the world's, not a light's: it costs the same for one light and for a thousand.

use crate::Result;
use crate::gpu::{
    Bindings, Buffer, Commands, Constants, Context, Draw, Graphics, Kernel, Memory, Resource, groups, push_struct,
};
use crate::shaders::constant::CONSERVATIVE;
use crate::shaders::grid as shaders;
use crate::world::World;
use bytemuck::{Pod, Zeroable};

/// Threads of every pass.
const THREADS: u32 = 64;

/// Workgroups that share the meshes' corners.
const BOUNDS_GROUPS: u32 = 512;

/// Workgroups that share the triangles that meet many voxels.
const LARGE_GROUPS: u32 = 1024;

/// Where a grid stands. Twin: Grid in glsl/grid/grid.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GridData {
    /// Its corner, world units.
    pub origin: [f32; 3],
    /// A voxel's side, world units.
    pub voxel: f32,
    /// Voxels a world unit.
    pub per_unit: f32,
    /// Voxels a side.
    pub size: u32,
    /// Where the meshes begin along each axis, as whole numbers that order as floats do.
    pub low: [u32; 3],
    /// Where they end.
    pub high: [u32; 3],
}

/// Words of 64 bits a side of a level: of one voxel a bit, of bricks of 4³ voxels, of blocks of 16³.
const fn side(size: u32, level: u32) -> u32 {
    size >> (2 * level + 2)
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
        threads: u32,
    }
}

/// How the voxels are found that a triangle meets. All find the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Voxelizer {
    /// Compute passes go through triangles' boxes.
    Compute,
    /// Triangles are drawn along the axis that they face most, and fragments go through columns.
    Raster {
        /// By [`crate::gpu::Features::conservative_rasterization`], or as wider triangles.
        conservative: bool,
    },
}

/// Its passes.
enum Voxelize {
    Compute([Kernel<GridPush>; 3]),
    Raster(Kernel<GridPush>),
}

impl Voxelize {
    fn new(context: &Context, voxelizer: Voxelizer, set: &Bindings) -> Result<Self> {
        let kernel = |shader| Kernel::compute(context, shader, &[set], &Constants::new());
        Ok(match voxelizer {
            Voxelizer::Compute => Self::Compute([
                kernel(&shaders::VOXELIZE_STEP_0)?,
                kernel(&shaders::VOXELIZE_STEP_1)?,
                kernel(&shaders::VOXELIZE_STEP_2)?,
            ]),
            Voxelizer::Raster { conservative } => {
                let (vertex, fragment) = (&shaders::VOXELIZE_VERT, &shaders::VOXELIZE_FRAG);
                let state = Graphics { vertex, fragment, colors: &[], depth: None };
                let constants = Constants::new().set(CONSERVATIVE, conservative);
                let make = if conservative { Kernel::touching } else { Kernel::graphics };
                Self::Raster(make(context, &state, &[set], &constants)?)
            }
        })
    }
}

/// A grid of voxels, and the passes that fill it. Sources: Schwarz and Seidel 2010 (which voxels a triangle meets); levels and
/// clearing are ours.
pub struct Grid {
    size: u32,
    data: Buffer,
    bits: Buffer,
    large: Buffer,
    bounds: Kernel<GridPush>,
    fit: Kernel<GridPush>,
    clear: Kernel<GridPush>,
    voxelize: Voxelize,
    /// Whether anybody has written the bits yet.
    is_written: bool,
}

impl Grid {
    /// A grid of `size` voxels a side, a power of two from 64 to 512, about the meshes of `world`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, world: &World, size: u32, voxelizer: Voxelizer) -> Result<Self> {
        let data = Buffer::new(context, "grid.data", size_of::<GridData>() as u64, Memory::Device)?;
        let bits = Buffer::new(context, "grid.bits", 8 * u64::from(grid_words(size)), Memory::Device)?;
        let listed = 8 + 4 * u64::from(world.triangle_count().max(1));
        let large = Buffer::new(context, "grid.large", listed, Memory::Device)?;
        let resources = [&data, &bits, &world.triangles, &large].map(|buffer| Resource::Buffer(buffer.clone()));
        let set = Bindings::new(context, "grid", &resources)?;
        let constants = Constants::new();
        let kernel = |shader| Kernel::compute(context, shader, &[&set], &constants);
        Ok(Self {
            size,
            data,
            bits,
            large,
            bounds: kernel(&shaders::BOUNDS)?,
            fit: kernel(&shaders::FIT)?,
            clear: kernel(&shaders::CLEAR)?,
            voxelize: Voxelize::new(context, voxelizer, &set)?,
            is_written: false,
        })
    }

    /// What a look-up is bound: where the grid stands, and its bits.
    pub fn buffers(&self) -> [&Buffer; 2] {
        [&self.data, &self.bits]
    }

    /// Of all that only a build needs.
    pub fn transient_bytes(&self) -> u64 {
        self.large.bytes()
    }

    /// Where it stands, after a build.
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

    /// Records the passes that fill it with the meshes as they are now.
    pub fn record(&mut self, commands: &mut Commands, world: &World) {
        self.begin(commands);
        self.place(commands, world);
        self.voxelize(commands, world);
        self.is_written = true;
    }

    /// Nothing is occupied, and nothing is known of the meshes.
    fn begin(&self, commands: &mut Commands) {
        let start = GridData { size: self.size, low: [u32::MAX; 3], ..GridData::zeroed() };
        commands.pass("grid.clear", |pass| {
            pass.update(&self.data, &[start]);
            pass.fill_part(&self.large, 0, 8, 0);
            if !self.is_written {
                pass.fill(&self.bits, 0);
            }
        });
        if self.is_written {
            let [x, y] = groups(u64::from(side(self.size, 1).pow(3)));
            let top = u64::from(side(self.size, 2).pow(3));
            commands.pass("grid.clear", |pass| {
                pass.dispatch(&self.clear, &GridPush::zeroed(), [x, y, 1]);
            });
            commands.pass("grid.clear", |pass| {
                pass.fill_part(&self.bits, self.bits.bytes() - 8 * top, 8 * top, 0);
            });
        }
    }

    fn place(&self, commands: &mut Commands, world: &World) {
        let triangle_count = world.triangle_count();
        let bounds_groups = triangle_count.div_ceil(THREADS).clamp(1, BOUNDS_GROUPS);
        let push = GridPush { triangle_count, threads: THREADS * bounds_groups };
        commands.pass("grid.bounds", |pass| pass.dispatch(&self.bounds, &push, [bounds_groups, 1, 1]));
        commands.pass("grid.fit", |pass| pass.dispatch(&self.fit, &push, [1, 1, 1]));
    }

    fn voxelize(&self, commands: &mut Commands, world: &World) {
        let triangle_count = world.triangle_count();
        let push = GridPush { triangle_count, threads: 0 };
        let compute = match &self.voxelize {
            Voxelize::Compute(kernels) => kernels,
            Voxelize::Raster(kernel) => {
                return commands.pass("grid.voxelize", |pass| {
                    let draw = |draw: &mut Draw| draw.draw(kernel, &push, 3 * triangle_count, 1);
                    pass.render([self.size; 2], &[], None, draw);
                });
            }
        };
        let [x, y] = groups(u64::from(triangle_count.div_ceil(THREADS)));
        commands.pass("grid.voxelize", |pass| pass.dispatch(&compute[0], &push, [x, y, 1]));
        commands.pass("grid.voxelize", |pass| {
            pass.dispatch(&compute[1], &push, [LARGE_GROUPS, 1, 1]);
            pass.dispatch(&compute[2], &push, [LARGE_GROUPS, 1, 1]);
        });
    }
}
