// The engine in the example at the top of lib.rs: a device, a queue and two frames in flight, none of which is Gobo's.
// This file is no part of the crate.

use ash::vk;
use gobo::gpu::{Adopt, Enabled, Features, Messages};
use gobo::{Error, Need, Result};

pub struct Engine {
    entry: ash::Entry,
    instance: ash::Instance,
    physical_device: vk::PhysicalDevice,
    device: ash::Device,
    queue_family: u32,
    enabled: Enabled,
    commands: vk::CommandPool,
    frames: Vec<(vk::CommandBuffer, vk::Fence)>,
}

/// Runs an example. Where there is no driver, it prints so.
pub fn runs(example: impl FnOnce(&Engine) -> Result<()>) {
    // SAFETY: as in any program that uses Vulkan.
    let Some(engine) = (unsafe { Engine::open() }) else {
        return println!("skipped: no driver of Vulkan 1.3");
    };
    let result = example(&engine);
    // SAFETY: what the example made is gone.
    unsafe { engine.close() };
    match result {
        Err(Error::Refused(needs)) if needs != Need::Queue => println!("skipped: needs {needs}"),
        result => result.unwrap_or_else(|error| panic!("{error}")),
    }
}

impl Engine {
    unsafe fn open() -> Option<Self> {
        unsafe {
            let entry = ash::Entry::load().ok()?;
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
            let info = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&info, None).ok()?;
            let is_new = |device: &vk::PhysicalDevice| {
                instance.get_physical_device_properties(*device).api_version >= vk::API_VERSION_1_3
            };
            let physical_device = instance.enumerate_physical_devices().ok()?.into_iter().find(is_new)?;
            let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
            let families = instance.get_physical_device_queue_family_properties(physical_device);
            let queue_family = families.iter().position(|family| family.queue_flags.contains(both))? as u32;
            let features = Features::of(&instance, physical_device, queue_family);
            let enabled = Enabled { ray_query: false, ..Enabled::all_of(&features) };
            let (mut structures, extensions) = (enabled.structures(), enabled.extensions());
            let mut chain = structures.chain();
            let extensions: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
            let queues =
                [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&[1.0])];
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_extension_names(&extensions)
                .push_next(&mut chain);
            let device = instance.create_device(physical_device, &info, None).ok()?;
            let info = vk::CommandPoolCreateInfo::default()
                .queue_family_index(queue_family)
                .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
            let commands = device.create_command_pool(&info, None).ok()?;
            let info = vk::CommandBufferAllocateInfo::default().command_pool(commands).command_buffer_count(2);
            let over = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
            let frame = |buffer| Some((buffer, device.create_fence(&over, None).ok()?));
            let frames = device.allocate_command_buffers(&info).ok()?.into_iter().map(frame).collect::<Option<_>>()?;
            Some(Self { entry, instance, physical_device, device, queue_family, enabled, commands, frames })
        }
    }

    unsafe fn close(self) {
        unsafe {
            self.wait();
            self.frames.iter().for_each(|(_, fence)| self.device.destroy_fence(*fence, None));
            self.device.destroy_command_pool(self.commands, None);
            self.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }

    /// The handles that Gobo gets.
    pub fn adopt(&self) -> Adopt {
        Adopt {
            entry: self.entry.clone(),
            instance: self.instance.clone(),
            physical_device: self.physical_device,
            device: self.device.clone(),
            queue_family: self.queue_family,
            enabled: self.enabled,
            allocator: None,
            frames_in_flight: 2,
            messages: Messages::default(),
        }
    }

    /// The command buffer of a frame. Waits until the earlier frame that used the same buffer is over.
    pub fn begin(&self, frame: u64) -> vk::CommandBuffer {
        let (buffer, fence) = self.frames[frame as usize % 2];
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the earlier frame that used the buffer and the fence is over.
        unsafe {
            self.device.wait_for_fences(&[fence], true, u64::MAX).expect("no device is lost");
            self.device.begin_command_buffer(buffer, &begin).expect("it is over");
        }
        buffer
    }

    pub fn submit(&self, frame: u64) {
        let (buffer, fence) = self.frames[frame as usize % 2];
        let buffers = [buffer];
        let submit = [vk::SubmitInfo::default().command_buffers(&buffers)];
        // SAFETY: the frame is recorded, and nothing else uses the queue.
        unsafe {
            self.device.end_command_buffer(buffer).expect("recorded");
            self.device.reset_fences(&[fence]).expect("it is over");
            let queue = self.device.get_device_queue(self.queue_family, 0);
            self.device.queue_submit(queue, &submit, fence).expect("submitted");
        }
    }

    pub fn wait(&self) {
        // SAFETY: nothing else uses the device.
        unsafe { self.device.device_wait_idle() }.expect("no device is lost");
    }
}
