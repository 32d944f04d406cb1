//! Everything that involves Gobo. It shadows the particles by recording into the renderer's command buffers, and provides a descriptor set
//! through which the renderer's shaders query how much of the sun reaches a point.

use super::memory::{Buffer, Set};
use super::{EYE, FOV_Y, FRAMES_IN_FLIGHT, Gpu, MIDDLE, Options, PARTICLE_BYTES, PARTICLES, Result, SUN_BYTES, TO_SUN};
use ash::vk;
use gobo::gpu::{Adopt, Commands, Context, Messages};
use gobo::scene::{Camera, Light, LightKind, View};
use gobo::shading::{Kernels, Lighting, PainterKind, Renderer, Shading};
use gobo::technique::{Technique, open};
use gobo::world::{Capacity, Count, LightAt, LightType, Number, Source, SphereAt, World};

/// Layout of the sun, which Gobo reads on the device. A directional light has no position, so that offset is not used.
const SUN_AT: LightAt =
    LightAt { position: 0, direction: 0, radiance: 12, radius: Number::Is(f32::INFINITY), cos_cone: Number::Is(0.0) };

/// Fields are dropped in this order: the last one created is dropped first.
pub struct Shadows {
    /// Draws the picture, with `--painted`.
    pub painter: Option<Painter>,
    pub technique: Box<dyn Technique>,
    world: World,
    pub particles: Source,
    /// The sun's buffer, if only the device knows where the sun is.
    pub sun: Option<Source>,
    pub context: Context,
    /// One set per frame in flight: a set that the device may be reading must not be written.
    pub sets: Vec<Set>,
    /// The last frame recorded.
    pub frame: u64,
}

impl Shadows {
    /// Opens Gobo on the renderer's device, for its particles and its sun. The commands are being recorded as frame 0.
    pub fn new(gpu: &mut Gpu, options: &Options, buffers: [&Buffer; 2], commands: vk::CommandBuffer) -> Result<Self> {
        let context = adopt(gpu)?;
        let mut world = World::of(&context, Capacity { particles: PARTICLES, lights: 1, ..Capacity::default() })?;
        let source = |name, buffer: &Buffer, stride, count| -> Result<Source> {
            // SAFETY: the buffer belongs to this device, has this size, was created for storage, and outlives Gobo.
            let buffer = unsafe { gobo::gpu::Buffer::adopt(&context, name, buffer.handle, buffer.bytes) }?;
            Ok(Source { buffer, offset: 0, stride, count: Count::Host(count) })
        };
        let particles = source("particles", buffers[0], PARTICLE_BYTES, PARTICLES)?;
        let sun = (options.turn_per_s != 0.0).then(|| source("sun", buffers[1], SUN_BYTES, 1)).transpose()?;

        // Lights are set before the technique is opened, since it is opened for their number. SAFETY: the commands are being recorded,
        // outside rendering, for this frame; no frame came before it.
        let mut commands = unsafe { Commands::on(&context, commands, 0) }?;
        shine(&mut world, &mut commands, sun.as_ref())?;
        commands.end();
        let technique = open(&context, &world, &options.technique)?.technique;
        let bindings = technique.answer().layout(0);
        let sets = (0..FRAMES_IN_FLIGHT).map(|_| Set::new(gpu, &bindings)).collect::<Result<_>>()?;
        let painter = || Painter::new(&context, &world, technique.as_ref(), options.size);
        let painter = options.painted.then(painter).transpose()?;
        Ok(Self { painter, technique, world, particles, sun, context, sets, frame: 0 })
    }

    /// Checks whether any of Gobo's lists was too short in frame `frame`, which has finished. If so, the lists are long enough from the
    /// next frame on.
    pub fn settle(&mut self, frame: u64) -> Result<()> {
        let settle = |painter: &Painter| painter.renderer.settle(&painter.kernels, frame);
        self.painter.as_ref().map_or(Ok(true), settle)?;
        Ok(self.technique.settle(frame).map(drop)?)
    }

