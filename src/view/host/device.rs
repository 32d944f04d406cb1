//! The window's own instance, surface, device, queue and allocator, created as in any engine.

use super::failed;
use crate::gpu::{Enabled, Features, instance};
use crate::{Error, Result};
use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use std::ffi::{CStr, c_char, c_void};
use std::sync::{Arc, Mutex, PoisonError};
use winit::raw_window_handle::HandleError;
use winit::raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use winit::window::Window;

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// If a device has this extension, as MoltenVK's does, it must be enabled.
const PORTABILITY: &CStr = c"VK_KHR_portability_subset";

/// Warnings and errors of the validation layer. Clones share the list.
pub type HostMessages = Arc<Mutex<Vec<String>>>;

/// The instance and the window's surface.
struct Instance {
    entry: ash::Entry,
    handle: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    surfaces: khr::surface::Instance,
    surface: vk::SurfaceKHR,
    said: HostMessages,
    /// Keeps the window alive for the surface.
    _window: Arc<Window>,
}

/// The window's device. Everything created from it must be destroyed before it.
pub struct Device {
    pub handle: ash::Device,
    pub physical: vk::PhysicalDevice,
    pub queue: vk::Queue,
    pub queue_family: u32,
    /// Features enabled on the device.
    pub enabled: Enabled,
    /// `None` only while it is dropped.
    allocator: Option<Arc<Mutex<Allocator>>>,
    instance: Instance,
}

impl Device {
    /// Opens a device that can present to the window. `wanted` is its index or a part of its name.
    pub fn open(window: &Arc<Window>, wanted: Option<&str>, validation: bool, said: &HostMessages) -> Result<Self> {
        let instance = Instance::open(window, validation, said)?;
        let (physical, queue_family) = choose(&instance, wanted)?;
        // SAFETY: the device belongs to this instance, which was created for Vulkan 1.3.
        let features = unsafe { Features::of(&instance.handle, physical, queue_family) };
        let mut enabled = Enabled::all_of(&features);
        enabled.debug_utils = validation;
        enabled.timestamps = true;
        let handle = create_device(&instance.handle, physical, queue_family, &enabled)?;
        // SAFETY: `create_device` requested one queue of this family.
        let queue = unsafe { handle.get_device_queue(queue_family, 0) };
        let mut device = Self { handle, physical, queue, queue_family, enabled, allocator: None, instance };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: device.instance.handle.clone(),
            device: device.handle.clone(),
            physical_device: physical,
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: enabled.ray_query,
            allocation_sizes: gpu_allocator::AllocationSizes::default(),
        });
        let allocator = allocator.map_err(|cause| super::error("make", "the window's allocator", cause.to_string()))?;
        device.allocator = Some(Arc::new(Mutex::new(allocator)));
        Ok(device)
    }

    /// Returns the allocator for all resources of the window and of Gobo.
    pub fn allocator(&self) -> Option<Arc<Mutex<Allocator>>> {
        self.allocator.clone()
    }

    /// Returns the bytes of memory that the window and Gobo hold together.
    pub fn allocated_bytes(&self) -> u64 {
        let Some(allocator) = &self.allocator else { return 0 };
        allocator.lock().unwrap_or_else(PoisonError::into_inner).generate_report().total_allocated_bytes
    }

    /// Returns the loader's entry points and the instance.
    pub fn origin(&self) -> (ash::Entry, ash::Instance) {
        (self.instance.entry.clone(), self.instance.handle.clone())
    }

    /// Returns the window's surface and its functions.
    pub fn surface(&self) -> (&khr::surface::Instance, vk::SurfaceKHR) {
        (&self.instance.surfaces, self.instance.surface)
    }

    /// Waits until the device is idle. A lost device is idle too.
    pub fn wait(&self) {
        // SAFETY: the device is open, and only this thread uses its queue.
        let _ = unsafe { self.handle.device_wait_idle() };
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        self.wait();
        // Drops the allocator, which frees its blocks of memory. Everything in them is gone already.
        self.allocator = None;
        // SAFETY: the device is idle, and everything created from it is gone (`Host::drop`).
        unsafe { self.handle.destroy_device(None) };
    }
}

