//! A device that Gobo does not own: the test creates the instance, with validation, the device, the queue and the command buffers, as an
//! engine would.

use super::counted::{Counts, counted};
use super::messenger::{Messenger, Said};
use ash::{ext, vk};
use gobo::gpu::{Adopt, Commands, Context, Enabled, Messages};
use gpu_allocator::AllocatorDebugSettings;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use std::ffi::CStr;
use std::sync::{Arc, Mutex};

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// A device with one queue, and the command buffers for it.
pub struct Foreign {
    entry: ash::Entry,
    instance: ash::Instance,
    /// None only while the device is being destroyed.
    messenger: Option<Messenger>,
    said: Said,
    physical_device: vk::PhysicalDevice,
    device: ash::Device,
    /// The counted device, as given to Gobo.
    counted: (ash::Device, Counts),
    queue: vk::Queue,
    enabled: Enabled,
    allocator: Option<Arc<Mutex<Allocator>>>,
    pool: vk::CommandPool,
    /// Command buffers and fences of the frames in flight.
    frames: Vec<(vk::CommandBuffer, vk::Fence)>,
    next: u64,
    closed: bool,
}

/// Options for opening a test's device.
#[derive(Clone, Copy)]
pub struct Wanted {
    /// Features enabled beyond the minimum.
    pub enabled: Enabled,
    /// Number of frames in flight.
    pub frames: u32,
    /// Whether the caller supplies the allocator.
    pub allocator: bool,
}

impl Foreign {
    /// Opens the device that Gobo chooses by default.
    pub fn open(wanted: &Wanted) -> Self {
        // SAFETY: all handles are created here, and every call's arguments outlive the call.
        unsafe { Self::unsafe_open(wanted) }
    }

