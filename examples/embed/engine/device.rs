//! The renderer's own instance, device, queue and allocator. Gobo has no part in making them.

use super::Result;
use super::counted::{Counts, counted};
use ash::{ext, vk};
use gobo::gpu::{Enabled, Features};
use gpu_allocator::vulkan::{Allocation, Allocator, AllocatorCreateDesc};
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// What a run may choose about the device.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// Part of its name; none takes a GPU where there is one.
    pub device: Option<String>,
    /// Load the validation layer with its synchronization checks.
    pub validation: bool,
    /// What of the device is switched on.
    pub optional: Optional,
    /// Measure how long passes take, where the device can.
    pub timestamps: bool,
}

/// What is switched on beyond what neither the renderer nor Gobo can do without.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Optional {
    /// All that Gobo has a use for and the device has.
    #[default]
    All,
    /// All of that but VK_EXT_fragment_shader_interlock.
    NoInterlock,
    Nothing,
}

/// The instance, and what its validation layer says.
struct Instance {
    entry: ash::Entry,
    handle: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    said: Said,
}

/// Warnings and errors of the validation layer. Clones share one list, which may outlive the device: the layer also speaks while
/// that is closed.
#[derive(Clone, Default)]
pub struct Said(Arc<Mutex<Vec<String>>>);

impl Said {
    pub fn all(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// The device, and all that the renderer makes from it: it makes that once, and keeps it to the end.
pub struct Gpu {
    pub device: ash::Device,
    pub physical: vk::PhysicalDevice,
    pub queue: vk::Queue,
    pub queue_family: u32,
    /// What the device was opened with, for Gobo to know.
    pub enabled: Enabled,
    /// Nanoseconds a tick of a timestamp; 0 without.
    pub tick_ns: f64,
    /// The device as Gobo is given it, and how often that has submitted or waited. An engine hands its device over as it is.
    pub counted: (ash::Device, Counts),
    /// None only while it is being dropped: it must go before the device.
    allocator: Option<Arc<Mutex<Allocator>>>,
    kept: Vec<Kept>,
    instance: Instance,
}

/// What has to be destroyed before the device is.
pub enum Kept {
    Buffer(vk::Buffer),
    Image(vk::Image),
    View(vk::ImageView),
    SetLayout(vk::DescriptorSetLayout),
    SetPool(vk::DescriptorPool),
    Layout(vk::PipelineLayout),
    Module(vk::ShaderModule),
    Pipeline(vk::Pipeline),
    Commands(vk::CommandPool),
    Fence(vk::Fence),
    Queries(vk::QueryPool),
    Memory(Allocation),
}

impl Gpu {
    pub fn open(choice: &Choice) -> Result<Self> {
        let instance = Instance::open(choice.validation)?;
        let (physical, queue_family) = choose(&instance.handle, choice.device.as_deref())?;
        // SAFETY: the device is this instance's, and `Instance::open` asked for Vulkan 1.3.
        let features = unsafe { Features::of(&instance.handle, physical, queue_family) };
        let mut enabled = match choice.optional {
            Optional::All => Enabled::all_of(&features),
            Optional::NoInterlock => Enabled { fragment_shader_pixel_interlock: false, ..Enabled::all_of(&features) },
            Optional::Nothing => Enabled::FLOOR,
        };
        // The allocator would have to give memory with addresses.
        enabled.ray_query = false;
        enabled.debug_utils = choice.validation;
        enabled.timestamps = choice.timestamps;
        let device = create_device(&instance.handle, physical, queue_family, &enabled)?;
        // SAFETY: `create_device` asked for one queue of this family.
        let queue = unsafe { device.get_device_queue(queue_family, 0) };
        let has_timestamps = choice.timestamps && features.timestamp_valid_bits == 64;
        let tick_ns = if has_timestamps { features.timestamp_period_ns.into() } else { 0.0 };
        let (allocator, kept) = (None, Vec::new());
        // SAFETY: all belong together, and `Instance::open` asked for Vulkan 1.3.
        let counted = unsafe { counted(&instance.entry, &instance.handle, &device, queue) };
        let mut gpu =
            Self { device, physical, queue, queue_family, enabled, tick_ns, counted, allocator, kept, instance };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: gpu.instance.handle.clone(),
            device: gpu.device.clone(),
            physical_device: physical,
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: false,
            allocation_sizes: gpu_allocator::AllocationSizes::default(),
        })?;
        gpu.allocator = Some(Arc::new(Mutex::new(allocator)));
        Ok(gpu)
    }

