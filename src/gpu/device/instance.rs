//! The instance, device selection and device creation, for a context that opens its own device.

use crate::gpu::testing::fault;
use crate::gpu::testing::validation::{is_gpu_assisted, messenger_info};
use crate::gpu::{Enabled, Features, Messages, vk_error};
use crate::{Error, Result, WayOut};
use ash::{ext, khr, vk};
use std::ffi::CStr;

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// The instance and its messenger. The loader must stay loaded until both are gone.
pub(in crate::gpu) struct InstanceOwner {
    pub entry: ash::Entry,
    pub instance: ash::Instance,
    pub messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// The list that the layer's callback writes to, even while the instance is being destroyed.
    _messages: Messages,
}

impl Drop for InstanceOwner {
    fn drop(&mut self) {
        // SAFETY: the device is gone (field order of the device's parts), and nothing else was created from the instance.
        unsafe {
            if let Some((loader, messenger)) = self.messenger.take() {
                loader.destroy_debug_utils_messenger(messenger, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}

pub(in crate::gpu) fn open_instance(validation: bool, messages: &Messages) -> Result<InstanceOwner> {
    // SAFETY: loading the Vulkan loader runs its initialisers, which are trusted like any system library.
    let entry = unsafe { ash::Entry::load() }.map_err(|e| Error::Gpu {
        operation: "load",
        name: "the Vulkan loader".into(),
        cause: e.to_string().into(),
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
    // Old layers support VK_EXT_validation_features, new ones VK_EXT_layer_settings, so query the layer.
    let settings = validation && offered(ext::layer_settings::NAME, layer);
    let old_settings = validation && !settings && offered(ext::validation_features::NAME, layer);

    let mut extensions = Vec::new();
    for (wanted, name) in [
        (debug_utils, ext::debug_utils::NAME),
        (settings, ext::layer_settings::NAME),
        (old_settings, ext::validation_features::NAME),
    ] {
        if wanted {
            extensions.push(name.as_ptr());
        }
    }
    let portability = portability(&entry);
    extensions.extend(portability.map(CStr::as_ptr));
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
    if portability.is_some() {
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
    let mut owner = InstanceOwner { entry, instance, messenger: None, _messages: messages.clone() };
    if validation && debug_utils {
        let loader = ext::debug_utils::Instance::new(&owner.entry, &owner.instance);
        // SAFETY: the owner keeps the message list alive until after the messenger is destroyed.
        let handle =
            fault::creation(|| unsafe { loader.create_debug_utils_messenger(&messenger_info(messages), None) })
                .map_err(fail)?;
        owner.messenger = Some((loader, handle));
    }
    Ok(owner)
}

/// Returns the extension that, with `ENUMERATE_PORTABILITY_KHR`, makes an instance list devices without full Vulkan
/// support, such as MoltenVK's. `None` if the loader does not know the extension; it then lists such devices anyway.
pub(crate) fn portability(entry: &ash::Entry) -> Option<&'static CStr> {
    let name = khr::portability_enumeration::NAME;
    // SAFETY: enumeration only.
    let offered = unsafe { entry.enumerate_instance_extension_properties(None) }.unwrap_or_default();
    offered.iter().any(|offered| offered.extension_name_as_c_str() == Ok(name)).then_some(name)
}

pub(in crate::gpu) fn physical_devices(
    instance: &ash::Instance,
) -> Result<Vec<(vk::PhysicalDevice, Option<u32>, Features)>> {
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

type PickedDevice = (vk::PhysicalDevice, Option<u32>, Features);

pub(in crate::gpu) fn choose(all: Vec<PickedDevice>, wanted: Option<&str>) -> Result<PickedDevice> {
    let names = all.iter().enumerate().map(|(i, d)| format!("{i} = {}", d.2.name)).collect::<Vec<_>>().join(", ");
    let chosen = match wanted {
        Some(wanted) => match wanted.parse::<usize>() {
            Ok(index) => all.into_iter().nth(index),
            Err(_) => all.into_iter().find(|d| d.2.name.to_lowercase().contains(&wanted.to_lowercase())),
        },
        None => {
            let rank = |d: &PickedDevice| (d.2.below_floor.is_some(), d.2.kind);
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

pub(in crate::gpu) fn create_device(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    queue_family: u32,
    features: &Features,
) -> Result<ash::Device> {
    let enabled = Enabled::all_of(features);
    let mut extensions: Vec<_> = enabled.extensions().into_iter().map(CStr::as_ptr).collect();
    let mut structures = enabled.structures();
    let mut all = structures.chain();
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
    // SAFETY: everything that `info` points to lives to the end of this function, and only supported features are
    // requested.
    fault::creation(|| unsafe { instance.create_device(physical, &info, None) })
        .map_err(|r| vk_error("open", &features.name, r))
}
