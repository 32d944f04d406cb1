//! Device capabilities beyond the floor of Vulkan 1.3.

use crate::gpu::Limit;
use crate::{Error, Need, Result};
use ash::{ext, khr, nv, vk};

/// Number of storage buffers per shader stage that a device must support, more than the 4 that Vulkan guarantees. A
/// build pass reads maps, casters, triangles and seven bin buffers, and writes curves.
pub(in crate::gpu) const STORAGE_BUFFERS: u32 = 16;

/// Extensions that [`Features::ray_query`] requires.
pub(in crate::gpu) const RAY_QUERY_EXTENSIONS: [&std::ffi::CStr; 3] =
    [khr::acceleration_structure::NAME, khr::ray_query::NAME, khr::deferred_host_operations::NAME];

/// Kind of device, as Vulkan reports it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "program", derive(serde::Serialize), serde(rename_all = "lowercase"))]
pub enum DeviceKind {
    /// A GPU with its own memory.
    Discrete,
    /// A GPU integrated into the processor.
    Integrated,
    /// A virtual GPU of a virtual machine.
    Virtual,
    /// A driver that runs on the CPU.
    Cpu,
    /// Anything else.
    Other,
}

impl std::fmt::Display for DeviceKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Discrete => "discrete",
            Self::Integrated => "integrated",
            Self::Virtual => "virtual",
            Self::Cpu => "cpu",
            Self::Other => "other",
        })
    }
}

/// Properties of one device.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "program", derive(serde::Serialize))]
pub struct Features {
    /// The device's name.
    pub name: String,
    /// Driver name and version.
    pub driver: String,
    /// VkPhysicalDeviceIDProperties::deviceUUID, by which other libraries identify the device.
    #[cfg_attr(feature = "program", serde(skip))]
    pub uuid: [u8; 16],
    /// Vulkan version that the device supports.
    pub api: String,
    /// discrete, integrated, virtual, cpu or other.
    #[cfg_attr(feature = "program", serde(rename = "type"))]
    pub kind: DeviceKind,
    /// The first requirement of the floor that the device does not meet, if any. The floor is Vulkan 1.3 with
    /// synchronization2, dynamic rendering, scalar block layout and 16 storage buffers per stage.
    pub below_floor: Option<String>,
    /// VK_EXT_fragment_shader_interlock, fragmentShaderPixelInterlock.
    pub fragment_shader_pixel_interlock: bool,
    /// VK_EXT_rasterization_order_attachment_access, rasterizationOrderColorAttachmentAccess.
    pub rasterization_order_color_attachment_access: bool,
    /// VK_EXT_conservative_rasterization: a triangle covers every texel that it touches.
    pub conservative_rasterization: bool,
    /// VK_KHR_ray_query, rayQuery, with accelerationStructure and bufferDeviceAddress.
    pub ray_query: bool,
    /// VK_KHR_dynamic_rendering_local_read.
    pub dynamic_rendering_local_read: bool,
    /// geometryShader.
    pub geometry_shader: bool,
    /// tessellationShader.
    pub tessellation_shader: bool,
    /// fillModeNonSolid: triangles can be drawn as lines.
    pub fill_mode_non_solid: bool,
    /// shaderOutputLayer and shaderOutputViewportIndex: a vertex shader can select the layer.
    pub vertex_layer_output: bool,
    /// multiViewport.
    pub multi_viewport: bool,
    /// shaderStorageImageExtendedFormats: shaders can write single-channel images of 8 or 16 bits.
    pub storage_image_extended_formats: bool,
    /// fragmentStoresAndAtomics: a fragment shader can write buffers.
    pub fragment_stores_and_atomics: bool,
    /// Whether VK_FORMAT_R32G32B32A32_SFLOAT supports blending.
    pub float32_blend: bool,
    /// VK_EXT_calibrated_timestamps: the clocks of device and host can be read together.
    pub calibrated_timestamps: bool,
    /// pipelineStatisticsQuery: a query can count a pass's vertices, fragments and threads. False for lavapipe before
    /// 26, which crashes on such queries (docs/reference/drivers.md).
    pub pipeline_statistics_query: bool,
    /// VK_KHR_pipeline_executable_properties, pipelineExecutableInfo: the driver reports on compiled shaders.
    pub pipeline_executable_info: bool,
    /// VK_NV_shader_sm_builtins, shaderSMBuiltins: a shader can read the ID of the multiprocessor it runs on.
    pub shader_sm_builtins: bool,
    /// Number of threads per subgroup.
    pub subgroup_size: u32,
    /// Whether compute shaders support subgroup arithmetic.
    pub subgroup_arithmetic: bool,
    /// Whether compute shaders support subgroup ballots and broadcasts.
    pub subgroup_ballot: bool,
    /// computeFullSubgroups and subgroupSizeControl: no subgroup is narrower than [`Features::subgroup_size`].
    pub compute_full_subgroups: bool,
    /// Whether compute shaders support 64-bit integer atomics on buffers.
    pub buffer_int64_atomics: bool,
    /// Maximum size of a storage buffer, in bytes.
    pub max_storage_buffer_range: u32,
    /// Maximum number of color attachments per render pass.
    pub max_color_attachments: u32,
    /// Maximum number of color attachments that a fragment shader may write.
    pub max_fragment_output_attachments: u32,
    /// Maximum number of input attachments that a fragment shader may read.
    pub max_per_stage_descriptor_input_attachments: u32,
    /// Maximum number of color attachments, storage buffers and storage images of a fragment shader combined.
    pub max_fragment_combined_output_resources: u32,
    /// Maximum number of storage buffers per shader stage.
    pub max_per_stage_descriptor_storage_buffers: u32,
    /// Maximum number of storage images per shader stage.
    pub max_per_stage_descriptor_storage_images: u32,
    /// Maximum number of descriptor sets bound at once.
    pub max_bound_descriptor_sets: u32,
    /// Largest side of a 2D image that is rendered to, in texels: the least of maxImageDimension2D,
    /// maxFramebufferWidth, maxFramebufferHeight and maxViewportDimensions.
    pub max_image_dimension_2d: u32,
    /// Largest side of a 3D image, in texels.
    pub max_image_dimension_3d: u32,
    /// Maximum number of viewports per render pass.
    pub max_viewports: u32,
    /// Maximum number of layers per render pass.
    pub max_framebuffer_layers: u32,
    /// Size of the largest device-local heap, in bytes.
    pub memory_bytes: u64,
    /// Maximum shared memory per workgroup, in bytes.
    pub max_compute_shared_memory_bytes: u32,
    /// Maximum number of threads per workgroup.
    pub max_compute_workgroup_threads: u32,
    /// Sub-pixel precision: the rasterizer snaps vertices to a grid with 2 to this power steps per texel.
    pub sub_pixel_precision_bits: u32,
    /// Nanoseconds per timestamp tick.
    pub timestamp_period_ns: f32,
    /// Number of valid bits in a timestamp; 0 if there are no timestamps.
    pub timestamp_valid_bits: u32,
}

