//! All of Gobo's part. It shadows the particles by what it records into the renderer's command buffers, and hands over a set of
//! descriptors, by which the renderer's shaders ask how much of the sun reaches a point.

use super::memory::Buffer;
use super::pipelines::{Constants, Set};
use super::smoke_painter::SmokePainter;
use super::{FRAMES_IN_FLIGHT, Gpu, PARTICLES, Particle, Result, Steps, Sun, TO_SUN, step};
use ash::vk;
use gobo::gpu::{Adopt, Commands, Context, Messages, PassTime};
use gobo::scene::{Light, LightKind, Scene};
use gobo::technique::{Avsm, BeerShadowMap, BuildStatus, Psm, Technique, avsm, beer_shadow_map, psm};
use gobo::world::{Capacity, Count, LightAt, LightType, Number, Source, SphereAt, World};

/// Which technique casts the shadows, and how.
#[derive(Clone, Debug)]
pub enum How {
    Avsm(avsm::Settings),
    Psm(psm::Settings),
    BeerShadowMap(beer_shadow_map::Settings),
}

/// Fields are dropped in this order: what was made last goes first.
pub struct Shadows {
    /// The smoke's picture, where Gobo makes it.
    painter: Option<SmokePainter>,
    technique: Box<dyn Technique>,
    world: World,
    /// None: a scene of the program's, all of which is taken to have moved in each frame.
    particles: Option<Source>,
    /// Where the device alone knows it.
    sun: Option<Source>,
    context: Context,
    /// One for each frame in flight: a set that the device may be reading is not written.
    sets: Vec<Set>,
    /// Frames after which a buffer of Gobo's grew.
    pub grew: u64,
}

impl Shadows {
    /// Opens Gobo on the renderer's device, for its particles and, where the device alone knows it, its sun. The commands are being
    /// recorded as that frame.
    pub fn new(
        gpu: &mut Gpu,
        how: &How,
        (particles, sun): (&Buffer, Option<&Buffer>),
        (commands, frame): (vk::CommandBuffer, u64),
        steps: &mut Steps,
    ) -> Result<Self> {
        let context = step(steps, "adopt", || adopt(gpu))?;
        let capacity = Capacity { particles: PARTICLES, lights: 1, ..Capacity::default() };
        let mut world = step(steps, "world", || Ok(World::of(&context, capacity)?))?;

        // SAFETY: the buffers are the device's, are as large, are made for storage, and are kept longer than Gobo.
        let adopt = |name, of: &Buffer| unsafe { gobo::gpu::Buffer::adopt(&context, name, of.handle, of.bytes) };
        let stride = size_of::<Particle>() as u32;
        let particles =
            Source { buffer: adopt("particles", particles)?, offset: 0, stride, count: Count::Host(PARTICLES) };
        let sun = sun.map(|sun| adopt("sun", sun)).transpose()?;
        let stride = size_of::<Sun>() as u32;
        let sun = sun.map(|buffer| Source { buffer, offset: 0, stride, count: Count::Host(1) });

        // The lights come before the technique, which is opened for so many.
        // SAFETY: the commands are being recorded, outside a render, for this frame; no frame came before it.
        let mut commands = unsafe { Commands::on(&context, commands, frame) }?;
        shine(&mut world, &mut commands, sun.as_ref())?;
        commands.end();
        Self::open(gpu, how, context, world, (Some(particles), sun), steps)
    }

    /// Opens Gobo for a scene that the host knows, with the lights that are in it.
    pub fn of_scene(gpu: &mut Gpu, how: &How, scene: &Scene, steps: &mut Steps) -> Result<Self> {
        let context = step(steps, "adopt", || adopt(gpu))?;
        let world = step(steps, "world", || Ok(World::new(&context, scene)?))?;
        Self::open(gpu, how, context, world, (None, None), steps)
    }

    fn open(
        gpu: &mut Gpu,
        how: &How,
        context: Context,
        world: World,
        (particles, sun): (Option<Source>, Option<Source>),
        steps: &mut Steps,
    ) -> Result<Self> {
        let technique = step(steps, "technique", || -> Result<Box<dyn Technique>> {
            Ok(match how {
                How::Avsm(settings) => Box::new(Avsm::new(&context, &world, settings)?),
                How::Psm(settings) => Box::new(Psm::new(&context, &world, settings)?),
                How::BeerShadowMap(settings) => Box::new(BeerShadowMap::new(&context, &world, settings)?),
            })
        })?;
        let bindings = technique.answer().layout(0);
        let sets = (0..FRAMES_IN_FLIGHT).map(|_| Set::new(gpu, &bindings)).collect::<Result<_>>()?;
        Ok(Self { painter: None, technique, world, particles, sun, context, sets, grew: 0 })
    }

