//! Many lights: each pixel of a 4 × 4 square queries a different sixteenth of the lights, and neighbours on the same surface are averaged.
//! Sources: Keller and Heidrich 2001, Interleaved sampling; Segovia et al. 2006, Non-interleaved deferred shading of interleaved sample
//! patterns. Twin: reference::twin::interleaved.

use super::Renderer;
use super::many_lights::{FrameData, sized};
use super::reservoir::ReservoirData;
use crate::Result;
use crate::gpu::{Buffer, Commands, Constants, Format, Kernel, push_struct};
use crate::scene::{SKY, View};
use crate::shaders::{constant, interleaved as shaders, set};
use crate::technique::Answer;

/// `PLACES`: side, in pixels, of the square in which each pixel has a different part of the lights. `BLOCK`: a workgroup shades a square of
/// `BLOCK` × `BLOCK` pixels that all have the same part.
const PLACES: u32 = 4;
const BLOCK: u32 = 8;

/// Pixels in x and y that a workgroup of the gather pass covers.
const GATHERED: [u32; 2] = [16, 8];

push_struct! {
    /// Twin: GatherPush in glsl/shading/interleaved/gather.comp.
    struct GatherPush {
        corner: [f32; 3],
        across: [f32; 3],
        down: [f32; 3],
        edge: f32,
        sky: [f32; 3],
    }
}

/// Queries one technique for a part of the lights per pixel, then averages neighbours.
pub(super) struct Interleaved {
    ask: Kernel,
    pub(super) gather: Gather,
}

/// Averages the light of neighbouring pixels.
pub(super) struct Gather {
    size: [u32; 2],
    /// Light that each pixel reflects from the lights that it queried, RGB.
    pub(super) estimates: Buffer,
    kernel: Kernel<GatherPush>,
}

impl Interleaved {
    pub(super) fn new(renderer: &Renderer, answer: &Answer) -> Result<Self> {
        let context = &renderer.context;
        let gather = Gather::new(renderer, "interleaved", false)?;
        let written = set::InterleavedWritten { estimates: &gather.estimates }.bind(context, "interleaved.written")?;
        let sets = [&renderer.scene.set, answer.bindings, &renderer.targets.surfaces, &written];
        Ok(Self { ask: Kernel::compute(context, shaders::ASK.of(answer.folder), &sets, answer.constants)?, gather })
    }

    /// Records both passes, which must run after the G-buffer's.
    pub(super) fn record(&self, commands: &mut Commands, camera: &View) {
        self.ask(commands);
        self.gather.gather(commands, camera);
    }

    fn ask(&self, commands: &mut Commands) {
        let [x, y] = self.gather.size.map(|side| side.div_ceil(PLACES).div_ceil(BLOCK));
        commands.pass("interleaved.ask", |pass| pass.dispatch(&self.ask, &(), [x, y, PLACES * PLACES]));
    }
}

impl Gather {
    /// `shading` names the mode in errors. With `whole`, a pixel's estimate already covers all lights, not just a part
    /// of them.
    pub(super) fn new(renderer: &Renderer, shading: &str, whole: bool) -> Result<Self> {
        let (context, size) = (&renderer.context, renderer.targets.color.size());
        let what = format!("{} × {} pixels with shading={shading}", size[0], size[1]);
        let bytes = 12 * u64::from(size[0]) * u64::from(size[1]);
        let estimates = sized(context, "interleaved.estimates", bytes, &what)?;
        let read = set::InterleavedRead { estimates: &estimates, colors: &renderer.targets.color };
        let read = read.bind(context, "interleaved.read")?;
        let half = renderer.targets.format == Format::R16G16B16A16_SFLOAT;
        let gather = if half { &shaders::GATHER_HALF_1 } else { &shaders::GATHER_HALF_0 };
        let constants = Constants::new().set(constant::WHOLE, whole);
        let kernel =
            Kernel::compute(context, gather, &[&renderer.scene.set, &read, &renderer.targets.surfaces], &constants)?;
        Ok(Self { size, estimates, kernel })
    }

    pub(super) fn gather(&self, commands: &mut Commands, camera: &View) {
        let FrameData { corner, across, down, edge, .. } = FrameData::of(camera);
        let push = GatherPush { corner, across, down, edge, sky: SKY };
        let groups = [0, 1].map(|i| self.size[i].div_ceil(GATHERED[i]));
        commands.pass("interleaved.gather", |pass| pass.dispatch(&self.kernel, &push, [groups[0], groups[1], 1]));
    }
}

/// Per-pixel values of the last frame with `shading=interleaved` or `shading=reservoir`, read back to compare with the twin.
pub struct PartReadback {
    /// Number of the pixel's triangle, counted from 1; 0 for sky.
    pub numbers: Vec<u32>,
    /// Light that the pixel reflects from its part of the lights, or from the one light that it keeps, times that light's weight.
    pub estimates: Vec<[f32; 3]>,
    /// Albedo; 0 for sky.
    pub albedo: Vec<[f32; 4]>,
    /// Normal; the last component tells whether the surface is the outside of a closed surface.
    pub normal: Vec<[f32; 4]>,
    /// Depth along the camera's axis, in world units.
    pub z: Vec<f32>,
    /// With `shading=reservoir`, the light that each pixel keeps; otherwise empty.
    pub reservoirs: Vec<ReservoirData>,
}
