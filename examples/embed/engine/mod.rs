//! A small renderer of smoke: particles that its own compute shader moves, drawn as blended squares over a ground, lit by one sun.

pub mod alone;
pub mod counted;
mod device;
mod frames;
mod memory;
mod pipelines;
mod shadows;
mod smoke_painter;
mod spirv;

pub use device::{Choice, Gpu, Optional};
pub use shadows::{How, Shadows};

use ash::vk;
use bytemuck::{Pod, Zeroable};
use frames::{FRAMES_IN_FLIGHT, Frames, barrier};
use glam::Vec3;
use glam::camera::rh::{proj::vulkan::perspective, view::look_at_mat4};
use gobo::gpu::PassTime;
use gpu_allocator::MemoryLocation;
use memory::{Buffer, Target, whole_image};
use pipelines::{Constants, Set};
use std::time::{Duration, Instant};

pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// As many as the shaders say.
pub const PARTICLES: u32 = 4096;

const PARTICLE_BYTES: usize = PARTICLES as usize * size_of::<Particle>();

/// Points that [`Engine::ask`] asks at, at most.
pub const MOST_POINTS: usize = 4096;

/// The way from the ground to the sun.
pub const TO_SUN: Vec3 = Vec3::new(-0.64, -0.32, 0.7);

/// By how much the device turns the sun about z, radians per second, where it does.
pub const TURN_PER_S: f32 = 0.4;

/// The camera: its place, what it looks at, and its angle from bottom to top, radians.
const EYE: Vec3 = Vec3::new(0.8, -5.2, 1.9);
const MIDDLE: Vec3 = Vec3::new(0.35, 0.0, 0.95);
const FOV_Y: f32 = 0.7;

/// The same camera as Gobo has it.
fn camera() -> gobo::scene::Camera {
    let fov_y_degrees = f64::from(FOV_Y).to_degrees();
    gobo::scene::Camera { position: EYE.as_dvec3(), target: MIDDLE.as_dvec3(), up: glam::DVec3::Z, fov_y_degrees }
}

/// Bytes of a particle as the shaders have it. Twin: Particle in shaders/scene.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Particle {
    pub position: [f32; 3],
    pub radius: f32,
    pub extinction: f32,
    /// 0 where it is new, 1 where it goes.
    pub age: f32,
}

/// The light as the device has it. Twin: Sun in shaders/scene.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Sun {
    pub direction: [f32; 3],
    pub radiance: [f32; 3],
}

/// A frame's numbers. Twin: Push in shaders/scene.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Push {
    clip: [[f32; 4]; 4],
    eye: Vec3,
    time_s: f32,
    to_light: Vec3,
    turn_per_s: f32,
}

/// How a renderer is opened.
#[derive(Clone, Debug)]
pub struct Options {
    pub how: How,
    pub choice: Choice,
    /// The device turns the sun, and the host does not know where it is.
    pub device_light: bool,
    /// Gobo makes the picture, of smoke and sky alone.
    pub painted: bool,
    /// The picture's width and height, pixels.
    pub size: [u32; 2],
}

/// Gobo goes before the device that it is open on: fields are dropped in this order.
pub struct Engine {
    shadows: Shadows,
    frames: Frames,
    move_particles: vk::Pipeline,
    sort: vk::Pipeline,
    ground: vk::Pipeline,
    smoke: vk::Pipeline,
    ask: vk::Pipeline,
    layout: vk::PipelineLayout,
    set: Set,
    particles: Buffer,
    sun: Buffer,
    points: Buffer,
    answers: Buffer,
    /// Where the host reads what the device has: particles or pixels.
    copy: Buffer,
    target: Target,
    turn_per_s: f32,
    /// The next that is recorded.
    frame: u64,
    /// The last that has shadows.
    shadowed: u64,
    recording: Duration,
    steps: Steps,
    gpu: Gpu,
}

