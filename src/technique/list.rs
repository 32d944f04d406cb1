//! Per-texel linked lists of all segments, captured with atomics. Shared by the techniques that start from them.

use super::{LightData, SceneData};
use crate::Result;
use crate::gpu::{
    Bindings, Buffer, Commands, Context, Format, Graphics, Image, ImageUse, Memory, Pipeline, Resource, shader,
};
use bytemuck::{Pod, Zeroable};

/// Twin: Segment in glsl/list/segments.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SegmentData {
    /// Depth in the light's range.
    pub entry: f32,
    /// Depth in the light's range.
    pub exit: f32,
    /// Optical depth of the segment.
    pub optical_depth: f32,
    /// The particle that made it.
    pub particle: u32,
    /// Next in the list, or `0xFFFFFFFF`.
    pub next: u32,
}

/// Twin: NO_SEGMENT.
pub const NO_SEGMENT: u32 = u32::MAX;

/// Segments a texel that the buffer starts with. It grows to what a scene demands.
const FIRST_CAPACITY: u64 = 16;

/// The lists and the pass that captures them.
pub struct List {
    context: Context,
    /// R32UI: index of each texel's first segment.
    pub heads: Image,
    /// [`SegmentData`].
    pub segments: Buffer,
    counters: Buffer,
    capacity: u32,
    /// The user fixed the capacity: what does not fit is lost, and counted.
    fixed: bool,
    /// Fragments of a capture, stored or not; none before the first. The casters do not change, nor does this.
    fragments: Option<u32>,
    scene_bindings: Bindings,
    bindings: Bindings,
    pipeline: Pipeline,
    particle_count: u32,
}

/// The set that glsl/list/particle.vert reads: lights, particles, drawing order.
pub fn scene_bindings(context: &Context, scene: &SceneData, lights: &Buffer, order: &[u32]) -> Result<Bindings> {
    let resources = [
        Resource::Buffer(lights.clone()),
        Resource::Buffer(scene.particles.clone()),
        Resource::Buffer(Buffer::with_data(context, "scene.order", order)?),
    ];
    Bindings::new(context, "list.scene", &resources)
}

fn bindings(context: &Context, heads: &Image, segments: &Buffer, counters: &Buffer) -> Result<Bindings> {
    let resources =
        [Resource::StorageImage(heads.clone()), Resource::Buffer(segments.clone()), Resource::Buffer(counters.clone())];
    Bindings::new(context, "list", &resources)
}

fn segment_buffer(context: &Context, capacity: u32) -> Result<Buffer> {
    let bytes = u64::from(capacity) * size_of::<SegmentData>() as u64;
    Buffer::new(context, "list.segments", bytes, Memory::Device)
}

impl List {
    /// Lists over the light's volume map. `capacity` fixes the number of segments; without it the buffer grows.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(
        context: &Context,
        scene: &SceneData,
        light: &LightData,
        lights: &Buffer,
        capacity: Option<u32>,
    ) -> Result<Self> {
        let size = [light.volume.width, light.volume.height];
        let heads = Image::new(context, "list.heads", Format::R32_UINT, size, ImageUse::Storage)?;
        let first = (light.volume.texels() as u64 * FIRST_CAPACITY)
            .min(u64::from(context.features().max_storage_buffer_range) / size_of::<SegmentData>() as u64);
        let capacity_now = capacity.unwrap_or(first as u32);
        let segments = segment_buffer(context, capacity_now)?;
        let counters = Buffer::new(context, "list.counters", 4, Memory::Device)?;
        let order: Vec<u32> = (0..scene.particle_count).collect();
        let scene_bindings = scene_bindings(context, scene, lights, &order)?;
        let bindings = bindings(context, &heads, &segments, &counters)?;
        let state = Graphics {
            vertex: shader("list/particle.vert")?,
            fragment: shader("list/capture.frag")?,
            colors: &[],
            depth: false,
        };
        let pipeline = Pipeline::graphics(context, &state, &[&scene_bindings, &bindings], &[])?;
        Ok(Self {
            context: context.clone(),
            heads,
            segments,
            counters,
            capacity: capacity_now,
            fixed: capacity.is_some(),
            fragments: None,
            scene_bindings,
            bindings,
            pipeline,
            particle_count: scene.particle_count,
        })
    }

    /// The set with heads, segments and counters.
    pub fn bindings(&self) -> &Bindings {
        &self.bindings
    }

    /// The set with lights and particles.
    pub fn scene_bindings(&self) -> &Bindings {
        &self.scene_bindings
    }

    /// Empties the lists.
    pub fn clear(&self, commands: &mut Commands) {
        commands.pass("list.clear", |pass| {
            pass.clear_image(&self.heads, NO_SEGMENT);
            pass.fill(&self.counters, 0);
        });
    }

    /// Draws all particles into the lists.
    pub fn capture(&self, commands: &mut Commands) {
        commands.pass("list.capture", |pass| {
            pass.render(self.heads.size(), &[], None, |draw| {
                let sets = [&self.scene_bindings, &self.bindings];
                draw.draw(&self.pipeline, &sets, bytemuck::bytes_of(&self.capacity), 6 * self.particle_count);
            });
        });
    }

    /// Reads the demand of the first capture. Where it did not fit, and the capacity is not fixed, makes room and says
    /// that the capture must run again.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device has no room for the demand.
    pub fn grow(&mut self) -> Result<bool> {
        if self.fragments.is_some() {
            return Ok(false);
        }
        let fragments = self.counters.read::<u32>(1)?.first().copied().unwrap_or(0);
        self.fragments = Some(fragments);
        if self.fixed || fragments <= self.capacity {
            return Ok(false);
        }
        // An eighth more, so that a scene in motion does not grow every frame; only what is needed if that is too much.
        let limit = u64::from(self.context.features().max_storage_buffer_range) / size_of::<SegmentData>() as u64;
        let wanted = u64::from(fragments) + u64::from(fragments) / 8;
        let capacity = wanted.min(limit).max(fragments.into()).min(u32::MAX.into()) as u32;
        self.segments = segment_buffer(&self.context, capacity)?;
        self.bindings = bindings(&self.context, &self.heads, &self.segments, &self.counters)?;
        self.capacity = capacity;
        Ok(true)
    }

    /// Segments of a capture; 0 before the first.
    pub fn fragments(&self) -> u32 {
        self.fragments.unwrap_or(0)
    }

    /// Segments of a capture that were lost.
    pub fn overflowed(&self) -> u32 {
        self.fragments().saturating_sub(self.capacity)
    }

    /// Heads, segments and counters.
    pub fn bytes(&self) -> u64 {
        self.heads.bytes() + self.segments.bytes() + self.counters.bytes()
    }
}
