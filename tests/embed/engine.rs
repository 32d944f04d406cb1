//! The renderer of examples/engine set up for tests: under the validation layer, on a device that counts Gobo's calls, and with a test
//! shader that looks up the sun's visibility.

use crate::renderer::memory::{Buffer, Set};
use crate::renderer::pipelines::{Pipelines, Shader};
use crate::renderer::{Gpu, Instance, Options, PARTICLE_BYTES, PARTICLES, Renderer, Result, SUN_BYTES};
use crate::support::counted::{Counts, counted};
use crate::support::messenger::{Messenger, Said};
use ash::vk;
use bytemuck::{Pod, Zeroable};
use gobo::gpu::Enabled;
use gpu_allocator::MemoryLocation;
use std::rc::Rc;

/// Largest number of points for [`Engine::ask`].
pub const MOST_POINTS: u32 = 4096;

const ASK: Shader = ("ask.comp", include_str!("ask.comp"), shaderc::ShaderKind::Compute);

/// Twin: Particle in examples/engine/shaders/scene.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Particle {
    pub position: [f32; 3],
    pub radius: f32,
    pub extinction: f32,
    /// 0 for a new particle, 1 for one about to vanish.
    pub age: f32,
}

/// Twin: Sun in examples/engine/shaders/scene.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Sun {
    pub direction: [f32; 3],
    pub radiance: [f32; 3],
}

const _: () = assert!(size_of::<Particle>() == PARTICLE_BYTES as usize && size_of::<Sun>() == SUN_BYTES as usize);

/// Optional device features that are enabled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Optional {
    /// All features that Gobo can use and the device has.
    All,
    /// All except VK_EXT_fragment_shader_interlock.
    NoInterlock,
    Nothing,
}

/// Options for opening an engine.
#[derive(Clone)]
pub struct Setup {
    pub options: Options,
    pub optional: Optional,
    pub timestamps: bool,
    pub validation: bool,
}

/// Fields drop in this order: the layer may send messages until the device is closed.
pub struct Engine {
    pub renderer: Renderer,
    /// Counts of Gobo's calls that submit or wait.
    pub counts: Counts,
    pub said: Said,
    points: Buffer,
    answers: Buffer,
    /// Buffer for the host to read results of the device.
    copy: Buffer,
    ask: vk::Pipeline,
    layout: vk::PipelineLayout,
    set: Set,
    _messenger: Option<Messenger>,
    _instance: Rc<Instance>,
}

impl Engine {
    pub fn open(setup: &Setup) -> Result<Self> {
        let instance = Instance::new(setup.validation)?;
        let said = Said::default();
        let messenger = setup.validation.then(|| Messenger::new(&instance.entry, &instance.handle, &said));
        let mut gpu = Gpu::new(&instance, |all| {
            let enabled = match setup.optional {
                Optional::All => all,
                Optional::NoInterlock => Enabled { fragment_shader_pixel_interlock: false, ..all },
                Optional::Nothing => Enabled::FLOOR,
            };
            Enabled { timestamps: setup.timestamps, ..enabled }
        })?;
        // SAFETY: the handles belong together, and the instance has Vulkan 1.3.
        let (lent, counts) = unsafe { counted(&instance.entry, &instance.handle, &gpu.device, gpu.queue) };
        gpu.lent = lent;
        let mut renderer = Renderer::new(gpu, &setup.options)?;
        let gpu = &mut renderer.gpu;
        let points = Buffer::new(gpu, "points", MOST_POINTS * 12, MemoryLocation::CpuToGpu)?;
        let answers = Buffer::new(gpu, "answers", MOST_POINTS * 4, MemoryLocation::GpuToCpu)?;
        let copy = Buffer::new(gpu, "copy", PARTICLES * PARTICLE_BYTES, MemoryLocation::GpuToCpu)?;
        let set = Set::of_buffers(gpu, &[&points, &answers])?;
        let sets = [set.layout, renderer.shadows.sets[0].layout];
        let mut pipelines = Pipelines::new(gpu, &sets, renderer.shadows.technique.answer())?;
        let (ask, layout) = (pipelines.compute(ASK)?, pipelines.layout);
        Ok(Self {
            renderer,
            counts,
            said,
            points,
            answers,
            copy,
            ask,
            layout,
            set,
            _messenger: messenger,
            _instance: instance,
        })
    }

    /// Returns the number of bytes that the renderer and Gobo hold together.
    pub fn allocated_bytes(&self) -> u64 {
        self.renderer.gpu.allocator.lock().expect("it is whole").generate_report().total_allocated_bytes
    }

    /// Returns the particles of the last frame.
    pub fn particles(&mut self) -> Result<Vec<Particle>> {
        let from = self.renderer.shadows.particles.buffer.handle();
        self.copied(from, PARTICLES as usize)
    }

    /// Returns the sun of the last frame, if only the device knows it.
    pub fn sun(&mut self) -> Result<Sun> {
        let from = self.renderer.shadows.sun.as_ref().ok_or("the host knows the sun")?.buffer.handle();
        Ok(self.copied(from, 1)?[0])
    }

    /// Reads back a device buffer.
    fn copied<T: Pod>(&mut self, from: vk::Buffer, count: usize) -> Result<Vec<T>> {
        let (bytes, to) = (count * size_of::<T>(), self.copy.handle);
        self.renderer.run(|renderer, commands| {
            let region = vk::BufferCopy::default().size(bytes as u64);
            // SAFETY: both buffers have at least this many bytes.
            unsafe { renderer.gpu.device.cmd_copy_buffer(commands, from, to, &[region]) };
        })?;
        Ok(bytemuck::pod_collect_to_vec(&self.copy.read::<u8>()?[..bytes]))
    }

    /// Returns the sun's visibility at each point, at most [`MOST_POINTS`] of them, from the shadows of the last frame.
    pub fn ask(&mut self, points: &[[f32; 3]]) -> Result<Vec<f32>> {
        assert!(points.len() <= MOST_POINTS as usize);
        let to = self.points.mapped.ok_or("the host cannot write there")?;
        // SAFETY: the memory stays mapped as long as the device is open, is large enough for all points, and no frame is reading it.
        unsafe { std::ptr::copy_nonoverlapping(points.as_ptr(), to.as_ptr().cast(), points.len()) };
        let (ask, layout, set, compute) = (self.ask, self.layout, self.set.handle, vk::PipelineBindPoint::COMPUTE);
        self.renderer.run(|renderer, commands| {
            let (device, sets) = (&renderer.gpu.device, [set, renderer.shadows.set()]);
            // SAFETY: the commands are being recorded, and everything that the shader uses is bound.
            unsafe {
                device.cmd_bind_descriptor_sets(commands, compute, layout, 0, &sets, &[]);
                device.cmd_bind_pipeline(commands, compute, ask);
                device.cmd_dispatch(commands, MOST_POINTS / 64, 1, 1);
            }
        })?;
        let mut answers = self.answers.read()?;
        answers.truncate(points.len());
        Ok(answers)
    }
}