    /// Has the device destroy `thing` when it is closed.
    pub fn keep(&mut self, thing: Kept) {
        self.kept.push(thing);
    }

    /// The allocator, for all that the renderer and Gobo make.
    pub fn allocator(&self) -> Result<Arc<Mutex<Allocator>>> {
        self.allocator.clone().ok_or_else(|| "the device is being closed".into())
    }

    /// What the device came from.
    pub fn origin(&self) -> (ash::Entry, ash::Instance) {
        (self.instance.entry.clone(), self.instance.handle.clone())
    }

    /// Bytes of memory that the renderer and Gobo hold together.
    pub fn allocated_bytes(&self) -> u64 {
        let Some(allocator) = &self.allocator else { return 0 };
        allocator.lock().unwrap_or_else(PoisonError::into_inner).generate_report().total_allocated_bytes
    }

    /// What the validation layer says.
    pub fn said(&self) -> Said {
        self.instance.said.clone()
    }

    /// The device's name.
    pub fn name(&self) -> String {
        // SAFETY: the physical device comes from this instance.
        let properties = unsafe { self.instance.handle.get_physical_device_properties(self.physical) };
        properties.device_name_as_c_str().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        let device = &self.device;
        // SAFETY: nothing is submitted any more, and each thing was made from this device and is destroyed once.
        unsafe {
            let _ = device.device_wait_idle();
            for thing in self.kept.drain(..).rev() {
                match thing {
                    Kept::Buffer(buffer) => device.destroy_buffer(buffer, None),
                    Kept::Image(image) => device.destroy_image(image, None),
                    Kept::View(view) => device.destroy_image_view(view, None),
                    Kept::SetLayout(layout) => device.destroy_descriptor_set_layout(layout, None),
                    Kept::SetPool(pool) => device.destroy_descriptor_pool(pool, None),
                    Kept::Layout(layout) => device.destroy_pipeline_layout(layout, None),
                    Kept::Module(module) => device.destroy_shader_module(module, None),
                    Kept::Pipeline(pipeline) => device.destroy_pipeline(pipeline, None),
                    Kept::Commands(pool) => device.destroy_command_pool(pool, None),
                    Kept::Fence(fence) => device.destroy_fence(fence, None),
                    Kept::Queries(pool) => device.destroy_query_pool(pool, None),
                    Kept::Memory(allocation) => {
                        if let Some(Ok(mut allocator)) = self.allocator.as_ref().map(|shared| shared.lock()) {
                            // What cannot be freed is in the allocator's report.
                            let _ = allocator.free(allocation);
                        }
                    }
                }
            }
            // It holds memory of the device. Gobo, which shares it, is closed by now (`Engine::drop`).
            self.allocator = None;
            device.destroy_device(None);
        }
    }
}

