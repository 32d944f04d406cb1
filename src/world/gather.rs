//! The passes that build casters, triangles and lights from the caller's buffers. Twin:
//! [`crate::reference::twin::gather`].

use super::LightData;
use super::source::{Corners, LightAt, NOWHERE, Source, SphereAt, SplatAt, StrandAt, held, words};
use crate::Result;
use crate::gpu::{
    Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, Push, ReadBack, Shader, groups, push_struct,
};
use crate::shaders::set;
use crate::shaders::world as shaders;
use bytemuck::{Pod, Zeroable};

/// Number of threads per workgroup.
pub(super) const THREADS: u32 = 64;

/// Number of kernels kept for buffers that are used again, as in a ring of buffers.
const KEPT: usize = 8;

/// Counts of one pass. Twin: GatherTotals in glsl/world/gather.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct GatherTotals {
    /// Number of elements according to the caller's count.
    pub asked: u32,
    /// Number of elements within the capacity whose position or size is invalid.
    pub refused: u32,
}

/// Counts of elements in the caller's buffers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gathered {
    /// Number of particles, strands, triangles, splats and lights, according to the caller's counts. A count above the capacity shows how
    /// many are too many.
    pub asked: [u32; 5],
    /// Number of elements refused, among those within the capacity. Particles, strands, splats and triangles are refused, and cast nothing,
    /// if a number is not finite, or if they have no size or no vertex. Lights are refused, and are dark, if their numbers violate
    /// [`LightAt`].
    pub refused: [u32; 5],
}

push_struct! {
    /// Twin: CastersPush in glsl/world/gather.comp.
    struct CastersPush {
        first: u32,
        slots: u32,
        most: u32,
        count_at: u32,
        start: u32,
        stride: u32,
        position: u32,
        end: u32,
        radius: u32,
        radius_is: f32,
        density: u32,
        density_is: f32,
    }
}

push_struct! {
    /// Twin: SplatsPush in glsl/world/gather_splats.comp.
    struct SplatsPush {
        first: u32,
        slots: u32,
        most: u32,
        count_at: u32,
        start: u32,
        stride: u32,
        position: u32,
        deviations: u32,
        rotation: u32,
        opacity: u32,
        opacity_is: f32,
    }
}

push_struct! {
    /// Twin: TrianglesPush in glsl/world/gather_triangles.comp.
    struct TrianglesPush {
        slots: u32,
        most: u32,
        count_at: u32,
        start: u32,
        stride: u32,
        vertices: u32,
        indices_at: u32,
        albedo: [f32; 3],
        place: [f32; 3],
    }
}

push_struct! {
    /// Twin: LightsPush in glsl/world/gather_lights.comp.
    struct LightsPush {
        slots: u32,
        most: u32,
        count_at: u32,
        start: u32,
        stride: u32,
        position: u32,
        direction: u32,
        radiance: u32,
        radius: u32,
        radius_is: f32,
        cos_cone: u32,
        cos_cone_is: f32,
    }
}

/// Kernels of one shader, one per combination of the caller's buffers that it reads.
pub(super) struct Kernels<P> {
    shader: &'static Shader,
    constants: Constants,
    all: Vec<(Vec<Buffer>, Kernel<P>)>,
}

impl<P: Push> Kernels<P> {
    pub(super) fn new(shader: &'static Shader) -> Self {
        Self::with(shader, Constants::new())
    }

    pub(super) fn with(shader: &'static Shader, constants: Constants) -> Self {
        Self { shader, constants, all: Vec::new() }
    }

    /// Returns the kernel that reads `theirs`, creating it if necessary; `bind` creates its descriptor set.
    pub(super) fn of(
        &mut self,
        context: &Context,
        theirs: &[&Buffer],
        bind: impl FnOnce() -> Result<Bindings>,
    ) -> Result<Kernel<P>> {
        let same = |kept: &[Buffer]| kept.iter().zip(theirs).all(|(kept, one)| kept.is(one));
        if let Some((_, kernel)) = self.all.iter().find(|(kept, _)| same(kept)) {
            return Ok(kernel.clone());
        }
        let kernel = Kernel::compute(context, self.shader, &[&bind()?], &self.constants)?;
        if self.all.len() == KEPT {
            self.all.remove(0);
        }
        self.all.push((theirs.iter().map(|b| (*b).clone()).collect(), kernel.clone()));
        Ok(kernel)
    }
}

/// The position of casters in the buffer, and how many of them are written.
#[derive(Clone, Copy)]
pub(super) struct Slots {
    pub first: u32,
    pub count: u32,
    /// Capacity, in casters; a higher count is clamped to it.
    pub capacity: u32,
}

/// The counts of one kind of elements. Each kind has its own, so that passes of a submission need not wait for each other.
struct CountSource {
    /// Holds a [`GatherTotals`].
    counts: Buffer,
    read: ReadBack,
}

