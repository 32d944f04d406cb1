//! Layers and tools between a program and its driver, as far as they report themselves.

use crate::gpu::testing::testing;
use ash::vk;

/// A layer or a tool that is active on a device.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(serde::Serialize, serde::Deserialize))]
pub struct Tool {
    /// Its own name.
    pub name: String,
    /// Its version, in its own words.
    pub version: String,
    /// Whether it may change the device's features, properties or limits.
    pub changes_features: bool,
}

/// Tools that report themselves by Vulkan, and tests' changes of the device. None where the device cannot be asked.
pub(in crate::gpu) fn tools(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Vec<Tool> {
    // SAFETY: `physical` comes from this instance, and is of Vulkan 1.3.
    let count = unsafe { instance.get_physical_device_tool_properties_len(physical) }.unwrap_or(0);
    let mut told = vec![vk::PhysicalDeviceToolProperties::default(); count];
    // SAFETY: as above; there is room for as many as it said.
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