    /// Makes pictures of `size` pixels too, from the next frame on.
    pub fn paint(&mut self, size: [u32; 2]) -> Result<()> {
        self.painter = Some(SmokePainter::new(&self.context, &self.world, self.technique.as_ref(), size)?);
        Ok(())
    }

    /// The picture of the last frame, where Gobo makes it.
    pub fn painted(&self) -> Option<&gobo::gpu::Image> {
        self.painter.as_ref().map(SmokePainter::image)
    }

    /// The layout of the set that [`Shadows::set`] hands out.
    pub fn layout(&self) -> vk::DescriptorSetLayout {
        self.sets[0].layout
    }

    /// What the shaders that ask include.
    pub fn file(&self) -> &'static gobo::glsl::File {
        self.technique.answer().file()
    }

    /// How the shaders that ask have to be specialized.
    pub fn constants(&self) -> Constants {
        Constants::new(&self.technique.answer().specialization(0))
    }

    /// Takes what frame `frame`, which is over, says: whether something did not fit. It has room by now, for the frame that is recorded
    /// next; until then its shadows lack what did not fit.
    pub fn settle(&mut self, frame: u64) -> Result<()> {
        let lacked = self.painter.as_ref().map_or(Ok(false), |painter| painter.settle(frame))?;
        self.grew += u64::from(self.technique.settle(frame)? == BuildStatus::Retry || lacked);
        Ok(())
    }

    /// Records the shadows of the particles as the commands before have moved them. Those that follow may ask.
    pub fn record(&mut self, commands: vk::CommandBuffer, frame: u64) -> Result<()> {
        // SAFETY: the commands are being recorded, outside a render, for this frame, are submitted once and in order, and
        // `Frames::begin` waited for the frame that is `FRAMES_IN_FLIGHT` before.
        let mut commands = unsafe { Commands::on(&self.context, commands, frame) }?;
        if let Some(particles) = &self.particles {
            shine(&mut self.world, &mut commands, self.sun.as_ref())?;
            self.world.update_particles(&mut commands, particles, SphereAt::PARTICLE)?;
        } else {
            self.world.casters_move()?;
            self.technique.forget();
        }
        self.technique.record(&mut commands, &self.world)?;
        if let Some(painter) = &mut self.painter {
            painter.record(&mut commands, &self.world)?;
        }
        commands.end();
        // A buffer that grew is another buffer, so that the set is written each frame.
        // SAFETY: the set has these bindings, and the frame that used it is over.
        unsafe { self.technique.answer().write_into(self.set(frame), 0) };
        Ok(())
    }

    /// What shaders of that frame ask by.
    pub fn set(&self, frame: u64) -> vk::DescriptorSet {
        self.sets[(frame % u64::from(FRAMES_IN_FLIGHT)) as usize].handle
    }

    /// How long each pass of a frame took that is over.
    pub fn times(&self, frame: u64) -> Vec<PassTime> {
        self.context.times(frame)
    }

    /// Bytes of the device's memory that Gobo holds.
    pub fn bytes(&self) -> u64 {
        self.context.allocated_bytes()
    }
}

/// Gobo, on the renderer's device.
fn adopt(gpu: &Gpu) -> Result<Context> {
    let (entry, instance) = gpu.origin();
    let adopt = Adopt {
        entry,
        instance,
        physical_device: gpu.physical,
        device: gpu.counted.0.clone(),
        queue_family: gpu.queue_family,
        enabled: gpu.enabled,
        allocator: Some(gpu.allocator()?),
        frames_in_flight: FRAMES_IN_FLIGHT,
        messages: Messages::default(),
    };
    // SAFETY: all of these belong together, the device was opened with `enabled`, and `Engine` closes Gobo first, when no frame runs any
    // more.
    Ok(unsafe { Context::adopt(adopt) }?)
}

/// Where the device's sun has what Gobo reads; a sun is nowhere.
const SUN_AT: LightAt =
    LightAt { position: 0, direction: 0, radiance: 12, radius: Number::Is(f32::INFINITY), cos_cone: Number::Is(0.0) };

/// Records the renderer's light, which the device knows or the host.
fn shine(world: &mut World, commands: &mut Commands, sun: Option<&Source>) -> Result<()> {
    let recorded = match sun {
        Some(source) => world.update_lights_from_buffer(commands, source, SUN_AT, &[LightType::Directional]),
        None => world.update_lights(commands, &[host_sun()]),
    };
    recorded.map_err(Into::into)
}

/// The renderer's one light.
fn host_sun() -> Light {
    let direction = -TO_SUN.as_dvec3().normalize();
    Light { kind: LightKind::Directional { direction }, radiance: [1.0; 3], radius: f64::INFINITY }
}