impl Instance {
    fn open(validation: bool) -> Result<Self> {
        // SAFETY: loading the system's Vulkan loader runs its initialisers, which are trusted.
        let entry = unsafe { ash::Entry::load() }?;
        let application = vk::ApplicationInfo::default().application_name(c"embed").api_version(vk::API_VERSION_1_3);
        let (layers, extensions): (Vec<_>, Vec<_>) = match validation {
            true => (vec![VALIDATION_LAYER.as_ptr()], vec![ext::debug_utils::NAME, ext::validation_features::NAME]),
            false => (Vec::new(), Vec::new()),
        };
        let extensions: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
        let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions);
        if validation {
            info = info.push_next(&mut features);
        }
        // SAFETY: all that `info` points to lives until the call is over.
        let handle = unsafe { entry.create_instance(&info, None) }?;
        let mut instance = Self { entry, handle, messenger: None, said: Said::default() };
        if validation {
            instance.listen()?;
        }
        Ok(instance)
    }

    fn listen(&mut self) -> Result<()> {
        let loader = ext::debug_utils::Instance::new(&self.entry, &self.handle);
        let severity = vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR;
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(severity)
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(on_message))
            .user_data(Arc::as_ptr(&self.said.0).cast_mut().cast());
        // SAFETY: the list that the callback writes to is destroyed after the messenger.
        let messenger = unsafe { loader.create_debug_utils_messenger(&info, None) }?;
        self.messenger = Some((loader, messenger));
        Ok(())
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: the device is gone (`Gpu::drop`), and nothing else was made from the instance.
        unsafe {
            if let Some((loader, messenger)) = self.messenger.take() {
                loader.destroy_debug_utils_messenger(messenger, None);
            }
            self.handle.destroy_instance(None);
        }
    }
}

/// Called by the validation layer, from any thread.
unsafe extern "system" fn on_message(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    said: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer hands over a valid structure with a text that ends; `said` is the list of `listen`.
    let (message, said) = unsafe { (CStr::from_ptr((*data).p_message), &*said.cast::<Mutex<Vec<String>>>()) };
    said.lock().unwrap_or_else(PoisonError::into_inner).push(message.to_string_lossy().into_owned());
    vk::FALSE
}

/// A device of Vulkan 1.3 and its first queue family that draws and computes: a GPU of its own memory before all others.
fn choose(instance: &ash::Instance, wanted: Option<&str>) -> Result<(vk::PhysicalDevice, u32)> {
    let mut best: Option<(i32, (vk::PhysicalDevice, u32))> = None;
    // SAFETY: enumeration only.
    for physical in unsafe { instance.enumerate_physical_devices() }? {
        // SAFETY: `physical` comes from this instance.
        let (properties, families) = unsafe {
            let properties = instance.get_physical_device_properties(physical);
            (properties, instance.get_physical_device_queue_family_properties(physical))
        };
        let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
        let Some(family) = families.iter().position(|family| family.queue_flags.contains(both)) else { continue };
        let name = properties.device_name_as_c_str()?.to_string_lossy().to_lowercase();
        let is_wanted = wanted.is_none_or(|wanted| name.contains(&wanted.to_lowercase()));
        let rank = match properties.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => 0,
            vk::PhysicalDeviceType::INTEGRATED_GPU => 1,
            vk::PhysicalDeviceType::VIRTUAL_GPU => 2,
            _ => 3,
        };
        let is_better = best.as_ref().is_none_or(|(other, _)| rank < *other);
        if is_wanted && is_better && properties.api_version >= vk::API_VERSION_1_3 {
            best = Some((rank, (physical, family as u32)));
        }
    }
    best.map(|(_, found)| found).ok_or_else(|| "no device of Vulkan 1.3 of that name".into())
}

fn create_device(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    queue_family: u32,
    enabled: &Enabled,
) -> Result<ash::Device> {
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&[1.0])];
    let extensions: Vec<_> = enabled.extensions().iter().map(|name| name.as_ptr()).collect();
    // The renderer itself needs what Gobo needs at least. What it needed more it would switch on in these structures.
    let mut structures = enabled.structures();
    let mut features = structures.chain();
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .push_next(&mut features);
    // SAFETY: all that `info` points to lives until the call is over, and the device has what is switched on.
    Ok(unsafe { instance.create_device(physical, &info, None) }?)
}
