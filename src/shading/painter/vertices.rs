//! `lighting=vertex` in compute passes: computes the light at the vertices of all casters' quads, before casters are
//! painted with it.
//! Twin: reference::twin::vertex_lit.

use super::lists::Lists;
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, ReadBack, groups, push_struct};
use crate::shaders::{painter as shaders, set};
use crate::shading::Renderer;
use crate::technique::Answer;
use bytemuck::{Pod, Zeroable};
use std::cell::Cell;
use std::ops::Range;

/// Casters per workgroup. Twin: GROUP.
const GROUP: u32 = 64;

/// Initial capacity, in vertices per caster.
const FIRST_VERTICES: u32 = 4;

/// Maximum number of vertices at a time. If there would be more, casters are painted in several runs, one after another.
const MOST_VERTICES: u32 = 1 << 24;

/// Bytes of light per vertex.
const LIGHT_BYTES: u32 = 12;

push_struct! {
    /// Twin: VerticesPush in glsl/shading/painter/vertices.comp.
    struct VerticesPush {
        spacing: f32,
        first: u32,
        count: u32,
        capacity: u32,
        counts_only: u32,
    }
}

/// A caster's quad. Twin: Patch in glsl/shading/painter/patches.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PatchData {
    /// Two opposite corners in NDC, low then high.
    pub corners: [f32; 4],
    /// Index of the first of its vertices, which are stored row by row.
    pub first: u32,
    /// Number of segments along x in the lower 16 bits, along y in the upper 16; 0 if the vertices did not fit.
    pub parts: u32,
}

/// Twin: Counts in glsl/shading/painter/vertices.comp.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
struct Counts {
    /// Number of vertices of the last run of casters, whether they fit or not.
    wanted: u32,
    /// Maximum of `wanted` over all runs of the frame.
    most_wanted: u32,
}

/// The pass that lights vertices, and its results.
pub(super) struct Vertices {
    context: Context,
    spacing: f32,
    kernel: Kernel<VerticesPush>,
    patches: Buffer,
    light: Buffer,
    counts: Buffer,
    counted: ReadBack,
    /// As in `Lists`.
    recorded: Cell<u64>,
    short_until: Option<u64>,
    set: Bindings,
    /// Set 1 of the pass that paints.
    pub(super) lit: Bindings,
}

impl Vertices {
    /// Creates the pass for pictures of `renderer`, lit by `answer`, with at most `spacing` pixels between vertices.
    pub(super) fn new(renderer: &Renderer, answer: &Answer, constants: &Constants, spacing: f32) -> Result<Self> {
        let (context, casters) = (&renderer.context, renderer.blending.room());
        let patches = u64::from(casters) * size_of::<PatchData>() as u64;
        let patches = Buffer::new(context, "painter.patches", patches, Memory::Device)?;
        let capacity = casters.saturating_mul(FIRST_VERTICES).clamp(1024, most_vertices(context));
        let light = light_buffer(context, capacity)?;
        let counts = Buffer::new(context, "painter.counts", size_of::<Counts>() as u64, Memory::Device)?;
        let set = set::PainterVertices {
            distances: &renderer.targets.distance,
            patches: &patches,
            vertex_light: &light,
            counts: &counts,
        };
        let set = set.bind(context, "painter.vertices")?;
        let lit = set::PainterPatches { patches: &patches, vertex_light: &light }.bind(context, "painter.lit")?;
        let sets = [&renderer.scene.set, answer.bindings, &set];
        Ok(Self {
            context: context.clone(),
            spacing,
            kernel: Kernel::compute(context, shaders::VERTICES.of(answer.folder), &sets, constants)?,
            counted: ReadBack::new(context, "painter.counted", counts.bytes())?,
            recorded: Cell::default(),
            short_until: None,
            patches,
            light,
            counts,
            set,
            lit,
        })
    }

    fn capacity(&self) -> u32 {
        (self.light.bytes() / u64::from(LIGHT_BYTES)) as u32
    }

    /// Records the pass that counts the vertices of the casters at positions `run` of the order and, with `lights`,
    /// computes their light.
    pub(super) fn record(&self, commands: &mut Commands, run: &Range<u32>, is_first: bool, lights: bool) {
        self.recorded.set(commands.frame());
        let count = run.end - run.start;
        let push = VerticesPush {
            spacing: self.spacing,
            first: run.start,
            count,
            capacity: self.capacity(),
            counts_only: (!lights).into(),
        };
        let [x, y] = groups(u64::from(count.div_ceil(GROUP)));
        commands.pass("painter.vertices", |pass| {
            pass.fill_part(&self.counts, 0, if is_first { self.counts.bytes() } else { 4 }, 0);
            pass.barrier();
            pass.dispatch(&self.kernel, &push, [x, y, 1]);
        });
        commands.read_back(&self.counts, &self.counted);
    }

    /// Enlarges the buffer for vertices that did not fit in the completed frame `frame`. Returns whether there were any.
    pub(super) fn settle(&mut self, frame: u64, lists: &mut Lists) -> Result<bool> {
        let Some(counts) = self.counted.read::<Counts>(frame, 1)? else {
            return Ok(self.short_until.is_some_and(|last| frame <= last));
        };
        let wanted = counts.first().map_or(0, |c| c.most_wanted);
        if wanted <= self.capacity() {
            return Ok(false);
        }
        let most = most_vertices(&self.context);
        if self.capacity() < most {
            let light = light_buffer(&self.context, wanted.saturating_add(wanted / 8).min(most))?;
            self.set.replace(set::PainterVertices::VERTEX_LIGHT, &light)?;
            self.lit.replace(set::PainterPatches::VERTEX_LIGHT, &light)?;
            self.light = light;
        } else {
            lists.halve_runs();
        }
        self.counted.forget();
        self.short_until = Some(self.recorded.get());
        Ok(true)
    }

    /// Returns the size of all buffers, in bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.patches.bytes() + self.light.bytes() + self.counts.bytes()
    }
}

fn light_buffer(context: &Context, vertices: u32) -> Result<Buffer> {
    let bytes = u64::from(vertices) * u64::from(LIGHT_BYTES);
    Buffer::new(context, "painter.vertex_light", bytes, Memory::Device)
}

fn most_vertices(context: &Context) -> u32 {
    MOST_VERTICES.min(context.features().max_storage_buffer_range / LIGHT_BYTES)
}