/// A feature that some paths need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Requirement {
    /// [`Features::fragment_shader_pixel_interlock`].
    PixelInterlock,
    /// [`Features::fragment_stores_and_atomics`].
    FragmentStores,
    /// [`Features::rasterization_order_color_attachment_access`].
    RasterOrder,
    /// [`Features::storage_image_extended_formats`].
    ExtendedFormats,
    /// [`Features::geometry_shader`] and [`Features::multi_viewport`].
    GeometryLayers,
    /// [`Features::vertex_layer_output`].
    VertexLayers,
    /// [`Requirement::GeometryLayers`] or [`Requirement::VertexLayers`].
    Layers,
    /// [`Features::multi_viewport`].
    Viewports,
    /// [`Features::tessellation_shader`].
    Tessellation,
    /// [`Features::fill_mode_non_solid`].
    Lines,
    /// [`Features::ray_query`].
    RayQuery,
}

impl Requirement {
    /// Returns the feature's name in Vulkan.
    pub fn name(self) -> &'static str {
        match self {
            Self::PixelInterlock => "fragmentShaderPixelInterlock",
            Self::FragmentStores => "fragmentStoresAndAtomics",
            Self::RasterOrder => "rasterizationOrderColorAttachmentAccess",
            Self::ExtendedFormats => "shaderStorageImageExtendedFormats",
            Self::GeometryLayers => "geometryShader and multiViewport",
            Self::VertexLayers => "shaderOutputLayer and shaderOutputViewportIndex",
            Self::Layers => "shaderOutputLayer and shaderOutputViewportIndex, or geometryShader and multiViewport",
            Self::Viewports => "multiViewport",
            Self::Tessellation => "tessellationShader",
            Self::Lines => "fillModeNonSolid",
            Self::RayQuery => "rayQuery",
        }
    }
}

