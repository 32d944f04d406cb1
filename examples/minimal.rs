// How an engine uses Gobo, in one file: `cargo run --release --example minimal`.
//
// A ball of smoke is between the sun and the origin. The engine owns the device, the queue, the command buffers and the buffer that holds
// the ball; Gobo records into the command buffers and does nothing else. The light at the origin is read back and compared with its closed
// form, exp(-optical depth). examples/engine is a renderer whose shaders include Gobo's GLSL.

use ash::vk;
use glam::DVec3;
use gobo::gpu::{Adopt, Buffer, Commands, Context, Enabled, Features, Messages, ReadBack};
use gobo::query::Query;
use gobo::scene::{Light, LightKind};
use gobo::technique::{Avsm, Technique, parse};
use gobo::world::{Capacity, Count, Number, Source, SphereAt, World};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const FRAMES_IN_FLIGHT: u32 = 2;
const LAST_FRAME: u64 = 8;

/// The ball as the engine stores it: x, y, z, radius, and optical depth per world unit. A ray through its centre has an optical depth of 2.
const BALL: [f32; 5] = [0.0, 0.0, 1.0, 0.5, 2.0];

fn main() -> Result<()> {
    // The technique: AVSM with 8 nodes per texel. The device features that the technique needs are known before a device is opened.
    let spec = parse("avsm:path=binned,nodes=8,size=64", &[])?.remove(0);
    let engine = Engine::open(&gobo::requirements(&spec)[0].any_of)?;

    // Gobo on the engine's device. It has no queue: it can neither submit nor wait.
    // SAFETY: the engine, which is dropped last, keeps these handles alive, and opened the device with the features in `enabled`.
    let context = unsafe { Context::adopt(engine.adopt()) }?;

    // A world reserves room for its contents. The particles stay in the engine's buffer; Gobo only learns where they are and how they are
    // laid out.
    let mut world = World::of(&context, Capacity { particles: 1, lights: 1, ..Default::default() })?;
    // SAFETY: the buffer is a storage buffer of this size, and the engine keeps it alive.
    let buffer = unsafe { Buffer::adopt(&context, "smoke", engine.smoke, size_of_val(&BALL) as u64) }?;
    let smoke = Source { buffer, offset: 0, stride: size_of_val(&BALL) as u32, count: Count::Host(1) };
    let layout = SphereAt { position: 0, radius: Number::At(12), extinction: Number::At(16) };

    // Lights are set before the technique is opened, since it is opened for their number.
    let kind = LightKind::Directional { direction: DVec3::NEG_Z };
    let sun = Light { kind, radiance: [1.0; 3], radius: f64::INFINITY };
    // SAFETY: the command buffer is being recorded as frame 0, outside a render pass, and is submitted once.
    let mut commands = unsafe { Commands::on(&context, engine.begin(0)?, 0) }?;
    world.update_lights(&mut commands, &[sun])?;
    commands.end();
    engine.submit(0)?;
    let mut avsm = Avsm::new(&context, &world, &spec.settings())?;

    // In place of the engine's shaders, a query looks up how much of light 0 reaches a point.
    let query = Query::new(&context, 0, &[[0.0; 3]])?;
    let (kernel, light) = (query.kernel(&avsm.answer())?, ReadBack::new(&context, "light", 4)?);
    for frame in 1..=LAST_FRAME {
        // The frame that last used this command buffer has finished. `settle` grows lists that were too short for its casters.
        let commands = engine.begin(frame)?;
        avsm.settle(frame.saturating_sub(FRAMES_IN_FLIGHT.into()))?;
        // The engine would move its particles here. Gobo's passes start and end with barriers for everything before and after them.
        // SAFETY: as for frame 0, and frame − 2 has finished.
        let mut commands = unsafe { Commands::on(&context, commands, frame) }?;
        world.update_particles(&mut commands, &smoke, layout)?;
        avsm.record(&mut commands, &world)?;
        query.record(&mut commands, &kernel);
        commands.read_back(query.buffer(), &light);
        commands.end();
        // The engine would draw here, with its own shaders and the set that `avsm.answer().write_into` writes.
        engine.submit(frame)?;
    }

    engine.wait()?;
    let light = light.read::<f32>(LAST_FRAME, 1)?.ok_or("nothing was read back")?[0];
    let expected = (-2.0 * BALL[3] * BALL[4]).exp();
    println!("frame {LAST_FRAME}: {light} of the sun's light; exp(-optical depth) is {expected}");
    if (light - expected).abs() > 0.02 { Err("it is too far off".into()) } else { Ok(()) }
}

/// The parts of an engine: a device, a queue, command buffers for two frames in flight, and particles in a buffer.
pub struct Engine {
    entry: ash::Entry,
    instance: ash::Instance,
    physical: vk::PhysicalDevice,
    device: ash::Device,
    enabled: Enabled,
    family: u32,
    pool: vk::CommandPool,
    frames: Vec<(vk::CommandBuffer, vk::Fence)>,
    smoke: vk::Buffer,
    memory: vk::DeviceMemory,
}

