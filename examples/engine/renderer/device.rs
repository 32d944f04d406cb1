//! The renderer's own instance, device, queue and allocator, created without Gobo.

use super::Result;
use ash::{ext, vk};
use gobo::gpu::{Enabled, Features};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use std::mem::ManuallyDrop;
use std::rc::Rc;
use std::sync::{Arc, Mutex};

pub struct Instance {
    pub entry: ash::Entry,
    pub handle: ash::Instance,
    validation: bool,
}

impl Instance {
    /// Creates an instance. With `validation`, it loads the validation layer with synchronization checks.
    pub fn new(validation: bool) -> Result<Rc<Self>> {
        let application = vk::ApplicationInfo::default().application_name(c"engine").api_version(vk::API_VERSION_1_3);
        let layers = [c"VK_LAYER_KHRONOS_validation".as_ptr()];
        let extensions = [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
        let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        if validation {
            info = info.enabled_layer_names(&layers).enabled_extension_names(&extensions).push_next(&mut features);
        }
        // SAFETY: the system's loader is trusted, and everything that `info` points to outlives the call.
        let entry = unsafe { ash::Entry::load() }?;
        let handle = unsafe { entry.create_instance(&info, None) }?;
        Ok(Rc::new(Self { entry, handle, validation }))
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: each device keeps its instance alive, so no device is left.
        unsafe { self.handle.destroy_instance(None) };
    }
}

/// The device, and everything that the renderer creates from it and keeps until the end.
pub struct Gpu {
    pub instance: Rc<Instance>,
    pub physical: vk::PhysicalDevice,
    pub name: String,
    pub device: ash::Device,
    /// The device lent to Gobo: `device` itself or, in tests/embed, a device that counts calls.
    pub lent: ash::Device,
    pub queue: vk::Queue,
    pub queue_family: u32,
    /// Features enabled on the device; passed on to Gobo.
    pub enabled: Enabled,
    /// Allocator shared by the renderer and Gobo. It is dropped before the device.
    pub allocator: ManuallyDrop<Arc<Mutex<Allocator>>>,
    destroy: Vec<Destroy>,
}

type Destroy = Box<dyn FnOnce(&ash::Device)>;

impl Gpu {
    /// Opens a device, preferably a discrete GPU. `choose` picks the features to enable, among those that the device has and Gobo can use.
    pub fn new(instance: &Rc<Instance>, choose: impl FnOnce(Enabled) -> Enabled) -> Result<Self> {
        let handle = &instance.handle;
        let (physical, queue_family) = find(handle)?;
        // SAFETY: the device belongs to this instance, which was created for Vulkan 1.3.
        let features = unsafe { Features::of(handle, physical, queue_family) };
        // With ray queries, the allocator would have to allocate memory with device addresses.
        let enabled = choose(Enabled { ray_query: false, ..Enabled::all_of(&features) });
        let enabled = Enabled { debug_utils: instance.validation, ..enabled };
        let extensions: Vec<_> = enabled.extensions().iter().map(|name| name.as_ptr()).collect();
        // The renderer needs nothing that Gobo does not need. Any further feature would be enabled in these structures.
        let mut structures = enabled.structures();
        let mut chain = structures.chain();
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).push_next(&mut chain);
        // SAFETY: everything that `info` points to outlives the call, and the device has one queue of this family.
        let device = unsafe { handle.create_device(physical, &info.enabled_extension_names(&extensions), None) }?;
        let queue = unsafe { device.get_device_queue(queue_family, 0) };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: handle.clone(),
            device: device.clone(),
            physical_device: physical,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        })?;
        let allocator = ManuallyDrop::new(Arc::new(Mutex::new(allocator)));
        let (instance, name, lent, destroy) = (instance.clone(), features.name, device.clone(), Vec::new());
        Ok(Self { instance, physical, name, device, lent, queue, queue_family, enabled, allocator, destroy })
    }

    /// Registers `destroy` to run before the device is destroyed, and before everything registered earlier.
    pub fn keep(&mut self, destroy: impl FnOnce(&ash::Device) + 'static) {
        self.destroy.push(Box::new(destroy));
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        // SAFETY: nothing is submitted any more, Gobo is closed, and each object was created from this device and is destroyed once.
        unsafe {
            let _ = self.device.device_wait_idle();
            self.destroy.drain(..).rev().for_each(|destroy| destroy(&self.device));
            ManuallyDrop::drop(&mut self.allocator);
            self.device.destroy_device(None);
        }
    }
}

/// Finds a Vulkan 1.3 device and its first queue family that supports graphics and compute.
fn find(instance: &ash::Instance) -> Result<(vk::PhysicalDevice, u32)> {
    let kinds = [vk::PhysicalDeviceType::DISCRETE_GPU, vk::PhysicalDeviceType::INTEGRATED_GPU];
    let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    // SAFETY: each device belongs to this instance.
    let candidate = |physical: vk::PhysicalDevice| unsafe {
        let properties = instance.get_physical_device_properties(physical);
        let families = instance.get_physical_device_queue_family_properties(physical);
        let family = families.iter().position(|family| family.queue_flags.contains(both))? as u32;
        let rank = kinds.iter().position(|kind| *kind == properties.device_type).unwrap_or(kinds.len());
        (properties.api_version >= vk::API_VERSION_1_3).then_some((rank, (physical, family)))
    };
    // SAFETY: enumeration only.
    let devices = unsafe { instance.enumerate_physical_devices() }?.into_iter().filter_map(candidate);
    Ok(devices.min_by_key(|(rank, _)| *rank).ok_or("no device of Vulkan 1.3")?.1)
}