impl Engine {
    pub fn open(options: &Options) -> Result<Self> {
        let mut steps = Steps::new();
        let mut opened = step(&mut steps, "instance and device", || Gpu::open(&options.choice))?;
        let gpu = &mut opened;
        let particles = Buffer::new(gpu, "particles", PARTICLE_BYTES, MemoryLocation::GpuOnly)?;
        // The particles' numbers, far to near.
        let order = Buffer::new(gpu, "order", PARTICLES as usize * 4, MemoryLocation::GpuOnly)?;
        let points = Buffer::new(gpu, "points", MOST_POINTS * 12, MemoryLocation::CpuToGpu)?;
        let answers = Buffer::new(gpu, "answers", MOST_POINTS * 4, MemoryLocation::GpuToCpu)?;
        let pixel_bytes = options.size.map(|side| side as usize).iter().product::<usize>() * 4;
        let sun = Buffer::new(gpu, "sun", size_of::<Sun>(), MemoryLocation::GpuOnly)?;
        let set = Set::of_buffers(gpu, &[&particles, &order, &points, &answers, &sun])?;
        // Frame 0 tells the device of the light.
        let mut frames = Frames::new(gpu)?;
        let commands = frames.begin(0)?;
        let theirs = (&particles, options.device_light.then_some(&sun));
        let mut shadows = Shadows::new(gpu, &options.how, theirs, (commands, 0), &mut steps)?;
        if options.painted {
            step(&mut steps, "painter", || shadows.paint(options.size))?;
        }
        frames.submit(0, false)?;

        let start = Instant::now();
        let layout = pipelines::layout(gpu, &[set.layout, shadows.layout()])?;
        let (asked, none) = (shadows.constants(), Constants::new(&[]));
        let shaders = spirv::Shaders::new(shadows.file())?;
        let draw = |gpu: &mut Gpu, vertex, fragment| {
            pipelines::draw(gpu, layout, [&shaders.compile(vertex)?[..], &shaders.compile(fragment)?[..]], &asked)
        };
        let move_particles = pipelines::compute(gpu, layout, &shaders.compile(spirv::MOVE)?, &none)?;
        let sort = pipelines::compute(gpu, layout, &shaders.compile(spirv::SORT)?, &none)?;
        let ground = draw(gpu, spirv::GROUND_VERT, spirv::GROUND_FRAG)?;
        let smoke = draw(gpu, spirv::SMOKE_VERT, spirv::SMOKE_FRAG)?;
        let ask = pipelines::compute(gpu, layout, &shaders.compile(spirv::ASK)?, &asked)?;
        steps.push(("the renderer's shaders and pipelines", start.elapsed()));
        Ok(Self {
            move_particles,
            sort,
            ground,
            smoke,
            ask,
            shadows,
            frames,
            layout,
            set,
            particles,
            sun,
            points,
            answers,
            copy: Buffer::new(gpu, "copy", PARTICLE_BYTES.max(pixel_bytes), MemoryLocation::GpuToCpu)?,
            target: Target::new(gpu, options.size)?,
            turn_per_s: if options.device_light { TURN_PER_S } else { 0.0 },
            frame: 1,
            shadowed: 0,
            recording: Duration::ZERO,
            steps,
            gpu: opened,
        })
    }

    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    pub fn shadows(&self) -> &Shadows {
        &self.shadows
    }

    /// How long the host took for Gobo's part of the last frame: settling, recording, writing the set.
    pub fn recording(&self) -> Duration {
        self.recording
    }

    /// What opening took the host, step by step.
    pub fn steps(&self) -> &Steps {
        &self.steps
    }

    /// Waits until all frames are over.
    pub fn wait(&self) -> Result<()> {
        self.frames.wait(self.frame - 1)
    }

    /// How long each of Gobo's passes took in the newest frame that is over.
    pub fn passes(&self) -> Vec<PassTime> {
        self.shadows.times(self.shadowed.saturating_sub(FRAMES_IN_FLIGHT.into()))
    }

    /// Records and submits one frame. Returns how long the steps of the frame before the last took, nanoseconds: moving and sorting,
    /// shadows, drawing.
    pub fn frame(&mut self, time_s: f32) -> Result<Option<[f64; 3]>> {
        let frame = self.frame;
        let commands = self.frames.begin(frame)?;
        let times = self.frames.times(frame)?;

        // The frame before may still be drawing from these buffers.
        barrier(&self.gpu.device, commands);
        self.frames.stamp(frame, 0);
        let push = self.push(time_s);
        self.bind(commands, &push, &[self.set.handle]);
        self.dispatch(commands, self.move_particles, PARTICLES / 64);
        barrier(&self.gpu.device, commands);
        self.dispatch(commands, self.sort, 1);
        self.frames.stamp(frame, 1);

        // Gobo's passes begin and end with barriers for all that is around them. They bind what they need, and undo what is bound.
        let start = Instant::now();
        if let Some(over) = frame.checked_sub(FRAMES_IN_FLIGHT.into()) {
            self.shadows.settle(over)?;
        }
        self.shadows.record(commands, frame)?;
        self.recording = start.elapsed();
        self.frames.stamp(frame, 2);
        match self.shadows.painted() {
            Some(image) => self.show(commands, image.handle()),
            None => {
                self.bind(commands, &push, &[self.set.handle, self.shadows.set(frame)]);
                self.draw(commands);
            }
        }
        self.frames.stamp(frame, 3);

        self.frames.submit(frame, true)?;
        self.shadowed = frame;
        self.frame += 1;
        Ok(times)
    }

