//! Rays against the meshes themselves, and against boxes around smoke and hair; a ray adds up the casters whose boxes it hits. Exact, but
//! requires ray queries. Source: VK_KHR_ray_query.
//!
//! One ray per point is traced against meshes, and one against smoke and hair. With [`Hits::Random`], the second ray ends at a caster that
//! it hits with the probability that the caster absorbs the light: unbiased but noisy.
//!
//! ```
//! # mod example { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/example.rs")); }
//! # use example::{on_a_device, solid};
//! # on_a_device(|context| {
//! use gobo::query::Query;
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

use super::keys::words;
use super::settings::{Keyed, Setting, settings};
use super::{Answer, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Spec, Technique};
use crate::Result;
use crate::gpu::{
    AccelerationStructure, BOX_BYTES, Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, Requirement,
    groups, push_struct,
};
use crate::shaders::constant::{HITS_RANDOM, MEDIA};
use crate::shaders::{folder, ray_query as shaders, set};
use crate::world::{BuildStamp, Parts, TriangleData, World};

words! {
    /// What a ray does when it hits a caster.
    pub enum Hits {
        /// It adds up the absorption of all casters: exact.
        All = "all",
        /// It ends at a caster with the probability that the caster absorbs the light: a result is 0 or 1, and right on average.
        Random = "random",
    }
}

settings! {
    /// Settings of the technique.
    #[derive(Copy)]
    pub struct Settings {
        /// What a ray does when it hits smoke or hair.
        hits: Hits = Setting::word(
            "all", "where a ray meets smoke or hair it adds up what all of it takes; or ends there by chance: no bias, and noise");
    }
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "ray-query",
    about: "rays from the point to the light, against meshes, smoke and hair themselves: exact (VK_KHR_ray_query)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: TRACE, requires: &[Requirement::RayQuery] }],
    plan: |spec, path| PathPlan { path, limits: Vec::new(), promises: promises(spec) },
    runs: Runs {
        usual: &[""],
        usual_on_cpu: &[""],
        compare: &[""],
        many_lights: &["shading=tiled"],
        stress_smoke: &["", "hits=random"],
        stress_meshes: &[""],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(RayQuery::new(context, world, &spec.settings())?)),
};

const TRACE: &str = "trace";

/// Results are promised up to rounding, since the order in which a ray hits casters and adds them up depends on the device. With
/// hits=random, the end of a ray depends on chance and on the indices of casters, so a single result is promised only for the shadows of
/// meshes.
fn promises(spec: &Spec) -> Promises {
    if spec.settings::<Settings>().hits == Hits::Random {
        return Promises { order: None, ..Promises::OF_OPAQUE };
    }
    Promises::EXACT
}

/// Threads per workgroup.
const THREADS: u32 = 64;

push_struct! {
    /// Twin: BoxesPush in glsl/technique/ray_query/boxes.comp.
    struct BoxesPush {
        caster_count: u32,
        /// Total number of boxes; all but the first `caster_count` are empty.
        box_count: u32,
    }
}

/// Boxes around smoke and hair, and the acceleration structures over them.
struct Cast {
    boxes: Buffer,
    count: u32,
    find: Kernel<BoxesPush>,
    /// Structure over the boxes.
    bottom: AccelerationStructure,
    top: AccelerationStructure,
    built: BuildStamp,
}

impl Cast {
    fn new(context: &Context, world: &World) -> Result<Self> {
        world.one_color("a box keeps")?;
        let count = world.caster_capacity();
        let boxes = Buffer::new(context, "ray_query.boxes", BOX_BYTES * u64::from(count), Memory::Device)?;
        let set = set::RayQueryBoxes { casters: &world.casters, boxes: &boxes }.bind(context, "ray_query.boxes")?;
        let find = Kernel::compute(context, &shaders::BOXES, &[&set], &Constants::new())?;
        let bottom = AccelerationStructure::boxes(context, "ray_query.bottom", &boxes, count)?;
        let top = AccelerationStructure::top(context, "ray_query.top", &bottom)?;
        Ok(Self { boxes, count, find, bottom, top, built: BuildStamp::of(Parts::CASTERS) })
    }

    fn boxes(&self, commands: &mut Commands, world: &World) {
        let [x, y] = groups(u64::from(self.count.div_ceil(THREADS)));
        let push = BoxesPush { caster_count: world.caster_count(), box_count: self.count };
        commands.pass("ray_query.boxes", |pass| pass.dispatch(&self.find, &push, [x, y, 1]));
        commands.pass("ray_query.boxes.bottom", |pass| pass.build(&self.bottom));
        commands.pass("ray_query.boxes.top", |pass| pass.build(&self.top));
    }
}

