//! Per-texel linked lists of all segments, captured with atomics. Shared by the techniques that start from such lists.

use super::{Bins, CasterQuads, Maps, stacked};
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Format, Image, ImageUse, Kernel, Memory, ReadBack};
use crate::maps::QuadsPush;
use crate::shaders;
use crate::shaders::set;
use crate::world::World;
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// Twin: Segment in glsl/maps/list/segments.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SegmentData {
    /// Entry depth, in the light's range.
    pub entry: f32,
    /// Exit depth, in the light's range.
    pub exit: f32,
    /// Optical depth of the segment.
    pub optical_depth: f32,
    /// Index of the next segment in the list, or `0xFFFFFFFF`.
    pub next: u32,
}

/// Twin: NO_SEGMENT.
pub const NO_SEGMENT: u32 = u32::MAX;

/// Initial capacity of the buffer, in segments per texel. It grows as needed.
const FIRST_CAPACITY: u64 = 16;

/// Which maps' lists exist at the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// The lists of as many maps as fit. They are used before the next maps are captured.
    Some,
    /// The lists of all maps.
    All,
}

/// The lists and the pass that captures them.
pub struct List {
    context: Context,
    /// R32UI: the index of each texel's first segment, for the stacked maps that are captured together.
    pub heads: Image,
    /// [`SegmentData`].
    pub segments: Buffer,
    /// Whether the driver ended loops over a list early, followed by the number of fragments for each group of maps
    /// that are captured together.
    counters: Buffer,
    counted: ReadBack,
    capacity: u32,
    at_once: u32,
    keep: Keep,
    map_count: u32,
    size: [u32; 2],
    /// Whether the caller fixed the capacity. Segments that do not fit are then lost, and counted.
    fixed: bool,
    /// Fragments of the last build per group, whether stored or not.
    fragments: Vec<u32>,
    /// Number of slots per segment in other buffers: see [`List::with_events`].
    places: u64,
    set: Bindings,
    /// `None` if the lists are filled elsewhere.
    drawn: Option<(CasterQuads, Kernel<QuadsPush>)>,
}

fn segment_buffer(context: &Context, capacity: u32) -> Result<Buffer> {
    let bytes = u64::from(capacity) * size_of::<SegmentData>() as u64;
    Buffer::new(context, "list.segments", bytes, Memory::Device)
}

impl List {
    /// Creates lists of the segments of drawn casters, one list per texel of the maps. Without `quads`, a capture
    /// leaves the lists empty. `capacity` fixes the number of segments for all builds; without it, the buffer grows.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out, or if the maps whose lists are kept do not fit into one image.
    pub fn new(
        context: &Context,
        maps: &Maps,
        quads: Option<CasterQuads>,
        keep: Keep,
        capacity: Option<u32>,
    ) -> Result<Self> {
        let size = maps.size();
        let at_once = if keep == Keep::All { maps.count() } else { maps.stacked_at_once(context) };
        let heads_size = stacked(context, "list.heads", size, at_once)?;
        let heads = Image::new(context, "list.heads", Format::R32_UINT, heads_size, ImageUse::Storage)?;
        let first = (u64::from(heads_size[0]) * u64::from(heads_size[1]) * FIRST_CAPACITY).min(limit(context));
        let capacity_now = capacity.unwrap_or(first as u32);
        let segments = segment_buffer(context, capacity_now)?;
        let counter_bytes = 4 * (1 + u64::from(maps.count()));
        let counters = Buffer::new(context, "list.counters", counter_bytes, Memory::Device)?;
        let counted = ReadBack::new(context, "list.counted", counter_bytes)?;
        let set = set::List { heads: &heads, segments: &segments, counters: &counters }.bind(context, "list")?;
        let kernel = |quads: &CasterQuads| {
            quads.kernel(context, maps, &shaders::list::CAPTURE_FRAG, &[], &[&set], &Constants::new())
        };
        let drawn = quads.map(|quads| kernel(&quads).map(|kernel| (quads, kernel))).transpose()?;
        Ok(Self {
            context: context.clone(),
            heads,
            segments,
            counters,
            counted,
            capacity: capacity_now,
            at_once,
            keep,
            map_count: maps.count(),
            size,
            fixed: capacity.is_some(),
            fragments: Vec::new(),
            places: 1,
            set,
            drawn,
        })
    }

    /// Limits growth so that a buffer with `places` slots per segment, each as large as a segment, still fits the device.
    pub fn with_events(self, places: u64) -> Self {
        Self { places, ..self }
    }