    /// Records the shadows of the particles, at the positions to which earlier commands moved them. Later commands may query the shadows.
    pub fn record(&mut self, commands: vk::CommandBuffer, frame: u64) -> Result<()> {
        // SAFETY: the commands are being recorded, outside rendering, for this frame, are submitted once and in order, and `Frames::begin`
        // waited for the frame `FRAMES_IN_FLIGHT` before this one.
        let mut commands = unsafe { Commands::on(&self.context, commands, frame) }?;
        shine(&mut self.world, &mut commands, self.sun.as_ref())?;
        self.world.update_particles(&mut commands, &self.particles, SphereAt::PARTICLE)?;
        self.technique.record(&mut commands, &self.world)?;
        if let Some(Painter { renderer, kernels, view }) = &mut self.painter {
            renderer.look(&self.world, view)?;
            renderer.record(&mut commands, kernels)?;
        }
        commands.end();
        self.frame = frame;
        // A buffer that grew is a new buffer, so the set is written every frame.
        // SAFETY: the set has these bindings, and the frame that used it has finished.
        unsafe { self.technique.answer().write_into(self.set(), 0) };
        Ok(())
    }

    /// Returns the set through which shaders query the shadows of the last frame recorded.
    pub fn set(&self) -> vk::DescriptorSet {
        self.sets[self.frame as usize % self.sets.len()].handle
    }
}

/// Opens Gobo on the renderer's device.
pub fn adopt(gpu: &Gpu) -> Result<Context> {
    let adopt = Adopt {
        entry: gpu.instance.entry.clone(),
        instance: gpu.instance.handle.clone(),
        physical_device: gpu.physical,
        device: gpu.lent.clone(),
        queue_family: gpu.queue_family,
        enabled: gpu.enabled,
        allocator: Some((*gpu.allocator).clone()),
        frames_in_flight: FRAMES_IN_FLIGHT,
        messages: Messages::default(),
    };
    // SAFETY: these handles belong together, the device was opened with `enabled`, and `Renderer` closes Gobo first, when no frame is
    // running.
    Ok(unsafe { Context::adopt(adopt) }?)
}

/// Records the sun, whose position either the device or the host knows.
fn shine(world: &mut World, commands: &mut Commands, sun: Option<&Source>) -> Result<()> {
    let kind = LightKind::Directional { direction: -TO_SUN.as_dvec3().normalize() };
    let light = Light { kind, radiance: [1.0; 3], radius: f64::INFINITY };
    Ok(match sun {
        Some(source) => world.update_lights_from_buffer(commands, source, SUN_AT, &[LightType::Directional]),
        None => world.update_lights(commands, &[light]),
    }?)
}

/// Draws the smoke with Gobo's compute passes instead of the renderer's own shaders, for devices with a slow rasterizer.
pub struct Painter {
    /// Holds the picture: floats, premultiplied, in `VK_IMAGE_LAYOUT_GENERAL`.
    pub renderer: Renderer,
    kernels: Kernels,
    view: View,
}

impl Painter {
    /// Creates a painter for pictures of `size` pixels of the world's casters, lit by the technique.
    fn new(context: &Context, world: &World, technique: &dyn Technique, size: [u32; 2]) -> Result<Self> {
        let (position, target) = (EYE.as_dvec3(), MIDDLE.as_dvec3());
        let camera = Camera { position, target, up: glam::DVec3::Z, fov_y_degrees: f64::from(FOV_Y).to_degrees() };
        let view = View::perspective(&camera, [0.1, 200.0], size);
        let mut renderer = Renderer::new(context, world, &view)?;
        renderer.paint_by(Some(PainterKind::Compute));
        let kernels = renderer.kernels(&technique.answer(), Shading::Forward, Lighting::Fragment)?;
        Ok(Self { renderer, kernels, view })
    }
}