    unsafe fn unsafe_open(wanted: &Wanted) -> Self {
        let said = Said::default();
        unsafe {
            let entry = ash::Entry::load().expect("a loader");
            let mut info = said.info();
            let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
            let mut checks = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
            let (layers, extensions) =
                ([LAYER.as_ptr()], [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()]);
            let instance_info = vk::InstanceCreateInfo::default()
                .application_info(&application)
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut checks)
                .push_next(&mut info);
            let instance = entry.create_instance(&instance_info, None).expect("an instance with validation");
            let messenger = Some(Messenger::new(&entry, &instance, &said));
            let name =
                &gobo::gpu::devices().expect("devices").into_iter().min_by_key(|d| d.kind).expect("a device").name;
            let is_named = |physical: &vk::PhysicalDevice| {
                let properties = instance.get_physical_device_properties(*physical);
                properties.device_name_as_c_str().is_ok_and(|n| n.to_string_lossy() == **name)
            };
            let physical_device = instance
                .enumerate_physical_devices()
                .expect("devices")
                .into_iter()
                .find(is_named)
                .expect("it is there");
            let mut structures = wanted.enabled.structures();
            let mut features = structures.chain();
            let extensions: Vec<_> = wanted.enabled.extensions().into_iter().map(CStr::as_ptr).collect();
            let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_extension_names(&extensions)
                .push_next(&mut features);
            let device = instance.create_device(physical_device, &info, None).expect("a device");
            let queue = device.get_device_queue(0, 0);
            let counted = counted(&entry, &instance, &device, queue);
            let allocator = wanted.allocator.then(|| {
                let allocator = Allocator::new(&AllocatorCreateDesc {
                    instance: instance.clone(),
                    device: device.clone(),
                    physical_device,
                    debug_settings: AllocatorDebugSettings::default(),
                    buffer_device_address: wanted.enabled.ray_query,
                    allocation_sizes: Default::default(),
                });
                Arc::new(Mutex::new(allocator.expect("an allocator")))
            });
            let info = vk::CommandPoolCreateInfo::default().flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
            let pool = device.create_command_pool(&info, None).expect("a pool");
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(wanted.frames);
            let signaled = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
            let fence = || device.create_fence(&signaled, None).expect("a fence");
            let buffers = device.allocate_command_buffers(&info).expect("command buffers");
            let frames = buffers.into_iter().map(|buffer| (buffer, fence())).collect();
            let enabled = wanted.enabled;
            Self {
                entry,
                instance,
                messenger,
                said,
                physical_device,
                device,
                counted,
                queue,
                enabled,
                allocator,
                pool,
                frames,
                next: 0,
                closed: false,
            }
        }
    }

    /// Adopts the device as a context, which reports leaks to `messages`.
    pub fn adopt(&self, messages: &Messages) -> gobo::Result<Context> {
        let theirs = Adopt {
            entry: self.entry.clone(),
            instance: self.instance.clone(),
            physical_device: self.physical_device,
            device: self.counted.0.clone(),
            queue_family: 0,
            enabled: self.enabled,
            allocator: self.allocator.clone(),
            frames_in_flight: self.frames.len() as u32,
            messages: messages.clone(),
        };
        // SAFETY: the device outlives the context: `close` is called last, and waits for the device.
        unsafe { Context::adopt(theirs) }
    }

    /// Returns the number of the next frame, after waiting for the frame whose slot it reuses.
    pub fn begin(&mut self) -> u64 {
        let (_, fence) = self.place(self.next);
        // SAFETY: the fence belongs to this device.
        unsafe { self.device.wait_for_fences(&[fence], true, u64::MAX) }.expect("no device is lost");
        self.next += 1;
        self.next - 1
    }

    /// Records and submits a frame that has begun, without waiting for it.
    pub fn record(&self, context: &Context, frame: u64, record: impl FnOnce(&mut Commands)) {
        let ((buffer, fence), device) = (self.place(frame), &self.device);
        // SAFETY: the frame that used this command buffer before has finished, as Gobo requires too.
        unsafe {
            device.reset_fences(&[fence]).expect("it is not in use");
            let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            device.begin_command_buffer(buffer, &begin).expect("it is not in use");
            let mut commands = Commands::on(context, buffer, frame).expect("frames rise");
            record(&mut commands);
            commands.end();
            device.end_command_buffer(buffer).expect("recorded");
            let buffers = [buffer];
            let submit = vk::SubmitInfo::default().command_buffers(&buffers);
            device.queue_submit(self.queue, &[submit], fence).expect("submitted");
        }
    }

    fn place(&self, frame: u64) -> (vk::CommandBuffer, vk::Fence) {
        self.frames[(frame % self.frames.len() as u64) as usize]
    }

    /// Returns Gobo's calls of functions that submit or wait.
    pub fn calls(&self) -> Vec<(&'static str, u64)> {
        self.counted.1.calls()
    }

    /// Waits for all frames.
    pub fn wait(&self) {
        // SAFETY: nothing else uses the device.
        unsafe { self.device.device_wait_idle() }.expect("no device is lost");
    }

    /// Waits for all frames, ignoring errors such as a lost device.
    pub fn finish(&self) {
        // SAFETY: nothing else uses the device.
        let _ = unsafe { self.device.device_wait_idle() };
    }

    /// Tries to record `frame`, which Gobo must refuse, and returns the error message.
    pub fn refused(&self, context: &Context, frame: u64) -> String {
        // SAFETY: Gobo refuses the frame, so nothing is recorded into the null command buffer.
        let commands = unsafe { Commands::on(context, vk::CommandBuffer::null(), frame) };
        commands.map(|_| ()).expect_err("it is refused").to_string()
    }

    /// Destroys the device; everything that others created from it must be gone. Returns the layer's messages and the names of allocations
    /// left in the test's allocator.
    pub fn close(mut self) -> Vec<String> {
        self.destroy()
    }

    fn destroy(&mut self) -> Vec<String> {
        self.closed = true;
        self.finish();
        let mut said = Vec::new();
        if let Some(allocator) = self.allocator.take() {
            match Arc::into_inner(allocator).map(|allocator| allocator.into_inner().expect("it is whole")) {
                Some(allocator) => {
                    let left = allocator.generate_report().allocations;
                    said.extend(left.into_iter().map(|a| format!("{} is left", a.name)));
                }
                None => said.push("somebody has the allocator still".into()),
            }
        }
        // SAFETY: all frames have finished, and everything created from the device has been destroyed.
        unsafe {
            self.frames.iter().for_each(|(_, fence)| self.device.destroy_fence(*fence, None));
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_device(None);
            self.messenger = None;
            self.instance.destroy_instance(None);
        }
        said.extend(self.said.all());
        said
    }
}

/// Closes the device of a failing test too. Otherwise the message list would be dropped before the allocator frees its memory, and the
/// layer would report that into a dangling list: the program would die by a signal, and the other tests' output with it.
impl Drop for Foreign {
    fn drop(&mut self) {
        if !self.closed {
            self.destroy().iter().for_each(|message| eprintln!("{message}"));
        }
    }
}
