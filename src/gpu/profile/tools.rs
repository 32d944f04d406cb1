//! Layers and tools between a program and its driver, if they report themselves.

use crate::gpu::testing::testing;
use ash::vk;

/// A layer or tool that is active on a device.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(serde::Serialize, serde::Deserialize))]
pub struct Tool {
    /// Name, as the tool reports it.
    pub name: String,
    /// Version, as the tool reports it.
    pub version: String,
    /// Whether the tool may change the device's features, properties or limits.
    pub changes_features: bool,
}

/// Lists the tools that report themselves through Vulkan, plus test overrides of the device. Empty if the query fails.
pub(in crate::gpu) fn tools(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Vec<Tool> {
    // SAFETY: `physical` comes from this instance and supports Vulkan 1.3.
    let count = unsafe { instance.get_physical_device_tool_properties_len(physical) }.unwrap_or(0);
    let mut told = vec![vk::PhysicalDeviceToolProperties::default(); count];
    // SAFETY: as above; `told` is as long as the reported number of tools.
    if unsafe { instance.get_physical_device_tool_properties(physical, &mut told) }.is_err() {
        told.clear();
    }
    let text = |name: Result<&std::ffi::CStr, _>| name.map_or_else(|_| String::new(), |n| n.to_string_lossy().into());
    let mut all: Vec<Tool> = told
        .iter()
        .map(|tool| Tool {
            name: text(tool.name_as_c_str()),
            version: text(tool.version_as_c_str()),
            changes_features: tool.purposes.contains(vk::ToolPurposeFlags::MODIFYING_FEATURES),
        })
        .collect();
    if testing().lowest_limits || testing().no_features {
        all.push(Tool { name: "tests of Gobo".into(), version: String::new(), changes_features: true });
    }
    all
}