impl CountSource {
    fn new(context: &Context) -> Result<Self> {
        let (name, bytes) = ("world.gathered", size_of::<GatherTotals>() as u64);
        let counts = Buffer::new(context, name, bytes, Memory::Device)?;
        Ok(Self { counts, read: ReadBack::new(context, name, bytes)? })
    }

    fn read(&self, frame: u64) -> Result<Option<GatherTotals>> {
        Ok(self.read.read(frame, 1)?.map(|counts| counts[0]))
    }

    fn record<P: Push>(&self, commands: &mut Commands, kernel: &Kernel<P>, push: &P, slots: u32) {
        // Dispatch at least one workgroup, even without elements: it writes the counts.
        let [x, y] = groups(u64::from(slots.div_ceil(THREADS).max(1)));
        commands.pass("world.gather", |pass| pass.update(&self.counts, &[GatherTotals::default()]));
        commands.pass("world.gather", |pass| pass.dispatch(kernel, push, [x, y, 1]));
        commands.read_back(&self.counts, &self.read);
    }
}

/// The gather passes and their counts.
pub(super) struct Gather {
    /// Counts of particles, strands, triangles, splats and lights.
    counted: [CountSource; 5],
    /// Kernels for particles and for strands.
    casters: [Kernels<CastersPush>; 2],
    triangles: Kernels<TrianglesPush>,
    splats: Kernels<SplatsPush>,
    lights: Kernels<LightsPush>,
}

impl Gather {
    pub(super) fn new(context: &Context) -> Result<Self> {
        let one = || CountSource::new(context);
        let counted = [one()?, one()?, one()?, one()?, one()?];
        let casters = [(); 2].map(|()| Kernels::new(&shaders::GATHER));
        let triangles = Kernels::new(&shaders::GATHER_TRIANGLES);
        let splats = Kernels::new(&shaders::GATHER_SPLATS);
        let lights = Kernels::new(&shaders::GATHER_LIGHTS);
        Ok(Self { counted, casters, triangles, splats, lights })
    }

    /// Returns the counts of the completed frame `frame`.
    pub(super) fn read(&self, frame: u64) -> Result<Option<Gathered>> {
        let mut all = [None; 5];
        for (one, counted) in all.iter_mut().zip(&self.counted) {
            *one = counted.read(frame)?;
        }
        let counts = all.map(Option::unwrap_or_default);
        let gathered = Gathered { asked: counts.map(|c| c.asked), refused: counts.map(|c| c.refused) };
        Ok(all.iter().any(Option::is_some).then_some(gathered))
    }

    /// Records the pass that builds casters from particles.
    pub(super) fn spheres(
        &mut self,
        context: &Context,
        commands: &mut Commands,
        to: (&Buffer, Slots),
        (source, at): (&Source, SphereAt),
    ) -> Result<()> {
        let what = "particles";
        let bytes = at.position.saturating_add(12).max(at.radius.end()).max(at.extinction.end());
        let ((radius, radius_is), (density, density_is)) = (at.radius.pushed(what)?, at.extinction.pushed(what)?);
        let position = words(what, at.position.into())?;
        let push = CastersPush { position, end: NOWHERE, radius, radius_is, density, density_is, ..Zeroable::zeroed() };
        self.gather(context, commands, to, (source, bytes, what), push)
    }

    /// Records the pass that builds casters from strands.
    pub(super) fn strands(
        &mut self,
        context: &Context,
        commands: &mut Commands,
        to: (&Buffer, Slots),
        (source, at): (&Source, StrandAt),
    ) -> Result<()> {
        let what = "strands";
        let bytes = at.start.max(at.end).saturating_add(12).max(at.radius.end()).max(at.depth.end());
        let ((radius, radius_is), (density, density_is)) = (at.radius.pushed(what)?, at.depth.pushed(what)?);
        let (position, end) = (words(what, at.start.into())?, words(what, at.end.into())?);
        let push = CastersPush { position, end, radius, radius_is, density, density_is, ..Zeroable::zeroed() };
        self.gather(context, commands, to, (source, bytes, what), push)
    }

    fn gather(
        &mut self,
        context: &Context,
        commands: &mut Commands,
        (casters, slots): (&Buffer, Slots),
        (source, bytes, what): (&Source, u32, &str),
        push: CastersPush,
    ) -> Result<()> {
        let holds = held(&source.buffer, source.offset, source.stride, bytes);
        let counted = source.count.counted(what, slots.capacity, holds)?;
        let (theirs, counts) = (&source.buffer, source.count.buffer(&source.buffer));
        let kind = usize::from(push.end != NOWHERE);
        let set = set::GatherCasters { theirs, counts, casters, counted: &self.counted[kind].counts };
        let kernel = self.casters[kind].of(context, &[theirs, counts], || set.bind(context, "world.gather"))?;
        let push = CastersPush {
            first: slots.first,
            slots: slots.count,
            most: counted.most,
            count_at: counted.at,
            start: words(what, source.offset)?,
            stride: words(what, source.stride.into())?,
            ..push
        };
        self.counted[kind].record(commands, &kernel, &push, slots.count);
        Ok(())
    }

