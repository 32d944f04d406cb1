//! Smoke particles that a compute shader moves, drawn as blended squares over a ground, lit by one sun.

mod device;
pub mod frames;
pub mod memory;
pub mod pipelines;
pub mod shadows;

pub use device::{Gpu, Instance};
pub use shadows::Shadows;

use ash::vk;
use bytemuck::{Pod, Zeroable};
use frames::{FRAMES_IN_FLIGHT, Frames, barrier};
use glam::Vec3;
use glam::camera::rh::{proj::vulkan::perspective, view::look_at_mat4};
use gobo::technique::Spec;
use gpu_allocator::MemoryLocation;
use memory::{Buffer, Set, Target, whole_image, whole_layer};
use pipelines::Pipelines;

pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Twin: PARTICLES in shaders/scene.glsl.
pub const PARTICLES: u32 = 4096;

/// Vector from the ground towards the sun.
pub const TO_SUN: Vec3 = Vec3::new(-0.64, -0.32, 0.7);

/// The camera: its position, its target, and its vertical angle of view in radians.
const EYE: Vec3 = Vec3::new(0.8, -5.2, 1.9);
const MIDDLE: Vec3 = Vec3::new(0.35, 0.0, 0.95);
const FOV_Y: f32 = 0.7;

/// Bytes per particle, and of the sun, in shaders/scene.glsl.
pub const PARTICLE_BYTES: u32 = 24;
pub const SUN_BYTES: u32 = 24;

/// Per-frame constants. Twin: Push in shaders/scene.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Push {
    clip: [[f32; 4]; 4],
    eye: Vec3,
    time_s: f32,
    to_light: Vec3,
    turn_per_s: f32,
}

/// Options for opening a renderer.
#[derive(Clone)]
pub struct Options {
    /// Technique that computes the shadows.
    pub technique: Spec,
    /// Rate at which the device turns the sun about z, in radians per second. If it is not 0, the host does not know where the sun is.
    pub turn_per_s: f32,
    /// Whether Gobo draws the picture, of smoke and sky alone.
    pub painted: bool,
    /// Width and height of the picture, in pixels.
    pub size: [u32; 2],
}

/// Fields are dropped in this order, so that Gobo is closed before its device.
pub struct Renderer {
    pub shadows: Shadows,
    pub frames: Frames,
    advance: vk::Pipeline,
    sort: vk::Pipeline,
    ground: vk::Pipeline,
    smoke: vk::Pipeline,
    layout: vk::PipelineLayout,
    set: Set,
    pixels: Buffer,
    target: Target,
    turn_per_s: f32,
    pub gpu: Gpu,
}

impl Renderer {
    pub fn new(mut opened: Gpu, options: &Options) -> Result<Self> {
        let gpu = &mut opened;
        let particles = Buffer::new(gpu, "particles", PARTICLES * PARTICLE_BYTES, MemoryLocation::GpuOnly)?;
        // Indices of the particles, far to near.
        let order = Buffer::new(gpu, "order", PARTICLES * 4, MemoryLocation::GpuOnly)?;
        let sun = Buffer::new(gpu, "sun", SUN_BYTES, MemoryLocation::GpuOnly)?;
        let set = Set::of_buffers(gpu, &[&particles, &order, &sun])?;
        let pixels = Buffer::new(gpu, "pixels", options.size[0] * options.size[1] * 4, MemoryLocation::GpuToCpu)?;
        let target = Target::new(gpu, options.size)?;

        // Frame 0 uploads the light to the device.
        let mut frames = Frames::new(gpu)?;
        let commands = frames.begin()?;
        let shadows = Shadows::new(gpu, options, [&particles, &sun], commands)?;
        frames.submit()?;

        let sets = [set.layout, shadows.sets[0].layout];
        let mut pipelines = Pipelines::new(gpu, &sets, shadows.technique.answer())?;
        let advance = pipelines.compute(pipelines::MOVE)?;
        let sort = pipelines.compute(pipelines::SORT)?;
        let ground = pipelines.graphics(pipelines::GROUND_VERT, pipelines::GROUND_FRAG)?;
        let smoke = pipelines.graphics(pipelines::SMOKE_VERT, pipelines::SMOKE_FRAG)?;
        let (layout, turn_per_s) = (pipelines.layout, options.turn_per_s);
        Ok(Self { shadows, frames, advance, sort, ground, smoke, layout, set, pixels, target, turn_per_s, gpu: opened })
    }