    fn push(&self, time_s: f32) -> Push {
        let (eye, middle) = (EYE, MIDDLE);
        let aspect = self.target.size[0] as f32 / self.target.size[1] as f32;
        let clip = perspective(FOV_Y, aspect, 0.1, 200.0) * look_at_mat4(eye, middle, Vec3::Z);
        let to_light = TO_SUN.normalize();
        Push { clip: clip.to_cols_array_2d(), eye, time_s, to_light, turn_per_s: self.turn_per_s }
    }

    fn bind(&self, commands: vk::CommandBuffer, push: &Push, sets: &[vk::DescriptorSet]) {
        let (device, layout) = (&self.gpu.device, self.layout);
        for point in [vk::PipelineBindPoint::COMPUTE, vk::PipelineBindPoint::GRAPHICS] {
            // SAFETY: the commands are being recorded, and the sets are of this layout.
            unsafe { device.cmd_bind_descriptor_sets(commands, point, layout, 0, sets, &[]) };
        }
        // SAFETY: the layout takes these bytes.
        unsafe { device.cmd_push_constants(commands, layout, vk::ShaderStageFlags::ALL, 0, bytemuck::bytes_of(push)) };
    }

    fn dispatch(&self, commands: vk::CommandBuffer, pipeline: vk::Pipeline, groups: u32) {
        // SAFETY: the commands are being recorded, and all that the shader uses is bound.
        unsafe {
            self.gpu.device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::COMPUTE, pipeline);
            self.gpu.device.cmd_dispatch(commands, groups, 1, 1);
        }
    }

    /// The ground hides the sky, the smoke what is behind it, so that no depth has to be kept.
    fn draw(&self, commands: vk::CommandBuffer) {
        let (device, [width, height]) = (&self.gpu.device, self.target.size);
        let area = vk::Rect2D { extent: vk::Extent2D { width, height }, ..Default::default() };
        let viewport =
            vk::Viewport { width: width as f32, height: height as f32, max_depth: 1.0, ..Default::default() };
        let sky = vk::ClearValue { color: vk::ClearColorValue { float32: [0.36, 0.46, 0.62, 1.0] } };
        let attachments = [vk::RenderingAttachmentInfo::default()
            .image_view(self.target.view)
            .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)
            .clear_value(sky)];
        let rendering = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&attachments);
        self.change_layout(commands, vk::ImageLayout::UNDEFINED, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
        // SAFETY: the commands are being recorded, and all that the shaders use is bound.
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

    /// Takes over a picture of as many pixels, in `VK_IMAGE_LAYOUT_GENERAL`.
    fn show(&self, commands: vk::CommandBuffer, from: vk::Image) {
        let [width, height] = self.target.size;
        let layers = vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
        let corners = [vk::Offset3D::default(), vk::Offset3D { x: width as i32, y: height as i32, z: 1 }];
        let regions = [vk::ImageBlit::default()
            .src_subresource(layers)
            .src_offsets(corners)
            .dst_subresource(layers)
            .dst_offsets(corners)];
        let (general, to) = (vk::ImageLayout::GENERAL, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        self.change_layout(commands, vk::ImageLayout::UNDEFINED, to);
        // SAFETY: the commands are being recorded, outside a render; both images are as large, and Gobo's passes end with a barrier.
        unsafe {
            let target = self.target.image;
            self.gpu.device.cmd_blit_image(commands, from, general, target, to, &regions, vk::Filter::NEAREST);
        }
        self.change_layout(commands, to, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
    }

    fn change_layout(&self, commands: vk::CommandBuffer, from: vk::ImageLayout, to: vk::ImageLayout) {
        let (all, write) = (vk::PipelineStageFlags2::ALL_COMMANDS, vk::AccessFlags2::MEMORY_WRITE);
        let barriers = [vk::ImageMemoryBarrier2::default()
            .src_stage_mask(all)
            .src_access_mask(write)
            .dst_stage_mask(all)
            .dst_access_mask(write | vk::AccessFlags2::MEMORY_READ)
            .old_layout(from)
            .new_layout(to)
            .image(self.target.image)
            .subresource_range(whole_image())];
        let info = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: the commands are being recorded, outside a render.
        unsafe { self.gpu.device.cmd_pipeline_barrier2(commands, &info) };
    }

    /// The picture of the last frame: bytes of RGBA, rows from the top.
    pub fn picture(&mut self) -> Result<Vec<u8>> {
        let [width, height] = self.target.size;
        self.run(|engine, commands| {
            let (drawn, copied) = (vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL, vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
            engine.change_layout(commands, drawn, copied);
            let layers = vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
            let region = vk::BufferImageCopy::default().image_subresource(layers).image_extent(vk::Extent3D {
                width,
                height,
                depth: 1,
            });
            let (device, image) = (&engine.gpu.device, engine.target.image);
            // SAFETY: the buffer has room for all pixels.
            unsafe { device.cmd_copy_image_to_buffer(commands, image, copied, engine.copy.handle, &[region]) };
        })?;
        let mut pixels = self.copy.read()?;
        pixels.truncate((width * height * 4) as usize);
        Ok(pixels)
    }

    /// The particles of the last frame.
    pub fn particles(&mut self) -> Result<Vec<Particle>> {
        self.copied(|engine| &engine.particles)
    }

    /// Whether the device turns the sun.
    pub fn turns_sun(&self) -> bool {
        self.turn_per_s != 0.0
    }

    /// The sun of the last frame.
    pub fn sun(&mut self) -> Result<Sun> {
        Ok(self.copied(|engine| &engine.sun)?[0])
    }

    /// What the device has in a buffer.
    fn copied<T: Pod>(&mut self, which: impl Fn(&Self) -> &Buffer) -> Result<Vec<T>> {
        self.run(|engine, commands| {
            let from = which(engine);
            let region = vk::BufferCopy::default().size(from.bytes);
            // SAFETY: what is copied to has room for it.
            unsafe { engine.gpu.device.cmd_copy_buffer(commands, from.handle, engine.copy.handle, &[region]) };
        })?;
        let mut bytes = self.copy.read::<u8>()?;
        bytes.truncate(which(self).bytes as usize);
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// How much of the sun reaches each point, at most [`MOST_POINTS`], by the shadows of the last frame.
    pub fn ask(&mut self, points: &[[f32; 3]]) -> Result<Vec<f32>> {
        self.points.write(points)?;
        let push = self.push(0.0);
        self.run(|engine, commands| {
            engine.bind(commands, &push, &[engine.set.handle, engine.shadows.set(engine.shadowed)]);
            engine.dispatch(commands, engine.ask, (MOST_POINTS / 64) as u32);
        })?;
        let mut answers = self.answers.read()?;
        answers.truncate(points.len());
        Ok(answers)
    }

    /// Runs commands by themselves, after all frames, and waits until the host sees what they wrote.
    fn run(&mut self, record: impl FnOnce(&Self, vk::CommandBuffer)) -> Result<()> {
        let frame = self.frame;
        let commands = self.frames.begin(frame)?;
        barrier(&self.gpu.device, commands);
        record(self, commands);
        let (all, write) = (vk::PipelineStageFlags2::ALL_COMMANDS, vk::AccessFlags2::MEMORY_WRITE);
        let barriers = [vk::MemoryBarrier2::default()
            .src_stage_mask(all)
            .src_access_mask(write)
            .dst_stage_mask(vk::PipelineStageFlags2::HOST)
            .dst_access_mask(vk::AccessFlags2::HOST_READ)];
        let info = vk::DependencyInfo::default().memory_barriers(&barriers);
        // SAFETY: the commands are being recorded, outside a render.
        unsafe { self.gpu.device.cmd_pipeline_barrier2(commands, &info) };
        self.frames.submit(frame, false)?;
        self.frame += 1;
        self.frames.wait(frame)?;
        // The last frame is over too.
        self.shadows.settle(self.shadowed)
    }
}

/// What each step took the host.
pub type Steps = Vec<(&'static str, Duration)>;

/// Does one step more.
pub fn step<T>(steps: &mut Steps, name: &'static str, what: impl FnOnce() -> Result<T>) -> Result<T> {
    let start = Instant::now();
    let done = what()?;
    steps.push((name, start.elapsed()));
    Ok(done)
}

impl Drop for Engine {
    fn drop(&mut self) {
        // SAFETY: nothing is submitted any more. Gobo is closed when no frame runs.
        let _ = unsafe { self.gpu.device.device_wait_idle() };
    }
}