impl Instance {
    fn open(window: &Arc<Window>, validation: bool, said: &HostMessages) -> Result<Self> {
        // SAFETY: loading the system's Vulkan loader runs its initialisers, which are trusted.
        let entry = unsafe { ash::Entry::load() }.map_err(|cause| super::error("load", "Vulkan", cause.to_string()))?;
        let handle_error = |cause: HandleError| super::error("find", "the window's display", cause.to_string());
        let display = window.display_handle().map_err(handle_error)?.as_raw();
        let shown = window.window_handle().map_err(handle_error)?.as_raw();
        let of_surface = ash_window::enumerate_required_extensions(display);
        let mut extensions: Vec<*const c_char> =
            of_surface.map_err(failed("find", "a surface for the window"))?.to_vec();
        let portability = instance::portability(&entry);
        extensions.extend(portability.map(CStr::as_ptr));
        let mut layers = Vec::new();
        if validation {
            extensions.extend([ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()]);
            layers.push(VALIDATION_LAYER.as_ptr());
        }
        let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
        let application =
            vk::ApplicationInfo::default().application_name(c"gobo view").api_version(vk::API_VERSION_1_3);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions);
        if portability.is_some() {
            info = info.flags(vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR);
        }
        if validation {
            info = info.push_next(&mut features);
        }
        // SAFETY: everything that `info` points to lives until the call returns.
        let handle = unsafe { entry.create_instance(&info, None) }.map_err(failed("open", "Vulkan for a window"))?;
        let surfaces = khr::surface::Instance::new(&entry, &handle);
        let (messenger, surface) = (None, vk::SurfaceKHR::null());
        let mut instance =
            Self { entry, handle, messenger, surfaces, surface, said: said.clone(), _window: window.clone() };
        if validation {
            instance.listen()?;
        }
        // SAFETY: the window is kept as long as the surface, and the instance has the extensions that the window requires.
        let surface = unsafe { ash_window::create_surface(&instance.entry, &instance.handle, display, shown, None) };
        instance.surface = surface.map_err(failed("make", "the window's surface"))?;
        Ok(instance)
    }

    fn listen(&mut self) -> Result<()> {
        let loader = ext::debug_utils::Instance::new(&self.entry, &self.handle);
        let severity = vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR;
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(severity)
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(on_message))
            .user_data(Arc::as_ptr(&self.said).cast_mut().cast());
        // SAFETY: the list that the callback writes to is destroyed after the messenger.
        let messenger = unsafe { loader.create_debug_utils_messenger(&info, None) };
        self.messenger = Some((loader, messenger.map_err(failed("listen to", "the validation layer"))?));
        Ok(())
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: the device is gone (`Device::drop`); null handles are ignored.
        unsafe {
            self.surfaces.destroy_surface(self.surface, None);
            if let Some((loader, messenger)) = self.messenger.take() {
                loader.destroy_debug_utils_messenger(messenger, None);
            }
            self.handle.destroy_instance(None);
        }
    }
}

/// Callback for the validation layer, which may call it from any thread.
unsafe extern "system" fn on_message(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    said: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes a valid structure with a null-terminated text; `said` is the list from `listen`.
    let (message, said) = unsafe { (CStr::from_ptr((*data).p_message), &*said.cast::<Mutex<Vec<String>>>()) };
    said.lock().unwrap_or_else(PoisonError::into_inner).push(message.to_string_lossy().into_owned());
    vk::FALSE
}

/// Chooses a device and one of its queue families that supports graphics, compute and presentation. `wanted` is the device's index or a
/// part of its name. If several devices match, discrete GPUs come first.
fn choose(instance: &Instance, wanted: Option<&str>) -> Result<(vk::PhysicalDevice, u32)> {
    // SAFETY: enumerates only.
    let all = unsafe { instance.handle.enumerate_physical_devices() }.map_err(failed("list", "devices"))?;
    let mut best: Option<(u32, (vk::PhysicalDevice, u32))> = None;
    for (index, physical) in all.into_iter().enumerate() {
        // SAFETY: `physical` comes from this instance.
        let (properties, families) = unsafe {
            let properties = instance.handle.get_physical_device_properties(physical);
            (properties, instance.handle.get_physical_device_queue_family_properties(physical))
        };
        let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
        let presents = |family: usize| {
            let (surfaces, surface) = (&instance.surfaces, instance.surface);
            // SAFETY: device, family and surface belong together.
            unsafe { surfaces.get_physical_device_surface_support(physical, family as u32, surface) }.unwrap_or(false)
        };
        let does = |(i, family): (usize, &vk::QueueFamilyProperties)| family.queue_flags.contains(both) && presents(i);
        let Some(family) = families.iter().enumerate().position(does) else { continue };
        let name = properties.device_name_as_c_str().map(CStr::to_string_lossy).unwrap_or_default().to_lowercase();
        let is_wanted = wanted.is_none_or(|wanted| match wanted.parse::<usize>() {
            Ok(number) => number == index,
            Err(_) => name.contains(&wanted.to_lowercase()),
        });
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
    best.map(|(_, found)| found).ok_or_else(|| {
        let name = wanted.map_or_else(|| "a device".into(), |wanted| format!("--device {wanted}"));
        Error::input(name, "no such device of Vulkan 1.3 can present to the window", "run `gobo devices`")
    })
}

fn create_device(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    queue_family: u32,
    enabled: &Enabled,
) -> Result<ash::Device> {
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&[1.0])];
    let mut extensions: Vec<_> = enabled.extensions().iter().map(|name| name.as_ptr()).collect();
    extensions.push(khr::swapchain::NAME.as_ptr());
    // SAFETY: `physical` comes from this instance.
    let has = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
    if has.iter().any(|has| has.extension_name_as_c_str() == Ok(PORTABILITY)) {
        extensions.push(PORTABILITY.as_ptr());
    }
    let mut structures = enabled.structures();
    let mut features = structures.chain();
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .push_next(&mut features);
    // SAFETY: everything that `info` points to lives until the call returns, and the device supports the enabled features.
    unsafe { instance.create_device(physical, &info, None) }.map_err(failed("open", "the window's device"))
}
