//! Instance, device choice, queue and allocator.

use super::features::RAY_QUERY_EXTENSIONS;
use super::pipelines::Pipelines;
use super::recorder::Recorders;
use super::validation::{is_gpu_assisted, messenger_info};
use super::{Features, Messages, fault, vk_error};
use crate::{Error, Less, Result, WayOut};
use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, Allocator, AllocatorCreateDesc};
use gpu_allocator::{AllocationError, MemoryLocation};
use std::ffi::{CStr, CString};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// How to open a device.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Index among [`devices`], or part of a device's name; none takes discrete > integrated > virtual > CPU.
    pub device: Option<String>,
    /// Load the validation layer with synchronization validation; an error where it is not installed.
    pub validation: bool,
    /// Where its messages go.
    pub messages: Messages,
}

/// An open device. Clones share it; the last one closes it.
#[derive(Clone)]
pub struct Context(Arc<Shared>);

/// Fields are destroyed in this order.
pub(super) struct Shared {
    pub(super) recorders: Recorders,
    allocator: Mutex<Option<Allocator>>,
    pub(super) device: DeviceOwner,
    pub(super) labels: Option<ext::debug_utils::Device>,
    /// Where the device has ray queries.
    pub(super) acceleration: Option<khr::acceleration_structure::Device>,
    pub(super) queue: vk::Queue,
    pub(super) queue_family: u32,
    pub(super) features: Features,
    /// The driver said so; nothing is submitted any more.
    lost: AtomicBool,
    /// Each pass of a submission is timed, not only all of them together.
    pub(super) times_passes: AtomicBool,
    messages: Messages,
    _instance: InstanceOwner,
}

/// The logical device and its pipelines, destroyed when dropped.
pub(super) struct DeviceOwner {
    device: ash::Device,
    pub(super) pipelines: Pipelines,
}

impl std::ops::Deref for DeviceOwner {
    type Target = ash::Device;
    fn deref(&self) -> &ash::Device {
        &self.device
    }
}

impl Drop for DeviceOwner {
    fn drop(&mut self) {
        self.pipelines.destroy(&self.device);
        // SAFETY: every other object made from the device holds the context, so none is left.
        unsafe { self.device.destroy_device(None) };
    }
}

/// The instance and its messenger. The loader must stay loaded until both are gone.
struct InstanceOwner {
    _entry: ash::Entry,
    instance: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// The list that the layer's callback writes to, also while the instance is being destroyed.
    _messages: Messages,
}