impl Features {
    /// Returns whether the device is a software driver. There the threads of a workgroup take turns on one processor:
    /// extra threads only repeat the work that each thread does, and a value that all threads read is read once per
    /// thread, one after another.
    pub fn is_software(&self) -> bool {
        self.kind == DeviceKind::Cpu
    }

    /// Returns the name by which NVIDIA's management library knows the device, `GPU-` followed by the UUID; `None` for
    /// devices of other vendors.
    pub fn nvidia_uuid(&self) -> Option<String> {
        let hexadecimal = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        let [a, b, c, d, e] = [0..4, 4..6, 6..8, 8..10, 10..16].map(|part| hexadecimal(&self.uuid[part]));
        self.driver.starts_with("NVIDIA").then(|| format!("GPU-{a}-{b}-{c}-{d}-{e}"))
    }

    /// Returns the Vulkan name of `requirement` if this device lacks it.
    pub fn lacks(&self, requirement: Requirement) -> Option<&'static str> {
        let geometry_layers = self.geometry_shader && self.multi_viewport;
        let has = match requirement {
            Requirement::PixelInterlock => self.fragment_shader_pixel_interlock,
            Requirement::FragmentStores => self.fragment_stores_and_atomics,
            Requirement::RasterOrder => self.rasterization_order_color_attachment_access,
            Requirement::ExtendedFormats => self.storage_image_extended_formats,
            Requirement::GeometryLayers => geometry_layers,
            Requirement::VertexLayers => self.vertex_layer_output,
            Requirement::Layers => geometry_layers || self.vertex_layer_output,
            Requirement::Viewports => self.multi_viewport,
            Requirement::Tessellation => self.tessellation_shader,
            Requirement::Lines => self.fill_mode_non_solid,
            Requirement::RayQuery => self.ray_query,
        };
        (!has).then(|| requirement.name())
    }

    /// Checks that this device has all of `requirements`.
    ///
    /// # Errors
    /// [`Error::Refused`], naming the first one that is missing.
    pub fn require(&self, requirements: &[Requirement]) -> Result<()> {
        match requirements.iter().find(|r| self.lacks(**r).is_some()) {
            Some(missing) => Err(Error::Refused(Need::Feature(*missing))),
            None => Ok(()),
        }
    }

    /// Returns the Vulkan name of the limit that is too low for a fragment shader with `buffers` storage buffers and
    /// `attachments` color attachments that it also reads; `None` if all limits suffice.
    pub fn attachment_limit(&self, attachments: u32, buffers: u32) -> Option<Need> {
        Limit::attachments(attachments, buffers).iter().find_map(|limit| limit.lacks(self, ""))
    }

    /// Returns why a workgroup of `threads` threads cannot share values through subgroups; `None` if it can. A subgroup
    /// lacks lanes if it is wider than the workgroup, or compiled narrower than the device reports.
    pub fn lacks_full_subgroups(&self, threads: u32) -> Option<Need> {
        let size = self.subgroup_size;
        if !self.subgroup_ballot {
            return Some("subgroup ballots in compute shaders".into());
        }
        if !self.compute_full_subgroups {
            return Some("computeFullSubgroups and subgroupSizeControl".into());
        }
        (!threads.is_multiple_of(size))
            .then(|| format!("subgroups of {threads} threads or a part (this device's have {size})").into())
    }

    /// Returns every property by name, for results and tables.
    #[cfg(feature = "program")]
    pub fn facts(&self) -> std::collections::BTreeMap<String, serde_json::Value> {
        match serde_json::to_value(self) {
            Ok(serde_json::Value::Object(map)) => map.into_iter().collect(),
            _ => Default::default(),
        }
    }

    /// Reads the features of a device that the caller is about to open; [`crate::gpu::Enabled::all_of`] turns them into
    /// the set to enable. `queue_family` is the family that commands are recorded for.
    ///
    /// # Safety
    /// The device must belong to the instance, and the application must have requested Vulkan 1.3.
    pub unsafe fn of(instance: &ash::Instance, physical: vk::PhysicalDevice, queue_family: u32) -> Self {
        Self::read(instance, physical, Some(queue_family))
    }

    pub(in crate::gpu) fn read(
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        queue_family: Option<u32>,
    ) -> Self {
        // SAFETY: `physical` comes from this instance.
        let extensions = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
        let has = |name: &std::ffi::CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));

        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
        let mut ids = vk::PhysicalDeviceIDProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default()
            .push_next(&mut driver)
            .push_next(&mut subgroup)
            .push_next(&mut ids);
        // SAFETY: the chain holds structures of Vulkan 1.2, which a 1.3 instance accepts.
        unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
        let properties = properties.properties;

        let mut features12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut features13 = vk::PhysicalDeviceVulkan13Features::default();
        let mut interlock = vk::PhysicalDeviceFragmentShaderInterlockFeaturesEXT::default();
        let mut order = vk::PhysicalDeviceRasterizationOrderAttachmentAccessFeaturesEXT::default();
        let mut local_read = vk::PhysicalDeviceDynamicRenderingLocalReadFeaturesKHR::default();
        let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
        let mut query = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
        let mut executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
        let mut processors = vk::PhysicalDeviceShaderSMBuiltinsFeaturesNV::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut features12);
        let is_13 = properties.api_version >= vk::API_VERSION_1_3;
        if is_13 {
            features = features.push_next(&mut features13);
        }
        if has(ext::fragment_shader_interlock::NAME) {
            features = features.push_next(&mut interlock);
        }
        if has(ext::rasterization_order_attachment_access::NAME) {
            features = features.push_next(&mut order);
        }
        if RAY_QUERY_EXTENSIONS.into_iter().all(has) {
            features = features.push_next(&mut structures).push_next(&mut query);
        }
        if has(khr::dynamic_rendering_local_read::NAME) {
            features = features.push_next(&mut local_read);
        }
        if has(khr::pipeline_executable_properties::NAME) {
            features = features.push_next(&mut executables);
        }
        if has(nv::shader_sm_builtins::NAME) {
            features = features.push_next(&mut processors);
        }
        // SAFETY: the chain holds only structures whose version or extension the device offers.
        unsafe { instance.get_physical_device_features2(physical, &mut features) };
        let core = features.features;

        let missing = [
            (is_13, "Vulkan 1.3"),
            (features13.synchronization2 != 0, "synchronization2"),
            (features13.dynamic_rendering != 0, "dynamicRendering"),
            (features12.scalar_block_layout != 0, "scalarBlockLayout"),
            (queue_family.is_some(), "a queue with graphics and compute"),
        ];
        // SAFETY: `physical` comes from this instance.
        let format =
            unsafe { instance.get_physical_device_format_properties(physical, vk::Format::R32G32B32A32_SFLOAT) };
        // SAFETY: as above.
        let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
        // SAFETY: as above.
        let memory = unsafe { instance.get_physical_device_memory_properties(physical) };
        let heaps = memory.memory_heaps_as_slice().iter();
        let local = heaps.filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL));
        let limits = properties.limits;
        let in_subgroups = |operations| {
            subgroup.supported_stages.contains(vk::ShaderStageFlags::COMPUTE)
                && subgroup.supported_operations.contains(operations)
        };
        let text = |t: std::result::Result<&std::ffi::CStr, _>| {
            t.map(|c| c.to_string_lossy().into_owned()).unwrap_or_default()
        };
        let driver_text = format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str()));
        Self {
            name: text(properties.device_name_as_c_str()),
            uuid: ids.device_uuid,
            api: format!(
                "{}.{}.{}",
                vk::api_version_major(properties.api_version),
                vk::api_version_minor(properties.api_version),
                vk::api_version_patch(properties.api_version)
            ),
            kind: match properties.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
                vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
                vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
                vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
                _ => DeviceKind::Other,
            },
            below_floor: missing.iter().find(|(has, _)| !has).map(|(_, name)| (*name).into()),
            fragment_shader_pixel_interlock: interlock.fragment_shader_pixel_interlock != 0,
            rasterization_order_color_attachment_access: order.rasterization_order_color_attachment_access != 0,
            conservative_rasterization: has(ext::conservative_rasterization::NAME),
            ray_query: structures.acceleration_structure != 0
                && query.ray_query != 0
                && features12.buffer_device_address != 0,
            dynamic_rendering_local_read: local_read.dynamic_rendering_local_read != 0,
            geometry_shader: core.geometry_shader != 0,
            tessellation_shader: core.tessellation_shader != 0,
            fill_mode_non_solid: core.fill_mode_non_solid != 0,
            vertex_layer_output: features12.shader_output_layer != 0 && features12.shader_output_viewport_index != 0,
            multi_viewport: core.multi_viewport != 0,
            storage_image_extended_formats: core.shader_storage_image_extended_formats != 0,
            fragment_stores_and_atomics: core.fragment_stores_and_atomics != 0,
            float32_blend: format.optimal_tiling_features.contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND),
            calibrated_timestamps: has(ext::calibrated_timestamps::NAME),
            pipeline_statistics_query: core.pipeline_statistics_query != 0 && !dies_of_statistics(&driver_text),
            pipeline_executable_info: executables.pipeline_executable_info != 0,
            shader_sm_builtins: processors.shader_sm_builtins != 0,
            subgroup_size: subgroup.subgroup_size,
            subgroup_arithmetic: in_subgroups(vk::SubgroupFeatureFlags::ARITHMETIC),
            subgroup_ballot: in_subgroups(vk::SubgroupFeatureFlags::BALLOT),
            compute_full_subgroups: features13.compute_full_subgroups != 0 && features13.subgroup_size_control != 0,
            buffer_int64_atomics: core.shader_int64 != 0 && features12.shader_buffer_int64_atomics != 0,
            max_storage_buffer_range: limits.max_storage_buffer_range,
            max_color_attachments: limits.max_color_attachments,
            max_fragment_output_attachments: limits.max_fragment_output_attachments,
            max_per_stage_descriptor_input_attachments: limits.max_per_stage_descriptor_input_attachments,
            max_fragment_combined_output_resources: limits.max_fragment_combined_output_resources,
            max_per_stage_descriptor_storage_buffers: limits.max_per_stage_descriptor_storage_buffers,
            max_per_stage_descriptor_storage_images: limits.max_per_stage_descriptor_storage_images,
            max_bound_descriptor_sets: limits.max_bound_descriptor_sets,
            max_image_dimension_2d: limits
                .max_image_dimension2_d
                .min(limits.max_framebuffer_width)
                .min(limits.max_framebuffer_height)
                .min(limits.max_viewport_dimensions[0])
                .min(limits.max_viewport_dimensions[1]),
            max_image_dimension_3d: limits.max_image_dimension3_d,
            max_viewports: if core.multi_viewport != 0 { limits.max_viewports } else { 1 },
            max_framebuffer_layers: limits.max_framebuffer_layers,
            memory_bytes: local.map(|heap| heap.size).max().unwrap_or(0),
            max_compute_shared_memory_bytes: limits.max_compute_shared_memory_size,
            max_compute_workgroup_threads: limits
                .max_compute_work_group_invocations
                .min(limits.max_compute_work_group_size[0]),
            sub_pixel_precision_bits: limits.sub_pixel_precision_bits,
            driver: driver_text,
            timestamp_period_ns: limits.timestamp_period,
            timestamp_valid_bits: queue_family.map_or(0, |f| families[f as usize].timestamp_valid_bits),
        }
        .lowered_for_tests()
        .with_floor()
    }

    /// Checks the floor's limits too, if nothing else is missing.
    fn with_floor(mut self) -> Self {
        let lacks = Limit::FLOOR.iter().find_map(|limit| limit.lacks(&self, ""));
        self.below_floor = self.below_floor.or(lacks.map(|needs| needs.to_string()));
        self
    }
}

/// Returns whether `driver` is a lavapipe older than 26. Version 22.3 crashes if a statistics query begins after push
/// constants but before the command buffer has bound a pipeline of each kind. Version 26.1 does not crash; versions in
/// between were not tried.
fn dies_of_statistics(driver: &str) -> bool {
    let version = driver.strip_prefix("llvmpipe Mesa ").and_then(|text| text.split('.').next()?.parse::<u32>().ok());
    version.is_some_and(|major| major < 26)
}

#[cfg(test)]
mod tests {
    use super::dies_of_statistics;

    #[test]
    fn an_old_lavapipe_is_known_by_its_driver() {
        assert!(dies_of_statistics("llvmpipe Mesa 22.3.6 (LLVM 15.0.6)"));
        for driver in ["llvmpipe Mesa 26.1.0-1 (LLVM 19.1.7)", "llvmpipe", "NVIDIA 580.159.04", "radv Mesa 22.3.6"] {
            assert!(!dies_of_statistics(driver), "{driver}");
        }
    }
}
