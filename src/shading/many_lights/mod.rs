//! Many lights, shaded in tiles. A first pass finds the lights that reach each tile. Then each pixel queries the technique for the tile's
//! lights and stores one bit per light. Finally, one shader, the same for all techniques, shades with all lights. Sources: Olsson and
//! Assarsson 2011 (tiles); Pestana 2015 (a bit per light; dithered, blurred and averaged with the last frame).
//! Twin: reference::twin::many_lights.

mod dispatch;
mod frame;

pub(super) use dispatch::Asking;
pub use dispatch::QueueData;
pub use frame::FrameData;

use super::{Tiled, lock};
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Format, Image, Kernel, Memory, push_struct};
use crate::scene::{SKY, View};
use crate::shaders::set;
use crate::shaders::{Folder, constant, many_lights as shaders};
use crate::technique::Answer;
use crate::{Error, Result};
use dispatch::Queue;
use std::sync::Mutex;

/// Pixels per side of a tile. Twin: TILE.
pub const TILE: u32 = 16;

/// Maximum number of lights per tile. Twin: MOST_WORDS.
pub const MOST_LIGHTS: u32 = 1024;

/// Pixels per side of a workgroup, in passes that look up light or reproject.
const BLOCK: u32 = 8;

/// Reach of the blur on each side, in pixels.
const BLUR_REACH: u32 = 2;

push_struct! {
    /// Twin: ManyLightsPush in glsl/shading/many_lights/frame.glsl.
    pub(super) struct ManyLightsPush {
        size: [u32; 2],
        words: u32,
        phase: u32,
        has_before: u32,
        sky_red: f32,
        sky_green: f32,
        sky_blue: f32,
        light_bits: u32,
        capacity: u32,
    }
}

/// Buffers and images that the renderer reads and draws to.
pub(super) struct Targets<'a> {
    pub context: &'a Context,
    pub lights: &'a Buffer,
    pub light_count: u32,
    /// Albedo, normal and z, as textures.
    pub gbuffer: &'a Bindings,
    pub color: &'a Image,
    pub color_format: Format,
}

/// Buffers and passes of one renderer; some buffers keep their contents for the next frame.
pub(super) struct ManyLights {
    pub(super) tiled: Tiled,
    context: Context,
    size: [u32; 2],
    words: u32,
    frames: Buffer,
    masks: Buffer,
    shadows: Buffer,
    geometry: Buffer,
    history: Option<History>,
    queue: Option<Queue>,
    gbuffer: Bindings,
    /// Set 0 of every pass.
    frame: Bindings,
    cull: Kernel<ManyLightsPush>,
    shade: Kernel<ManyLightsPush>,
    kept: Mutex<FrameHistory>,
}

/// With `history=on`: surfaces and shadows of the previous frame.
struct History {
    shadows: Buffer,
    geometry: Buffer,
    sources: Buffer,
    reproject: Kernel<ManyLightsPush>,
}

/// State on the host that persists from one frame to the next.
#[derive(Default)]
struct FrameHistory {
    /// Camera of the previous frame; `None` at first.
    before: Option<View>,
    /// The two frames that the device's buffer currently holds; `None` until it is written.
    written: Option<[FrameData; 2]>,
    is_odd: bool,
    /// The technique and constants whose results the history holds.
    asked: Option<(Folder, Constants)>,
}

/// Returns the number of 32-bit words per pixel for one bit per light; at least one.
pub fn words(lights: u32) -> u32 {
    lights.div_ceil(32).max(1)
}

/// Creates a buffer, or refuses if it is larger than the device can bind. The error quotes `what`, which names the purpose and the
/// `shading=`.
pub(super) fn sized(context: &Context, name: &str, bytes: u64, what: &str) -> Result<Buffer> {
    let limit = u64::from(context.features().max_storage_buffer_range);
    if bytes > limit {
        let needs = format!(
            "maxStorageBufferRange of at least {bytes} for {what} (this device has {limit}); use a smaller \
             picture or fewer lights"
        );
        return Err(Error::Refused(needs.into()));
    }
    Buffer::new(context, name, bytes, Memory::Device)
}