    /// Records and submits one frame.
    pub fn frame(&mut self, time_s: f32) -> Result<()> {
        let commands = self.frames.begin()?;
        self.simulate(commands, time_s);
        self.shadow(commands)?;
        self.draw(commands);
        self.frames.submit()
    }

    /// Moves the particles and the sun to their positions at a given time, and sorts the particles.
    pub fn simulate(&self, commands: vk::CommandBuffer, time_s: f32) {
        self.bind(commands, time_s, &[self.set.handle]);
        let (device, compute) = (&self.gpu.device, vk::PipelineBindPoint::COMPUTE);
        // SAFETY: the commands are being recorded, outside rendering, and everything that the pipelines use is bound.
        unsafe {
            device.cmd_bind_pipeline(commands, compute, self.advance);
            device.cmd_dispatch(commands, PARTICLES / 64, 1, 1);
            barrier(device, commands);
            device.cmd_bind_pipeline(commands, compute, self.sort);
            device.cmd_dispatch(commands, 1, 1, 1);
        }
    }

    /// Records Gobo's passes. They start and end with barriers against all commands before and after them, and overwrite the pipeline and
    /// descriptor bindings.
    pub fn shadow(&mut self, commands: vk::CommandBuffer) -> Result<()> {
        let frame = self.frames.next;
        self.shadows.settle(frame.saturating_sub(FRAMES_IN_FLIGHT.into()))?;
        self.shadows.record(commands, frame)
    }

    /// Draws the picture, or copies the one that Gobo has painted.
    pub fn draw(&self, commands: vk::CommandBuffer) {
        self.discard(commands);
        match &self.shadows.painter {
            Some(painter) => self.copy(commands, painter.renderer.image().handle()),
            None => self.rasterize(commands),
        }
    }

    /// Runs commands on their own, after all frames, and waits until the host sees what they wrote.
    pub fn run(&mut self, record: impl FnOnce(&Self, vk::CommandBuffer)) -> Result<()> {
        let commands = self.frames.begin()?;
        record(self, commands);
        barrier(&self.gpu.device, commands);
        self.frames.submit()?;
        // By then the last frame with shadows has finished too.
        self.frames.wait(self.frames.next - 1)?;
        self.shadows.settle(self.shadows.frame)
    }

    /// Returns the picture of the last frame: RGBA bytes, rows from the top.
    pub fn picture(&mut self) -> Result<Vec<u8>> {
        self.run(|renderer, commands| {
            let (target, [width, height]) = (&renderer.target, renderer.target.size);
            let extent = vk::Extent3D { width, height, depth: 1 };
            let region = [vk::BufferImageCopy::default().image_subresource(whole_layer()).image_extent(extent)];
            let (device, to) = (&renderer.gpu.device, renderer.pixels.handle);
            // SAFETY: the buffer has room for all pixels.
            unsafe { device.cmd_copy_image_to_buffer(commands, target.image, Target::LAYOUT, to, &region) };
        })?;
        self.pixels.read()
    }

    /// Binds sets and pushes the per-frame constants.
    fn bind(&self, commands: vk::CommandBuffer, time_s: f32, sets: &[vk::DescriptorSet]) {
        let aspect = self.target.size[0] as f32 / self.target.size[1] as f32;
        let clip = perspective(FOV_Y, aspect, 0.1, 200.0) * look_at_mat4(EYE, MIDDLE, Vec3::Z);
        let (clip, to_light, turn_per_s) = (clip.to_cols_array_2d(), TO_SUN.normalize(), self.turn_per_s);
        let push = Push { clip, eye: EYE, time_s, to_light, turn_per_s };
        let (device, layout, all) = (&self.gpu.device, self.layout, vk::ShaderStageFlags::ALL);
        // SAFETY: the commands are being recorded, and the sets and constants match this layout.
        unsafe {
            device.cmd_push_constants(commands, layout, all, 0, bytemuck::bytes_of(&push));
            for point in [vk::PipelineBindPoint::COMPUTE, vk::PipelineBindPoint::GRAPHICS] {
                device.cmd_bind_descriptor_sets(commands, point, layout, 0, sets, &[]);
            }
        }
    }

