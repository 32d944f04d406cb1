//! Many lights: each pixel queries one light, chosen at random, and keeps it from frame to frame. Source: Bitterli et al. 2020,
//! Spatiotemporal reservoir resampling for real-time ray tracing with dynamic direct lighting. Twin: reference::twin::reservoir.

use super::Renderer;
use super::interleaved::Gather;
use super::many_lights::{FrameData, sized};
use crate::Result;
use crate::gpu::{Buffer, Commands, Kernel, push_struct};
use crate::scene::View;
use crate::shaders::{reservoir as shaders, set};
use crate::technique::Answer;
use bytemuck::{Pod, Zeroable};
use std::cell::{Cell, RefCell};

/// Pixels per side of a workgroup.
const BLOCK: u32 = 8;

/// Maximum number of earlier frames that a reservoir counts for. Twin: MOST_FRAMES.
pub(super) const MOST_FRAMES: usize = 20;

push_struct! {
    /// Twin: ReservoirPush in glsl/shading/reservoir/ask.comp.
    struct ReservoirPush {
        frame: u32,
        has_before: u32,
        edge: f32,
    }
}

/// The light that a pixel keeps, and its weight. Twin: Reservoir in glsl/shading/reservoir/ask.comp.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ReservoirData {
    /// Index of the light.
    pub light: u32,
    /// The light that the pixel reflects from the kept light, times this weight, is an unbiased estimate of the light that it reflects from
    /// all lights. 0 if no light is kept.
    pub weight: f32,
    /// Number of frames that the reservoir combines. The highest bit is set if the pixel saw the outside of a closed surface.
    pub frames: u32,
    /// Depth of the pixel's surface along the camera's axis, in world units; 0 for sky.
    pub z: f32,
    /// Normal of that surface.
    pub normal: [f32; 3],
}

/// Queries one technique for the lights of a picture, and keeps one light per pixel from frame to frame.
pub(super) struct Reservoirs {
    size: [u32; 2],
    /// Reservoirs of the last even and the last odd frame.
    kept: [Buffer; 2],
    /// Kernels for even and odd frames: each reads one of the buffers and writes the other.
    ask: [Kernel<ReservoirPush>; 2],
    before: Buffer,
    /// Camera of the previous frame.
    seen: RefCell<Option<View>>,
    frame: Cell<u32>,
    pub(super) gather: Gather,
}

impl Reservoirs {
    pub(super) fn new(renderer: &Renderer, answer: &Answer) -> Result<Self> {
        let (context, size) = (&renderer.context, renderer.targets.color.size());
        let what = format!("{} × {} pixels with shading=reservoir", size[0], size[1]);
        let bytes = size_of::<ReservoirData>() as u64 * u64::from(size[0]) * u64::from(size[1]);
        let buffer = |name| sized(context, name, bytes, &what);
        let kept = [buffer("reservoir.even")?, buffer("reservoir.odd")?];
        let before = Buffer::with_data(context, "reservoir.before", &[renderer.camera])?;
        let gather = Gather::new(renderer, "reservoir", true)?;
        let ask = |[now, old]: [&Buffer; 2]| {
            let kept = set::ReservoirKept {
                estimates: &gather.estimates,
                reservoirs: now,
                reservoirs_before: old,
                before: &before,
            };
            let kept = kept.bind(context, "reservoir.kept")?;
            let sets = [&renderer.scene.set, answer.bindings, &renderer.targets.surfaces, &kept];
            Kernel::compute(context, shaders::ASK.of(answer.folder), &sets, answer.constants)
        };
        let ask = [ask([&kept[0], &kept[1]])?, ask([&kept[1], &kept[0]])?];
        Ok(Self { size, kept, ask, before, seen: RefCell::default(), frame: Cell::new(0), gather })
    }

    /// Returns the size of the buffers between G-buffer and picture, in bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.gather.estimates.bytes() + self.kept.iter().map(Buffer::bytes).sum::<u64>()
    }

    /// Sets the frame number, which seeds the choice of lights, and forgets the kept lights.
    pub(super) fn begin_at(&self, frame: u32) {
        self.frame.set(frame);
        *self.seen.borrow_mut() = None;
    }

    /// Prepares the device for the next frame.
    pub(super) fn begin(&self) -> Result<()> {
        match *self.seen.borrow() {
            Some(before) => self.before.write(&[before]),
            None => Ok(()),
        }
    }

    /// Records both passes, which must run after the G-buffer's.
    pub(super) fn record(&self, commands: &mut Commands, camera: &View) {
        self.ask(commands, camera);
        self.gather.gather(commands, camera);
    }

    /// Must be called after a frame seen by `camera` was submitted: that frame becomes the previous frame.
    pub(super) fn end(&self, camera: &View) {
        *self.seen.borrow_mut() = Some(*camera);
        self.frame.set(self.frame.get().wrapping_add(1));
    }

    fn ask(&self, commands: &mut Commands, camera: &View) {
        let [x, y] = self.size.map(|side| side.div_ceil(BLOCK));
        let (frame, has_before) = (self.frame.get(), self.seen.borrow().is_some().into());
        let push = ReservoirPush { frame, has_before, edge: FrameData::of(camera).edge };
        let ask = &self.ask[frame as usize % 2];
        commands.pass("reservoir.ask", |pass| pass.dispatch(ask, &push, [x, y, 1]));
    }

    /// Reads the lights that the last frame kept.
    pub(super) fn kept(&self) -> Result<Vec<ReservoirData>> {
        let last = &self.kept[self.frame.get().wrapping_sub(1) as usize % 2];
        last.read(self.size[0] as usize * self.size[1] as usize)
    }
}