    /// Records the pass that builds casters from splats.
    pub(super) fn splats(
        &mut self,
        context: &Context,
        commands: &mut Commands,
        (casters, slots): (&Buffer, Slots),
        (source, at): (&Source, SplatAt),
    ) -> Result<()> {
        let what = "splats";
        let three = at.position.max(at.deviations).saturating_add(12);
        let bytes = three.max(at.rotation.saturating_add(16)).max(at.opacity.end());
        let (opacity, opacity_is) = at.opacity.pushed(what)?;
        let holds = held(&source.buffer, source.offset, source.stride, bytes);
        let found = source.count.counted(what, slots.capacity, holds)?;
        let (theirs, counts) = (&source.buffer, source.count.buffer(&source.buffer));
        let set = set::GatherCasters { theirs, counts, casters, counted: &self.counted[3].counts };
        let kernel = self.splats.of(context, &[theirs, counts], || set.bind(context, "world.gather"))?;
        let push = SplatsPush {
            first: slots.first,
            slots: slots.count,
            most: found.most,
            count_at: found.at,
            start: words(what, source.offset)?,
            stride: words(what, source.stride.into())?,
            position: words(what, at.position.into())?,
            deviations: words(what, at.deviations.into())?,
            rotation: words(what, at.rotation.into())?,
            opacity,
            opacity_is,
        };
        self.counted[3].record(commands, &kernel, &push, slots.count);
        Ok(())
    }

    /// Records the pass that builds lights from the caller's buffer. It writes `slots` lights, of which at most `told` come from the
    /// caller. `stand_ins` are written to the lights first; `None` if the lights on the device already came from the caller's buffer and
    /// have the same types.
    pub(super) fn lights(
        &mut self,
        context: &Context,
        commands: &mut Commands,
        (lights, slots, told): (&Buffer, u32, u32),
        stand_ins: Option<&[LightData]>,
        (source, at): (&Source, LightAt),
    ) -> Result<()> {
        let what = "lights";
        let three = at.position.max(at.direction).max(at.radiance).saturating_add(12);
        let bytes = three.max(at.radius.end()).max(at.cos_cone.end());
        let ((radius, radius_is), (cos_cone, cos_cone_is)) = (at.radius.pushed(what)?, at.cos_cone.pushed(what)?);
        let holds = held(&source.buffer, source.offset, source.stride, bytes);
        let found = source.count.counted(what, told, holds)?;
        let (theirs, counts) = (&source.buffer, source.count.buffer(&source.buffer));
        let set = set::GatherLights { theirs, counts, lights, counted: &self.counted[4].counts };
        let kernel = self.lights.of(context, &[theirs, counts], || set.bind(context, "world.gather"))?;
        let push = LightsPush {
            slots,
            most: found.most,
            count_at: found.at,
            start: words(what, source.offset)?,
            stride: words(what, source.stride.into())?,
            position: words(what, at.position.into())?,
            direction: words(what, at.direction.into())?,
            radiance: words(what, at.radiance.into())?,
            radius,
            radius_is,
            cos_cone,
            cos_cone_is,
        };
        if let Some(stand_ins) = stand_ins {
            commands.pass("world.lights", |pass| pass.update(lights, stand_ins));
        }
        self.counted[4].record(commands, &kernel, &push, slots);
        Ok(())
    }

    /// Records the pass that builds `capacity` triangles from the caller's. Invalid triangles, and those past the count, collapse to a
    /// corner of a valid triangle. At most 16 triangles are tried to find one; if none is valid, they collapse to `place`.
    pub(super) fn triangles(
        &mut self,
        context: &Context,
        commands: &mut Commands,
        (triangles, capacity): (&Buffer, u32),
        corners: &Corners,
        place: [f32; 3],
    ) -> Result<()> {
        let what = "triangles";
        let vertices = held(&corners.vertices, corners.offset, corners.stride, 12);
        let (indices, indices_at, holds) = match &corners.indices {
            Some((buffer, offset)) => (buffer, words(what, *offset)?, held(buffer, *offset, 12, 12)),
            None => (&corners.vertices, NOWHERE, vertices / 3),
        };
        let counted = corners.count.counted(what, capacity, holds)?;
        let (theirs, counts) = (&corners.vertices, corners.count.buffer(&corners.vertices));
        let set = set::GatherTriangles { theirs, indices, counts, triangles, counted: &self.counted[2].counts };
        let kernel = self.triangles.of(context, &[theirs, indices, counts], || set.bind(context, "world.gather"))?;
        let push = TrianglesPush {
            slots: capacity,
            most: counted.most,
            count_at: counted.at,
            start: words(what, corners.offset)?,
            stride: words(what, corners.stride.into())?,
            vertices,
            indices_at,
            albedo: corners.albedo,
            place,
        };
        self.counted[2].record(commands, &kernel, &push, capacity);
        Ok(())
    }
}