    /// Draws the ground over the sky, and the smoke over what is behind it, so that no depth buffer is needed.
    fn rasterize(&self, commands: vk::CommandBuffer) {
        let (device, [width, height]) = (&self.gpu.device, self.target.size);
        let area = vk::Rect2D { extent: vk::Extent2D { width, height }, ..Default::default() };
        let (width, height) = (width as f32, height as f32);
        let viewport = vk::Viewport { width, height, max_depth: 1.0, ..Default::default() };
        let sky = vk::ClearValue { color: vk::ClearColorValue { float32: [0.36, 0.46, 0.62, 1.0] } };
        let attachment = vk::RenderingAttachmentInfo::default().image_view(self.target.view).clear_value(sky);
        let attachment = attachment.load_op(vk::AttachmentLoadOp::CLEAR).store_op(vk::AttachmentStoreOp::STORE);
        let attachments = [attachment.image_layout(Target::LAYOUT)];
        let rendering = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&attachments);
        // Set 1 is Gobo's, through which the fragment shaders query the shadows.
        self.bind(commands, 0.0, &[self.set.handle, self.shadows.set()]);
        // SAFETY: the commands are being recorded, and everything that the shaders use is bound.
        unsafe {
            device.cmd_begin_rendering(commands, &rendering);
            device.cmd_set_viewport(commands, 0, &[viewport]);
            device.cmd_set_scissor(commands, 0, &[area]);
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, self.ground);
            device.cmd_draw(commands, 6, 1, 0, 0);
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, self.smoke);
            device.cmd_draw(commands, 6 * PARTICLES, 1, 0, 0);
            device.cmd_end_rendering(commands);
        }
    }

    /// Copies a picture of the same size, in `VK_IMAGE_LAYOUT_GENERAL`.
    fn copy(&self, commands: vk::CommandBuffer, from: vk::Image) {
        let (to, layout, [width, height]) = (self.target.image, Target::LAYOUT, self.target.size);
        let corners = [vk::Offset3D::default(), vk::Offset3D { x: width as i32, y: height as i32, z: 1 }];
        let blit = vk::ImageBlit::default().src_subresource(whole_layer()).dst_subresource(whole_layer());
        let blit = [blit.src_offsets(corners).dst_offsets(corners)];
        // SAFETY: the commands are being recorded, outside rendering; both images have the same size, and Gobo's passes end with a barrier.
        unsafe { self.gpu.device.cmd_blit_image(commands, from, layout, to, layout, &blit, vk::Filter::NEAREST) };
    }

    /// Transitions the target into its layout. Its pixels are lost, and all of them are drawn again.
    fn discard(&self, commands: vk::CommandBuffer) {
        let (all, write) = (vk::PipelineStageFlags2::ALL_COMMANDS, vk::AccessFlags2::MEMORY_WRITE);
        let barrier = vk::ImageMemoryBarrier2::default().image(self.target.image).subresource_range(whole_image());
        let barrier = barrier.old_layout(vk::ImageLayout::UNDEFINED).new_layout(Target::LAYOUT);
        let barrier = barrier.src_stage_mask(all).src_access_mask(write);
        let barriers = [barrier.dst_stage_mask(all).dst_access_mask(write | vk::AccessFlags2::MEMORY_READ)];
        let info = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: the commands are being recorded, outside rendering.
        unsafe { self.gpu.device.cmd_pipeline_barrier2(commands, &info) };
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        // SAFETY: nothing is submitted any more. Gobo is closed once no frame is running.
        let _ = unsafe { self.gpu.device.device_wait_idle() };
    }
}