impl ManyLights {
    pub(super) fn new(targets: &Targets, tiled: Tiled) -> Result<Self> {
        let Targets { context, light_count, .. } = *targets;
        if light_count > MOST_LIGHTS {
            let cause = format!("{light_count} lights, and a tile has room for {MOST_LIGHTS}");
            return Err(Error::input("shading=tiled", cause, "use shading=deferred or fewer lights"));
        }
        let size = targets.color.size();
        let (words, pixels) = (words(light_count), u64::from(size[0]) * u64::from(size[1]));
        let tiles: u64 = size.map(|s| u64::from(s.div_ceil(TILE))).iter().product();
        let picture = format!("{light_count} lights in {} × {} pixels with shading=tiled", size[0], size[1]);
        let buffer = |name, bytes| sized(context, name, bytes, &picture);
        let [frames, masks] = [
            buffer("many_lights.frames", 2 * size_of::<FrameData>() as u64)?,
            buffer("many_lights.masks", 4 * u64::from(words) * tiles)?,
        ];
        let [shadows_bytes, geometry_bytes] = [4 * u64::from(words) * pixels, 8 * pixels];
        let shadows = buffer("many_lights.shadows", shadows_bytes)?;
        let geometry = buffer("many_lights.geometry", geometry_bytes)?;
        let before = match tiled.history {
            true => Some([
                buffer("many_lights.shadows_before", shadows_bytes)?,
                buffer("many_lights.geometry_before", geometry_bytes)?,
                buffer("many_lights.sources", 4 * pixels)?,
            ]),
            false => None,
        };
        let frame = set::ManyLightsFrame { lights: targets.lights, frames: &frames, masks: &masks, shadows: &shadows };
        let frame = frame.bind(context, "many_lights.frame")?;
        // Without a history, these bindings still need a buffer, so the masks fill in. They are never read there.
        let [shadows_before, geometry_before, sources] = before.clone().unwrap_or([(); 3].map(|()| masks.clone()));
        let seen = set::ManyLightsSeen {
            geometry: &geometry,
            geometry_before: &geometry_before,
            shadows_before: &shadows_before,
            sources: &sources,
            colors: targets.color,
        };
        let seen = seen.bind(context, "many_lights.seen")?;
        let constants = Constants::new()
            .set(constant::BLUR_REACH, if tiled.blur { BLUR_REACH } else { 0 })
            .set(constant::HISTORY, tiled.history);
        let half = targets.color_format == Format::R16G16B16A16_SFLOAT;
        let shade = if half { &shaders::SHADE_HALF_1 } else { &shaders::SHADE_HALF_0 };
        let sets = [&frame, &seen, targets.gbuffer];
        let history = match before {
            Some([shadows, geometry, sources]) => {
                let reproject = Kernel::compute(context, &shaders::REPROJECT, &sets, &constants)?;
                Some(History { shadows, geometry, sources, reproject })
            }
            None => None,
        };
        Ok(Self {
            tiled,
            context: context.clone(),
            size,
            words,
            history,
            queue: Queue::of(targets, &tiled, &sets)?,
            gbuffer: targets.gbuffer.clone(),
            cull: Kernel::compute(context, &shaders::CULL, &sets, &constants)?,
            shade: Kernel::compute(context, shade, &sets, &constants)?,
            frames,
            masks,
            shadows,
            geometry,
            frame,
            kept: Mutex::default(),
        })
    }

    /// Returns the size of all buffers between the G-buffer and the picture, in bytes.
    pub(super) fn bytes(&self) -> u64 {
        let history = self.history.iter().flat_map(|h| [&h.shadows, &h.geometry, &h.sources]);
        let buffers = [&self.masks, &self.shadows, &self.geometry].into_iter().chain(history);
        buffers.map(Buffer::bytes).sum::<u64>() + self.queue.as_ref().map_or(0, Queue::bytes)
    }

    /// Creates the kernels that query a technique. A history of another technique's results is discarded.
    pub(super) fn asking(&self, answer: &Answer) -> Result<Asking> {
        let asked = (answer.folder, answer.constants.clone());
        let mut kept = lock(&self.kept);
        if kept.asked.as_ref() != Some(&asked) {
            (kept.asked, kept.before) = (Some(asked), None);
        }
        Asking::new(self, answer)
    }