/// The technique, opened for one world.
pub struct RayQuery {
    /// Three corner indices per triangle; they skip the albedo, which is stored after the corners of each triangle.
    indices: Buffer,
    /// Structure over the triangles.
    bottom: AccelerationStructure,
    /// Structure in which rays are traced: one instance of `bottom`.
    top: AccelerationStructure,
    /// Largest absolute value of a coordinate of the meshes.
    extent: Buffer,
    /// Present if the world may have smoke or hair.
    cast: Option<Cast>,
    built: BuildStamp,
    look_up: Bindings,
    constants: Constants,
}

impl RayQuery {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] if the device has no ray queries or the host does not know a bounding box of the triangles,
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        ENTRY.require(context, TRACE)?;
        // Even without triangles, there must be a structure to bind, in which no ray is traced.
        let count = world.triangle_capacity().max(1);
        extent(world)?;
        let all: Vec<u32> = (0..count).flat_map(corners).collect();
        let indices = Buffer::with_data(context, "ray_query.indices", &all)?;
        let bottom = AccelerationStructure::bottom(context, "ray_query.bottom", &world.triangles, &indices, count)?;
        let top = AccelerationStructure::top(context, "ray_query.top", &bottom)?;
        let extent = Buffer::new(context, "ray_query.extent", size_of::<f32>() as u64, Memory::Device)?;
        let cast = if world.caster_capacity() > 0 { Some(Cast::new(context, world)?) } else { None };
        let look_up = set::RayQueryLookUp {
            lights: &world.lights,
            meshes: &top,
            triangles: &world.triangles,
            extent: &extent,
            boxes: cast.as_ref().map_or(&top, |cast| &cast.top),
            casters: &world.casters,
        };
        let look_up = look_up.bind(context, "ray_query.look_up")?;
        let constants = world.constants().set(MEDIA, cast.is_some()).set(HITS_RANDOM, settings.hits == Hits::Random);
        let built = BuildStamp::of(Parts::MESHES);
        Ok(Self { indices, bottom, top, extent, cast, built, look_up, constants })
    }

    /// After a build, returns the low and high corners of the boxes around all casters. The box of a caster that casts nothing begins at
    /// NaN.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read back.
    pub fn boxes(&self) -> Result<Vec<[[f32; 3]; 2]>> {
        self.cast.as_ref().map_or(Ok(Vec::new()), |cast| cast.boxes.read(cast.count as usize))
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

/// Returns the indices of a triangle's corners, counted in the triples of floats that make up [`TriangleData`].
fn corners(triangle: u32) -> [u32; 3] {
    const TRIPLES: u32 = (size_of::<TriangleData>() / size_of::<[f32; 3]>()) as u32;
    [0, 1, 2].map(|corner| triangle * TRIPLES + corner)
}

/// Returns the largest absolute value of a coordinate of the meshes.
fn extent(world: &World) -> Result<f32> {
    Ok(world.mesh_hull()?.flatten().fold(0.0, |extent: f32, c| extent.max(c.abs())))
}

impl Technique for RayQuery {
    fn made_of(&self) -> Parts {
        Parts::MESHES.and(Parts::CASTERS)
    }

    fn forget(&mut self) {
        self.built.forget();
        self.cast.iter_mut().for_each(|cast| cast.built.forget());
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        if let Some(cast) = &mut self.cast
            && cast.built.make(world)
        {
            cast.boxes(commands, world);
        }
        if self.built.make(world) {
            self.bottom(commands);
            self.top(commands, world)?;
        }
        Ok(())
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::RAY_QUERY, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for RayQuery {
    fn facts(&self) -> Result<Facts> {
        let of_casters = || self.cast.iter().flat_map(|cast| [&cast.bottom, &cast.top]);
        let structures = || [&self.bottom, &self.top].into_iter().chain(of_casters());
        let inputs = self.indices.bytes() + self.cast.as_ref().map_or(0, |cast| cast.boxes.bytes());
        Ok(Facts {
            path: TRACE,
            reason: "the only path".into(),
            bytes_resident: structures().map(AccelerationStructure::bytes).sum(),
            bytes_transient: structures().map(AccelerationStructure::scratch_bytes).sum::<u64>() + inputs,
            ..Facts::default()
        })
    }
}