    /// Returns the set with heads, segments and counters.
    pub fn set(&self) -> &Bindings {
        &self.set
    }

    /// Binds the segments in another set, at binding `binding`.
    ///
    /// # Errors
    /// Same as [`Bindings::replace`].
    pub fn bind_segments(&self, set: &Bindings, binding: usize) -> Result<()> {
        set.replace(binding, &self.segments)
    }

    /// Returns the capacity, in segments.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// Returns the number of maps that are captured together.
    pub fn at_once(&self) -> u32 {
        self.at_once
    }

    /// Prepares for the captures of a build.
    pub fn begin(&mut self, commands: &mut Commands, world: &World, maps: &Maps, bins: Option<&Bins>) {
        commands.read_back(&self.counters, &self.counted);
        if let Some((quads, _)) = &mut self.drawn {
            quads.record(commands, world, maps, bins);
        }
    }

    /// Empties the lists and, if casters are drawn, captures the lists of `maps`, which form group `group`.
    pub fn capture(&self, commands: &mut Commands, maps: Range<u32>, group: u32) {
        commands.pass("list.clear", |pass| {
            pass.clear_image(&self.heads, NO_SEGMENT);
            if group == 0 {
                pass.fill(&self.counters, 0);
            }
        });
        let Some((quads, kernel)) = &self.drawn else { return };
        commands.pass("list.capture", |pass| {
            let size = [self.size[0], self.size[1] * maps.len() as u32];
            pass.render(size, &[], None, |draw| quads.draw(draw, kernel, maps, group, self.capacity));
        });
    }

    /// Reads how many segments the build of the completed frame `frame` needed. If they did not fit and the capacity is not fixed, enlarges
    /// the buffer and returns true: the capture must run again. If the device has no room for all maps together, fewer maps are captured at
    /// a time.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device has no room for the segments of one map, [`crate::Error::Refused`] if the
    /// driver ended loops over a list early.
    pub fn settle(&mut self, frame: u64) -> Result<bool> {
        let groups = self.map_count.div_ceil(self.at_once) as usize;
        let Some(counted) = self.counted.read::<u32>(frame, 1 + groups)? else { return Ok(false) };
        let grew = self.make_room(counted)?;
        if grew {
            // Frames recorded earlier used a smaller buffer, so their counts do not show whether the segments fit now.
            self.counted.forget();
        }
        Ok(grew)
    }

    fn make_room(&mut self, counted: Vec<u32>) -> Result<bool> {
        let cut_short = counted.first().is_some_and(|c| *c != 0);
        self.fragments = counted.into_iter().skip(1).collect();
        let fragments = self.fragments.iter().copied().max().unwrap_or(0);
        if cut_short {
            return Err(super::cut_short("a texel"));
        }
        if self.fixed || fragments <= self.capacity {
            return Ok(false);
        }
        // Allocate an eighth more than needed, so that an animated scene does not grow the buffer every frame. The device's buffer size
        // limit caps the capacity, but never below what is needed.
        let limit = limit(&self.context) / self.places;
        if u64::from(fragments) > limit && self.at_once > 1 && self.keep == Keep::Some {
            self.at_once = self.at_once.div_ceil(2);
            return Ok(true);
        }
        let wanted = u64::from(fragments) + u64::from(fragments) / 8;
        let capacity = wanted.min(limit).max(fragments.into()).min(u32::MAX.into()) as u32;
        self.segments = segment_buffer(&self.context, capacity)?;
        self.set.replace(set::List::SEGMENTS, &self.segments)?;
        self.capacity = capacity;
        Ok(true)
    }

    /// Returns the number of segments captured over all maps; 0 before the first capture.
    pub fn fragments(&self) -> u64 {
        self.fragments.iter().copied().map(u64::from).sum()
    }

    /// Returns the number of segments that were lost because the capacity was exceeded.
    pub fn overflowed(&self) -> u64 {
        self.fragments.iter().map(|f| u64::from(f.saturating_sub(self.capacity))).sum()
    }

    /// Returns the bytes of heads, segments, counters and the draw's buffers.
    pub fn bytes(&self) -> u64 {
        self.drawn.as_ref().map_or(0, |(quads, _)| quads.bytes())
            + self.heads.bytes()
            + self.segments.bytes()
            + self.counters.bytes()
    }
}

/// Returns the maximum number of segments that the device can bind.
fn limit(context: &Context) -> u64 {
    u64::from(context.features().max_storage_buffer_range) / size_of::<SegmentData>() as u64
}