    /// Prepares the device for a frame seen by `camera`, and returns the passes' push constants.
    pub(super) fn begin(&self, camera: &View) -> Result<ManyLightsPush> {
        let mut kept = lock(&self.kept);
        let frames = [*camera, kept.before.unwrap_or(*camera)].map(|view| FrameData::of(&view));
        if kept.written != Some(frames) {
            kept.written = None;
            self.frames.write(&frames)?;
            kept.written = Some(frames);
        }
        let (light_bits, capacity) = self.queue.as_ref().map_or((0, 0), Queue::push);
        let [sky_red, sky_green, sky_blue] = SKY;
        Ok(ManyLightsPush {
            size: self.size,
            words: self.words,
            phase: if !self.tiled.history {
                2
            } else if kept.is_odd {
                3
            } else {
                1
            },
            has_before: kept.before.is_some().into(),
            sky_red,
            sky_green,
            sky_blue,
            light_bits,
            capacity,
        })
    }

    /// Records all passes that follow the G-buffer's.
    pub(super) fn record(&self, commands: &mut Commands, asking: &Asking, push: &ManyLightsPush) {
        self.cull(commands, push);
        asking.record(self, commands, push);
        if let Some(history) = &self.history {
            history.reproject(commands, self.blocks(), push);
        }
        self.shade(commands, push);
        if let Some(history) = &self.history {
            history.keep(commands, self);
        }
    }

    /// Must be called after a frame seen by `camera` was submitted: that frame becomes the previous frame.
    pub(super) fn end(&self, camera: &View) {
        let mut kept = lock(&self.kept);
        (kept.before, kept.is_odd) = (Some(*camera), !kept.is_odd);
    }

    fn tiles(&self) -> [u32; 3] {
        [self.size[0].div_ceil(TILE), self.size[1].div_ceil(TILE), 1]
    }

    fn blocks(&self) -> [u32; 3] {
        [self.size[0].div_ceil(BLOCK), self.size[1].div_ceil(BLOCK), 1]
    }

    fn cull(&self, commands: &mut Commands, push: &ManyLightsPush) {
        commands.pass("many_lights.cull", |pass| pass.dispatch(&self.cull, push, self.tiles()));
    }

    fn shade(&self, commands: &mut Commands, push: &ManyLightsPush) {
        // Each workgroup shades half a tile.
        let [across, _, _] = self.tiles();
        let halves = [across, self.size[1].div_ceil(TILE / 2), 1];
        commands.pass("many_lights.shade", |pass| pass.dispatch(&self.shade, push, halves));
    }
}

impl History {
    fn reproject(&self, commands: &mut Commands, blocks: [u32; 3], push: &ManyLightsPush) {
        commands.pass("many_lights.reproject", |pass| pass.dispatch(&self.reproject, push, blocks));
    }

    /// Copies shadows and surfaces for the next frame to read.
    fn keep(&self, commands: &mut Commands, now: &ManyLights) {
        commands.pass("many_lights.keep", |pass| {
            pass.copy(&now.shadows, &self.shadows, self.shadows.bytes());
            pass.copy(&now.geometry, &self.geometry, self.geometry.bytes());
        });
    }
}

/// The last frame's buffers, read back to compare with the twin.
pub struct TileReadback {
    /// For each tile, words with one bit per light that reaches the tile; tiles row by row.
    pub masks: Vec<u32>,
    /// For each pixel, words with one bit per light that is shadowed. The first words of all pixels come first, then all second words, and
    /// so on.
    pub shadows: Vec<u32>,
    /// For each pixel, z as bits and the packed normal.
    pub geometry: Vec<[u32; 2]>,
    /// The pixel at which each pixel's surface was in the previous frame, or [`u32::MAX`] if it was not visible; empty without a history.
    pub sources: Vec<u32>,
    /// Cameras of the last frame and of the frame before it.
    pub frames: [FrameData; 2],
}

impl ManyLights {
    pub(super) fn seen(&self) -> Result<TileReadback> {
        let read = |buffer: &Buffer| buffer.read::<u32>(buffer.bytes() as usize / 4);
        let sources = self.history.as_ref().map(|h| read(&h.sources)).transpose()?;
        let frames = self.frames.read::<FrameData>(2)?;
        Ok(TileReadback {
            masks: read(&self.masks)?,
            shadows: read(&self.shadows)?,
            geometry: self.geometry.read(self.geometry.bytes() as usize / 8)?,
            sources: sources.unwrap_or_default(),
            frames: [frames[0], frames[1]],
        })
    }
}