impl Drop for InstanceOwner {
    fn drop(&mut self) {
        // SAFETY: the device is gone (field order of `Shared`); nothing else was made from the instance.
        unsafe {
            if let Some((loader, messenger)) = self.messenger.take() {
                loader.destroy_debug_utils_messenger(messenger, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // SAFETY: the device is still there; nothing is recorded any more.
        let _ = unsafe { self.device.device_wait_idle() };
        self.recorders.end();
        if let Some(allocator) = self.allocator.get_mut().unwrap_or_else(PoisonError::into_inner).take() {
            for leak in allocator.generate_report().allocations {
                self.messages.push("gobo-leak", &format!("{} ({} bytes) was never freed", leak.name, leak.size));
            }
        }
    }
}

/// Facts of every Vulkan device, in the order in which [`Options::device`] counts.
///
/// # Errors
/// [`Error::Gpu`] where no Vulkan loader or no driver is installed.
pub fn devices() -> Result<Vec<Features>> {
    let instance = open_instance(false, &Messages::default())?;
    Ok(physical_devices(&instance.instance)?.into_iter().map(|(_, _, features)| features).collect())
}

fn open_instance(validation: bool, messages: &Messages) -> Result<InstanceOwner> {
    // SAFETY: loading the Vulkan loader runs its initialisers, which are trusted like any system library.
    let entry = unsafe { ash::Entry::load() }.map_err(|e| Error::Gpu {
        operation: "load",
        name: "the Vulkan loader".into(),
        cause: e.to_string(),
        way_out: WayOut::Loader,
    })?;
    let fail = |r| vk_error("create", "the Vulkan instance", r);

    // SAFETY: enumeration only.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.map_err(fail)?;
    if validation && !layers.iter().any(|l| l.layer_name_as_c_str() == Ok(VALIDATION_LAYER)) {
        return Err(Error::Gpu {
            operation: "load",
            name: "VK_LAYER_KHRONOS_validation".into(),
            cause: "the layer is not installed".into(),
            way_out: WayOut::Layer,
        });
    }
    let layer = validation.then_some(VALIDATION_LAYER);
    let offered = |name: &CStr, layer: Option<&CStr>| {
        // SAFETY: enumeration only; `layer` is one that the loader listed.
        unsafe { entry.enumerate_instance_extension_properties(layer) }
            .is_ok_and(|list| list.iter().any(|e| e.extension_name_as_c_str() == Ok(name)))
    };
    let debug_utils = offered(ext::debug_utils::NAME, None) || offered(ext::debug_utils::NAME, layer);
    // Old layers know VK_EXT_validation_features, new ones VK_EXT_layer_settings: ask the layer.
    let settings = validation && offered(ext::layer_settings::NAME, layer);
    let old_settings = validation && !settings && offered(ext::validation_features::NAME, layer);
    let portability = offered(khr::portability_enumeration::NAME, None);

    let mut extensions = Vec::new();
    for (wanted, name) in [
        (debug_utils, ext::debug_utils::NAME),
        (settings, ext::layer_settings::NAME),
        (old_settings, ext::validation_features::NAME),
        (portability, khr::portability_enumeration::NAME),
    ] {
        if wanted {
            extensions.push(name.as_ptr());
        }
    }
    let layer_names: Vec<_> = layer.iter().map(|l| l.as_ptr()).collect();
    let application = vk::ApplicationInfo::default().application_name(c"gobo").api_version(vk::API_VERSION_1_3);
    let on = [1u8, 0, 0, 0];
    let setting = |name| vk::LayerSettingEXT {
        value_count: 1,
        ..vk::LayerSettingEXT::default()
            .layer_name(VALIDATION_LAYER)
            .setting_name(name)
            .ty(vk::LayerSettingTypeEXT::BOOL32)
            .values(&on)
    };
    let mut layer_settings = vec![setting(c"validate_sync"), setting(c"syncval_shader_accesses_heuristic")];
    let mut enabled = vec![vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    if is_gpu_assisted() {
        layer_settings.push(setting(c"gpuav_enable"));
        enabled.push(vk::ValidationFeatureEnableEXT::GPU_ASSISTED);
        enabled.push(vk::ValidationFeatureEnableEXT::GPU_ASSISTED_RESERVE_BINDING_SLOT);
    }
    let mut settings_info = vk::LayerSettingsCreateInfoEXT::default().settings(&layer_settings);
    let mut features_info = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let mut messenger = messenger_info(messages);
    let mut info = vk::InstanceCreateInfo::default()
        .application_info(&application)
        .enabled_extension_names(&extensions)
        .enabled_layer_names(&layer_names);
    if portability {
        info = info.flags(vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR);
    }
    if validation && debug_utils {
        info = info.push_next(&mut messenger);
    }
    if settings {
        info = info.push_next(&mut settings_info);
    }
    if old_settings {
        info = info.push_next(&mut features_info);
    }
    // SAFETY: all pointers in `info` live to the end of this function.
    let instance = fault::creation(|| unsafe { entry.create_instance(&info, None) }).map_err(fail)?;
    let mut owner = InstanceOwner { _entry: entry, instance, messenger: None, _messages: messages.clone() };
    if validation && debug_utils {
        let loader = ext::debug_utils::Instance::new(&owner._entry, &owner.instance);
        // SAFETY: the message list is kept by the owner until after the messenger is destroyed.
        let handle =
            fault::creation(|| unsafe { loader.create_debug_utils_messenger(&messenger_info(messages), None) })
                .map_err(fail)?;
        owner.messenger = Some((loader, handle));
    }
    Ok(owner)
}

fn physical_devices(instance: &ash::Instance) -> Result<Vec<(vk::PhysicalDevice, Option<u32>, Features)>> {
    // SAFETY: enumeration only.
    let list =
        unsafe { instance.enumerate_physical_devices() }.map_err(|r| vk_error("enumerate", "Vulkan devices", r))?;
    Ok(list
        .into_iter()
        .map(|physical| {
            // SAFETY: `physical` comes from this instance.
            let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
            let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
            let family = families.iter().position(|f| f.queue_flags.contains(wanted)).map(|f| f as u32);
            (physical, family, Features::read(instance, physical, family))
        })
        .collect())
}

impl Context {
    /// Opens a device.
    ///
    /// # Errors
    /// [`Error::Gpu`] where there is no loader, driver or validation layer, [`Error::Input`] where `options.device`
    /// names none, [`Error::Refused`] where the device is below the floor.
    pub fn new(options: &Options) -> Result<Self> {
        let instance = open_instance(options.validation, &options.messages)?;
        let all = physical_devices(&instance.instance)?;
        let (physical, family, features) = choose(all, options.device.as_deref())?;
        let queue_family = match (&features.below_floor, family) {
            (None, Some(family)) => family,
            (below, _) => {
                let missing = below.clone().unwrap_or_else(|| "a queue with graphics and compute".into());
                return Err(Error::Refused { needs: format!("{missing} (device {})", features.name) });
            }
        };
        let device = create_device(&instance.instance, physical, queue_family, &features)?;
        let device = DeviceOwner { device, pipelines: Pipelines::default() };
        // SAFETY: the family has one queue, asked for above.
        let queue = unsafe { device.get_device_queue(queue_family, 0) };
        let labels = instance.messenger.is_some().then(|| ext::debug_utils::Device::new(&instance.instance, &device));
        let acceleration =
            features.ray_query.then(|| khr::acceleration_structure::Device::new(&instance.instance, &device));
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.instance.clone(),
            device: device.clone(),
            physical_device: physical,
            // Leaks are reported when the context closes.
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: features.ray_query,
            allocation_sizes: gpu_allocator::AllocationSizes::default(),
        })
        .map_err(|e| allocation_error("the allocator", &e))?;
        let context = Self(Arc::new(Shared {
            recorders: Recorders::default(),
            allocator: Mutex::new(Some(allocator)),
            device,
            labels,
            acceleration,
            queue,
            queue_family,
            features,
            lost: AtomicBool::new(false),
            times_passes: AtomicBool::new(true),
            messages: options.messages.clone(),
            _instance: instance,
        }));
        context.0.recorders.begin(&context)?;
        Ok(context)
    }

    /// What the device can do.
    pub fn features(&self) -> &Features {
        &self.0.features
    }

    /// The messages of the validation layer.
    pub fn messages(&self) -> &Messages {
        &self.0.messages
    }

    /// Bytes of the device's memory that are held by what was made here and is still there.
    pub fn allocated_bytes(&self) -> u64 {
        let allocator = self.0.allocator.lock().unwrap_or_else(PoisonError::into_inner);
        allocator.as_ref().map_or(0, |allocator| allocator.generate_report().total_allocated_bytes)
    }

    pub(super) fn shared(&self) -> &Shared {
        &self.0
    }

    pub(super) fn device(&self) -> &ash::Device {
        &self.0.device
    }

    pub(super) fn pipelines(&self) -> &Pipelines {
        &self.0.device.pipelines
    }

    /// Gives `handle` a name in validation messages and captures.
    pub(super) fn set_name<H: vk::Handle>(&self, handle: H, name: &str) {
        if let (Some(labels), Ok(name)) = (&self.0.labels, CString::new(name)) {
            let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
            // SAFETY: the handle belongs to this device. A name that cannot be set is no loss.
            let _ = unsafe { labels.set_debug_utils_object_name(&info) };
        }
    }

    /// Whether each pass of what is submitted from now on is timed, as it is at first, or all passes of a submission together,
    /// as one: a timestamp waits for all work before it, which takes a GPU some microseconds a pass.
    pub fn time_passes(&self, each: bool) {
        self.0.times_passes.store(each, Ordering::Relaxed);
    }

    /// Whether the device is lost: everything that is submitted fails from then on.
    pub fn is_lost(&self) -> bool {
        self.0.lost.load(Ordering::Relaxed)
    }

    /// What the driver answered to a submission. A lost device stays lost.
    pub(super) fn note_lost(&self, result: vk::Result) {
        if result == vk::Result::ERROR_DEVICE_LOST {
            self.0.lost.store(true, Ordering::Relaxed);
        }
    }

    /// Memory of its own, to be given back by [`Context::free`].
    pub(super) fn allocate(&self, wanted: &AllocationCreateDesc) -> Result<Allocation> {
        let mut allocator = self.0.allocator.lock().unwrap_or_else(PoisonError::into_inner);
        // None only while the context is being closed.
        let allocator = allocator
            .as_mut()
            .ok_or_else(|| vk_error("allocate memory for", wanted.name, vk::Result::ERROR_DEVICE_LOST))?;
        fault::allocation(wanted.location != MemoryLocation::GpuOnly)
            .and_then(|()| allocator.allocate(wanted))
            .map_err(|e| allocation_error(wanted.name, &e))
    }

    /// A failed free shows up as a leak when the context closes.
    pub(super) fn free(&self, allocation: Allocation) {
        if let Some(allocator) = self.0.allocator.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
            let _ = allocator.free(allocation);
        }
    }
}

/// The error for a failed allocation.
fn allocation_error(name: &str, cause: &AllocationError) -> Error {
    Error::Gpu {
        operation: "allocate memory for",
        name: name.into(),
        cause: cause.to_string(),
        way_out: WayOut::Less(&[Less::Map, Less::Casters, Less::MoreMemory]),
    }
}

type Found = (vk::PhysicalDevice, Option<u32>, Features);

fn choose(all: Vec<Found>, wanted: Option<&str>) -> Result<Found> {
    let names = all.iter().enumerate().map(|(i, d)| format!("{i} = {}", d.2.name)).collect::<Vec<_>>().join(", ");
    let chosen = match wanted {
        Some(wanted) => match wanted.parse::<usize>() {
            Ok(index) => all.into_iter().nth(index),
            Err(_) => all.into_iter().find(|d| d.2.name.to_lowercase().contains(&wanted.to_lowercase())),
        },
        None => {
            let rank = |d: &Found| (d.2.below_floor.is_some(), d.2.kind);
            all.into_iter().min_by_key(rank)
        }
    };
    chosen.ok_or_else(|| match wanted {
        Some(wanted) if !names.is_empty() => {
            Error::input(format!("device {wanted}"), "no such device", format!("choose one of: {names}"))
        }
        _ => Error::Gpu {
            operation: "find",
            name: "a Vulkan device".into(),
            cause: "no driver is installed".into(),
            way_out: WayOut::Driver,
        },
    })
}

fn create_device(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    queue_family: u32,
    features: &Features,
) -> Result<ash::Device> {
    let mut extensions = Vec::new();
    let mut interlock = vk::PhysicalDeviceFragmentShaderInterlockFeaturesEXT::default();
    let mut order = vk::PhysicalDeviceRasterizationOrderAttachmentAccessFeaturesEXT::default();
    let mut structures =
        vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(features.ray_query);
    let mut query = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(features.ray_query);
    let mut features12 = vk::PhysicalDeviceVulkan12Features::default()
        .scalar_block_layout(true)
        .buffer_device_address(features.ray_query)
        .shader_output_layer(features.vertex_layer_output)
        .shader_output_viewport_index(features.vertex_layer_output);
    let mut features13 = vk::PhysicalDeviceVulkan13Features::default()
        .synchronization2(true)
        .dynamic_rendering(true)
        .subgroup_size_control(features.compute_full_subgroups)
        .compute_full_subgroups(features.compute_full_subgroups);
    let core = vk::PhysicalDeviceFeatures::default()
        .geometry_shader(features.geometry_shader)
        .tessellation_shader(features.tessellation_shader)
        .fill_mode_non_solid(features.fill_mode_non_solid)
        .multi_viewport(features.multi_viewport)
        .shader_storage_image_extended_formats(features.storage_image_extended_formats)
        .fragment_stores_and_atomics(features.fragment_stores_and_atomics);
    let mut all =
        vk::PhysicalDeviceFeatures2::default().features(core).push_next(&mut features12).push_next(&mut features13);
    if features.fragment_shader_pixel_interlock {
        extensions.push(ext::fragment_shader_interlock::NAME.as_ptr());
        interlock = interlock.fragment_shader_pixel_interlock(true);
        all = all.push_next(&mut interlock);
    }
    if features.rasterization_order_color_attachment_access {
        extensions.push(ext::rasterization_order_attachment_access::NAME.as_ptr());
        order = order.rasterization_order_color_attachment_access(true);
        all = all.push_next(&mut order);
    }
    if features.conservative_rasterization {
        extensions.push(ext::conservative_rasterization::NAME.as_ptr());
    }
    if features.ray_query {
        extensions.extend(RAY_QUERY_EXTENSIONS.map(CStr::as_ptr));
        all = all.push_next(&mut structures).push_next(&mut query);
    }
    // SAFETY: `physical` comes from this instance.
    let offered = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
    if offered.iter().any(|e| e.extension_name_as_c_str() == Ok(khr::portability_subset::NAME)) {
        extensions.push(khr::portability_subset::NAME.as_ptr());
    }
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&[1.0])];
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .push_next(&mut all);
    // SAFETY: everything `info` points to lives to the end of this function, and only offered features are asked for.
    fault::creation(|| unsafe { instance.create_device(physical, &info, None) })
        .map_err(|r| vk_error("open", &features.name, r))
}
