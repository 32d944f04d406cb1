//! Per-texel linked lists of all segments, captured with atomics. Shared by the techniques that start from them.

use super::bins::Bins;
use super::drawn::Drawn;
use super::light::{Maps, stacked};
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
    /// The caster that made it.
    pub caster: u32,
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
    /// R32UI: index of each texel's first segment. Of one map, or of all, one above the other.
    pub heads: Image,
    /// [`SegmentData`].
    pub segments: Buffer,
    /// Fragments of each map; of all in the first where all are kept.
    counters: Buffer,
    capacity: u32,
    keep: Keep,
    map_count: u32,
    size: [u32; 2],
    /// The user fixed the capacity: what does not fit is lost, and counted.
    fixed: bool,
    /// What `counters` held after the first build: fragments, stored or not. The casters do not change, nor does this.
    fragments: Option<Vec<u32>>,
    drawn: Drawn,
    bindings: Bindings,
    pipeline: Pipeline,
}

/// Which maps' lists stand at the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// Each map's are used up before the next map's are captured.
    One,
    /// All.
    All,
}

/// What glsl/list/caster.vert and capture.frag are pushed.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    map: u32,
    order_first: u32,
    counter: u32,
    first_row: u32,
    capacity: u32,
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
    /// Lists over the volume maps of the casters that are drawn. `capacity` fixes the number of segments at once; without
    /// it the buffer grows.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out, or the maps to keep are more than fit into an image.
    pub fn new(context: &Context, maps: &Maps, drawn: Drawn, keep: Keep, capacity: Option<u32>) -> Result<Self> {
        let size = maps.size();
        let heads_size = stacked(context, "list.heads", size, if keep == Keep::All { maps.count() } else { 1 })?;
        let heads = Image::new(context, "list.heads", Format::R32_UINT, heads_size, ImageUse::Storage)?;
        let first = (u64::from(heads_size[0]) * u64::from(heads_size[1]) * FIRST_CAPACITY)
            .min(u64::from(context.features().max_storage_buffer_range) / size_of::<SegmentData>() as u64);
        let capacity_now = capacity.unwrap_or(first as u32);
        let segments = segment_buffer(context, capacity_now)?;
        let counters = Buffer::new(context, "list.counters", 4 * u64::from(maps.count()), Memory::Device)?;
        let bindings = bindings(context, &heads, &segments, &counters)?;
        let state = Graphics {
            vertex: shader("list/caster.vert")?,
            fragment: shader("list/capture.frag")?,
            colors: &[],
            depth: false,
        };
        let pipeline = Pipeline::graphics(context, &state, &[drawn.bindings(), &bindings], &[])?;
        Ok(Self {
            context: context.clone(),
            heads,
            segments,
            counters,
            capacity: capacity_now,
            keep,
            map_count: maps.count(),
            size,
            fixed: capacity.is_some(),
            fragments: None,
            drawn,
            bindings,
            pipeline,
        })
    }

    /// The set with heads, segments and counters.
    pub fn bindings(&self) -> &Bindings {
        &self.bindings
    }

    /// The set with maps and casters.
    pub fn scene_bindings(&self) -> &Bindings {
        self.drawn.bindings()
    }

    /// Empties the lists before map `map` is captured, and the counters before the first. No pass where there is nothing
    /// to empty.
    pub fn clear(&self, commands: &mut Commands, map: u32) {
        if map > 0 && self.keep == Keep::All {
            return;
        }
        commands.pass("list.clear", |pass| {
            pass.clear_image(&self.heads, NO_SEGMENT);
            if map == 0 {
                pass.fill(&self.counters, 0);
            }
        });
    }

    /// Draws the casters into the lists of map `map`: all, or those that `bins` has counted.
    pub fn capture(&self, commands: &mut Commands, map: u32, bins: Option<&Bins>) {
        self.drawn.compact(commands, map, bins);
        let (counter, first_row) = if self.keep == Keep::All { (0, map * self.size[1]) } else { (map, 0) };
        let push = Push { map, order_first: self.drawn.first(map), counter, first_row, capacity: self.capacity };
        commands.pass("list.capture", |pass| {
            pass.render(self.size, &[], None, |draw| {
                let sets = [self.drawn.bindings(), &self.bindings];
                self.drawn.draw(draw, &self.pipeline, &sets, bytemuck::bytes_of(&push), map);
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
        let counted = self.counters.read::<u32>(self.map_count as usize)?;
        let fragments = counted.iter().copied().max().unwrap_or(0);
        self.fragments = Some(counted);
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

    /// Segments of all maps' captures; 0 before the first.
    pub fn fragments(&self) -> u64 {
        self.fragments.iter().flatten().copied().map(u64::from).sum()
    }

    /// Segments that were lost.
    pub fn overflowed(&self) -> u64 {
        self.fragments.iter().flatten().map(|f| u64::from(f.saturating_sub(self.capacity))).sum()
    }

    /// Heads, segments, counters and what is drawn.
    pub fn bytes(&self) -> u64 {
        self.drawn.bytes() + self.heads.bytes() + self.segments.bytes() + self.counters.bytes()
    }
}
