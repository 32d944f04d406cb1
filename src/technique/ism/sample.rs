//! Points on the meshes, stratified by area.

use crate::Result;
use crate::gpu::{Buffer, Commands, Context, Kernel, Memory, groups, push_struct};
use crate::shaders::set;
use crate::shaders::{constant, ism as shaders};
use crate::world::World;
use bytemuck::{Pod, Zeroable};

/// Number of subsets in the pool of points on the meshes; each has as many points as a light uses. Twin: SUBSETS.
pub const SUBSETS: u32 = 16;

/// Threads per workgroup of every pass, which is also the number of triangles per block. Twin: BLOCK.
const BLOCK: u32 = 128;

/// A point on a mesh. Twin: IsmPoint in glsl/technique/ism/points.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PointData {
    /// Position, in world units.
    pub position: [f32; 3],
    /// Normal in octahedral coordinates of 15 and 16 bits. The lowest bit is set if the mesh is closed and the normal points outwards.
    pub normal: u32,
}

/// Totals over all points. Twin: IsmPoints in glsl/technique/ism/points.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PointsData {
    /// Weight per unit of area, a power of two.
    pub scale: f32,
    /// Total weight of all triangles.
    pub total: u32,
    /// Radius of the disc that a point represents, in world units.
    pub radius: f32,
    /// Area of all triangles, in square world units.
    pub area: f32,
}

push_struct! {
    /// Twin: SamplePush in glsl/technique/ism/sample.glsl.
    struct SamplePush { triangle_count: u32, points: u32 }
}

/// The points, and the passes that generate them.
pub struct Sample {
    points: u32,
    /// [`PointsData`].
    pub head: Buffer,
    /// [`PointData`], subset by subset.
    pub pool: Buffer,
    areas: Buffer,
    sums: Buffer,
    blocks: Buffer,
    kernels: [(&'static str, Kernel<SamplePush>); 5],
}

impl Sample {
    /// Allocates the pool of points on the meshes and creates the passes that fill it. Each light uses `points` of them, a power of two.
    /// With `adaptive`, each light chooses its points, and neighbours in the pool are neighbours on their triangles.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, points: u32, adaptive: bool) -> Result<Self> {
        let triangles = u64::from(world.triangle_capacity().max(1));
        let buffer = |name, bytes| Buffer::new(context, name, bytes, Memory::Device);
        let head = buffer("ism.head", size_of::<PointsData>() as u64)?;
        let areas = buffer("ism.areas", 4 * triangles)?;
        let sums = buffer("ism.sums", 4 * triangles)?;
        let blocks = buffer("ism.blocks", 4 * triangles.div_ceil(BLOCK.into()))?;
        let pool = buffer("ism.pool", u64::from(SUBSETS * points) * size_of::<PointData>() as u64)?;
        let set = set::IsmSample {
            triangles: &world.triangles,
            sides: &world.sides,
            head: &head,
            areas: &areas,
            sums: &sums,
            blocks: &blocks,
            pool: &pool,
        };
        let set = set.bind(context, "ism.sample")?;
        let constants = world.constants().set(constant::ISM_ADAPTIVE, adaptive);
        let kernel = |shader| Kernel::compute(context, shader, &[&set], &constants);
        let kernels = [
            ("ism.areas", kernel(&shaders::AREAS)?),
            ("ism.scale", kernel(&shaders::SCALE)?),
            ("ism.sums", kernel(&shaders::SUMS)?),
            ("ism.offsets", kernel(&shaders::OFFSETS)?),
            ("ism.points", kernel(&shaders::POINTS)?),
        ];
        Ok(Self { points, head, pool, areas, sums, blocks, kernels })
    }

    /// Records the passes that place points on the current meshes.
    pub fn record(&self, commands: &mut Commands, world: &World) {
        let push = SamplePush { triangle_count: world.triangle_count(), points: self.points };
        let blocks = u64::from(push.triangle_count.div_ceil(BLOCK));
        let pool = u64::from(SUBSETS * self.points / BLOCK);
        for ((name, kernel), count) in self.kernels.iter().zip([blocks, 1, blocks, 1, pool]) {
            let [x, y] = groups(count);
            commands.pass(name, |pass| pass.dispatch(kernel, &push, [x, y, 1]));
        }
    }

    /// Returns the number of bytes needed only while building.
    pub fn transient_bytes(&self) -> u64 {
        self.pool.bytes() + self.areas.bytes() + self.sums.bytes() + self.blocks.bytes()
    }
}
