//! Rays against the meshes themselves: exact, where the device has ray queries. Source: VK_KHR_ray_query.
//!
//! A ray a point: exact, where the device has ray queries.
//!
//! ```
//! # mod example { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/example.rs")); }
//! # use example::{on_a_device, solid};
//! # on_a_device(|context| {
//! use gobo::consume::Query;
//! use gobo::technique::{open, parse};
//! use gobo::world::World;
//!
//! let world = World::new(context, &solid())?;
//! let mut rays = open(context, &world, &parse("ray-query", &[])?[0])?;
//! rays.build(&world)?;
//! // Above the box and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&rays.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above == 1.0 && below == 0.0);
//! # Ok(()) });
//! ```

use super::{Answer, Casts, Entry, Facts, Lifetime, Path, Promises, Runs, Technique};
use crate::Result;
use crate::gpu::{AccelerationStructure, Bindings, Buffer, Commands, Constants, Context, Memory, Requirement};
use crate::maps::Map;
use crate::shaders::folder;
use crate::shaders::set;
use crate::world::{Parts, TriangleData, World};

/// There is nothing to set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Settings;

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "ray-query",
    about: "a ray from the point to the light, against the meshes themselves: exact (VK_KHR_ray_query)",
    casts: Casts { particles: false, strands: false, meshes: true },
    lifetime: Lifetime::Frame,
    keys: &[],
    paths: &[Path { name: TRACE, requires: &[Requirement::RayQuery] }],
    promises: |_, _| Promises::OF_OPAQUE,
    runs: Runs { many_lights: &["shading=tiled"], stress_meshes: &[""], ..Runs::NONE },
    open: |context, world, _| Ok(Box::new(RayQuery::new(context, world, &Settings)?)),
};

const TRACE: &str = "trace";

/// The technique, opened for one world.
pub struct RayQuery {
    /// Three corners a triangle, past the albedo that stands behind them.
    indices: Buffer,
    /// Over the triangles.
    bottom: AccelerationStructure,
    /// What rays are asked of: one instance.
    top: AccelerationStructure,
    /// The largest coordinate of the meshes.
    extent: Buffer,
    look_up: Bindings,
    constants: Constants,
}

impl RayQuery {
    /// Opens it.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] where the device has no ray queries or the host knows no box about the triangles,
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, world: &World, _: &Settings) -> Result<Self> {
        ENTRY.require(context, TRACE)?;
        let count = world.triangle_capacity();
        extent(world)?;
        let all: Vec<u32> = (0..count).flat_map(corners).collect();
        let indices = Buffer::with_data(context, "ray_query.indices", &all)?;
        let bottom = AccelerationStructure::bottom(context, "ray_query.bottom", &world.triangles, &indices, count)?;
        let top = AccelerationStructure::top(context, "ray_query.top", &bottom)?;
        let extent = Buffer::new(context, "ray_query.extent", size_of::<f32>() as u64, Memory::Device)?;
        let look_up =
            set::RayQueryLookUp { lights: &world.lights, meshes: &top, triangles: &world.triangles, extent: &extent };
        let look_up = look_up.bind(context, "ray_query.look_up")?;
        Ok(Self { indices, bottom, top, extent, look_up, constants: Constants::new() })
    }

    fn bottom(&self, commands: &mut Commands) {
        commands.pass("ray_query.bottom", |pass| pass.build(&self.bottom));
    }

    fn top(&self, commands: &mut Commands, world: &World) -> Result<()> {
        let extent = extent(world)?;
        commands.pass("ray_query.top", |pass| {
            pass.build(&self.top);
            pass.update(&self.extent, &[extent]);
        });
        Ok(())
    }
}

/// A triangle's corners among the triples of floats that [`TriangleData`] is made of.
fn corners(triangle: u32) -> [u32; 3] {
    const TRIPLES: u32 = (size_of::<TriangleData>() / size_of::<[f32; 3]>()) as u32;
    [0, 1, 2].map(|corner| triangle * TRIPLES + corner)
}

/// The largest coordinate of the meshes, either sign.
fn extent(world: &World) -> Result<f32> {
    Ok(world.mesh_hull()?.flatten().fold(0.0, |extent: f32, c| extent.max(c.abs())))
}

impl Technique for RayQuery {
    fn made_of(&self) -> Parts {
        Parts::MESHES
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.bottom(commands);
        self.top(commands, world)
    }

    fn answer(&self) -> Answer<'_> {
        Answer { folder: folder::RAY_QUERY, bindings: &self.look_up, constants: &self.constants }
    }

    fn maps(&self) -> &[Map] {
        &[]
    }

    fn facts(&self) -> Result<Facts> {
        Ok(Facts {
            path: TRACE,
            reason: "the only path".into(),
            bytes_resident: self.bottom.bytes() + self.top.bytes(),
            bytes_transient: self.bottom.scratch_bytes() + self.top.scratch_bytes() + self.indices.bytes(),
            ..Facts::default()
        })
    }
}