impl Engine {
    /// Opens the first device that supports one of these sets of features.
    pub fn open(any_of: &[Enabled]) -> Result<Self> {
        // SAFETY: everything that the structures point to outlives the calls.
        unsafe {
            let entry = ash::Entry::load()?;
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
            let info = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&info, None)?;
            let choose = |physical: vk::PhysicalDevice| {
                let families = instance.get_physical_device_queue_family_properties(physical);
                let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
                let family = families.iter().position(|family| family.queue_flags.contains(both))? as u32;
                let has = Enabled::all_of(&Features::of(&instance, physical, family));
                let enabled = *any_of.iter().find(|set| has.or(**set) == has)?;
                let version = instance.get_physical_device_properties(physical).api_version;
                (version >= vk::API_VERSION_1_3).then_some((physical, family, enabled))
            };
            let chosen = instance.enumerate_physical_devices()?.into_iter().find_map(choose);
            let (physical, family, enabled) = chosen.ok_or("no device has what the technique needs")?;

            // `enabled` provides the extensions and feature structures that it needs; an engine adds its own to these.
            let extensions: Vec<_> = enabled.extensions().iter().map(|name| name.as_ptr()).collect();
            let mut structures = enabled.structures();
            let mut features = structures.chain();
            let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
            let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).push_next(&mut features);
            let device = instance.create_device(physical, &info.enabled_extension_names(&extensions), None)?;

            let reset = vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER;
            let info = vk::CommandPoolCreateInfo::default().queue_family_index(family).flags(reset);
            let pool = device.create_command_pool(&info, None)?;
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool);
            let commands = device.allocate_command_buffers(&info.command_buffer_count(FRAMES_IN_FLIGHT))?;
            let signaled = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
            let fence = |commands| Ok((commands, device.create_fence(&signaled, None)?));
            let frames = commands.into_iter().map(fence).collect::<Result<_>>()?;

            // The particle is written once, through memory mapped on the host.
            let info = vk::BufferCreateInfo::default().size(size_of_val(&BALL) as u64);
            let smoke = device.create_buffer(&info.usage(vk::BufferUsageFlags::STORAGE_BUFFER), None)?;
            let needs = device.get_buffer_memory_requirements(smoke);
            let types = instance.get_physical_device_memory_properties(physical).memory_types;
            let mapped = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
            let fits = |i: &usize| needs.memory_type_bits >> i & 1 == 1 && types[*i].property_flags.contains(mapped);
            let index = (0..32).find(fits).ok_or("no memory for the host to write")? as u32;
            let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(index);
            let memory = device.allocate_memory(&info, None)?;
            device.bind_buffer_memory(smoke, memory, 0)?;
            let start = device.map_memory(memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty())?;
            start.cast::<[f32; 5]>().write(BALL);
            Ok(Self { entry, instance, physical, device, enabled, family, pool, frames, smoke, memory })
        }
    }

    /// Returns the handles lent to Gobo. The engine still owns all of them.
    pub fn adopt(&self) -> Adopt {
        Adopt {
            entry: self.entry.clone(),
            instance: self.instance.clone(),
            physical_device: self.physical,
            device: self.device.clone(),
            queue_family: self.family,
            enabled: self.enabled,
            allocator: None, // Gobo creates one. The engine's gpu-allocator would go here.
            frames_in_flight: FRAMES_IN_FLIGHT,
            messages: Messages::default(),
        }
    }

    /// Waits until the frame that last used the command buffer has finished, and starts recording.
    pub fn begin(&self, frame: u64) -> Result<vk::CommandBuffer> {
        let (commands, fence) = self.frames[frame as usize % self.frames.len()];
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: both belong to the device, which is done with the command buffer.
        unsafe { self.device.wait_for_fences(&[fence], true, u64::MAX) }?;
        unsafe { self.device.begin_command_buffer(commands, &info) }?;
        Ok(commands)
    }

    /// Submits what was recorded for the frame.
    pub fn submit(&self, frame: u64) -> Result<()> {
        let (commands, fence) = self.frames[frame as usize % self.frames.len()];
        // SAFETY: the frame is recorded, and everything that it uses lives until the fence is signalled.
        unsafe {
            self.device.end_command_buffer(commands)?;
            self.device.reset_fences(&[fence])?;
            let queue = self.device.get_device_queue(self.family, 0);
            Ok(self.device.queue_submit(queue, &[vk::SubmitInfo::default().command_buffers(&[commands])], fence)?)
        }
    }

    /// Waits for all frames. SAFETY: nobody else uses the device.
    pub fn wait(&self) -> Result<()> {
        Ok(unsafe { self.device.device_wait_idle() }?)
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        let _ = self.wait();
        // SAFETY: no frame is running any more, and everything that Gobo created is gone.
        unsafe {
            self.device.destroy_buffer(self.smoke, None);
            self.device.free_memory(self.memory, None);
            self.frames.iter().for_each(|(_, fence)| self.device.destroy_fence(*fence, None));
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }
}
