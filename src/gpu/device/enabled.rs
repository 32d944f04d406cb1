//! Features beyond Vulkan 1.3 that a device is opened with: features that a path needs, features that a caller has enabled, and the Vulkan
//! structures that enable them.

use crate::gpu::device::features::RAY_QUERY_EXTENSIONS;
use crate::gpu::{Features, Requirement};
use ash::{ext, khr, nv, vk};
use std::ffi::CStr;

/// A set of features, with the extensions that provide them. It states the features that a caller's device was opened with
/// ([`crate::gpu::Adopt`]), or the features that a device must be opened with ([`Requirement::any_of`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Enabled {
    /// synchronization2 of Vulkan 1.3: nothing runs without it.
    pub synchronization2: bool,
    /// dynamicRendering of Vulkan 1.3: nothing runs without it.
    pub dynamic_rendering: bool,
    /// scalarBlockLayout of Vulkan 1.2: nothing runs without it.
    pub scalar_block_layout: bool,
    /// VK_EXT_fragment_shader_interlock, fragmentShaderPixelInterlock.
    pub fragment_shader_pixel_interlock: bool,
    /// VK_EXT_rasterization_order_attachment_access, rasterizationOrderColorAttachmentAccess.
    pub rasterization_order_color_attachment_access: bool,
    /// VK_EXT_conservative_rasterization.
    pub conservative_rasterization: bool,
    /// VK_KHR_ray_query, VK_KHR_acceleration_structure and VK_KHR_deferred_host_operations; rayQuery,
    /// accelerationStructure and bufferDeviceAddress. The caller's allocator must then be created with
    /// `buffer_device_address`.
    pub ray_query: bool,
    /// geometryShader.
    pub geometry_shader: bool,
    /// tessellationShader.
    pub tessellation_shader: bool,
    /// fillModeNonSolid.
    pub fill_mode_non_solid: bool,
    /// shaderOutputLayer and shaderOutputViewportIndex of Vulkan 1.2.
    pub vertex_layer_output: bool,
    /// multiViewport.
    pub multi_viewport: bool,
    /// shaderStorageImageExtendedFormats.
    pub storage_image_extended_formats: bool,
    /// fragmentStoresAndAtomics.
    pub fragment_stores_and_atomics: bool,
    /// subgroupSizeControl and computeFullSubgroups of Vulkan 1.3.
    pub compute_full_subgroups: bool,
    /// shaderInt64, and shaderBufferInt64Atomics of Vulkan 1.2.
    pub buffer_int64_atomics: bool,
    /// VK_EXT_calibrated_timestamps.
    pub calibrated_timestamps: bool,
    /// pipelineStatisticsQuery.
    pub pipeline_statistics_query: bool,
    /// VK_KHR_pipeline_executable_properties, pipelineExecutableInfo.
    pub pipeline_executable_info: bool,
    /// VK_NV_shader_sm_builtins, shaderSMBuiltins.
    pub shader_sm_builtins: bool,
    /// VK_EXT_debug_utils, an instance extension: labels passes and names objects.
    pub debug_utils: bool,
    /// Whether passes are timed, if the queue supports timestamps. No Vulkan feature has to be enabled for it.
    pub timestamps: bool,
}

impl Enabled {
    /// The features that every path needs, and no others.
    pub const FLOOR: Self =
        Self { synchronization2: true, dynamic_rendering: true, scalar_block_layout: true, ..Self::NONE };

    const NONE: Self = Self {
        synchronization2: false,
        dynamic_rendering: false,
        scalar_block_layout: false,
        fragment_shader_pixel_interlock: false,
        rasterization_order_color_attachment_access: false,
        conservative_rasterization: false,
        ray_query: false,
        geometry_shader: false,
        tessellation_shader: false,
        fill_mode_non_solid: false,
        vertex_layer_output: false,
        multi_viewport: false,
        storage_image_extended_formats: false,
        fragment_stores_and_atomics: false,
        compute_full_subgroups: false,
        buffer_int64_atomics: false,
        calibrated_timestamps: false,
        pipeline_statistics_query: false,
        pipeline_executable_info: false,
        shader_sm_builtins: false,
        debug_utils: false,
        timestamps: false,
    };

    /// Returns every feature that the device supports.
    pub fn all_of(features: &Features) -> Self {
        Self {
            fragment_shader_pixel_interlock: features.fragment_shader_pixel_interlock,
            rasterization_order_color_attachment_access: features.rasterization_order_color_attachment_access,
            conservative_rasterization: features.conservative_rasterization,
            ray_query: features.ray_query,
            geometry_shader: features.geometry_shader,
            tessellation_shader: features.tessellation_shader,
            fill_mode_non_solid: features.fill_mode_non_solid,
            vertex_layer_output: features.vertex_layer_output,
            multi_viewport: features.multi_viewport,
            storage_image_extended_formats: features.storage_image_extended_formats,
            fragment_stores_and_atomics: features.fragment_stores_and_atomics,
            compute_full_subgroups: features.compute_full_subgroups,
            buffer_int64_atomics: features.buffer_int64_atomics,
            calibrated_timestamps: features.calibrated_timestamps,
            pipeline_statistics_query: features.pipeline_statistics_query,
            pipeline_executable_info: features.pipeline_executable_info,
            shader_sm_builtins: features.shader_sm_builtins,
            timestamps: true,
            ..Self::FLOOR
        }
    }

    /// Returns the union of the two sets.
    pub fn or(self, other: Self) -> Self {
        Self {
            synchronization2: self.synchronization2 | other.synchronization2,
            dynamic_rendering: self.dynamic_rendering | other.dynamic_rendering,
            scalar_block_layout: self.scalar_block_layout | other.scalar_block_layout,
            fragment_shader_pixel_interlock: self.fragment_shader_pixel_interlock
                | other.fragment_shader_pixel_interlock,
            rasterization_order_color_attachment_access: self.rasterization_order_color_attachment_access
                | other.rasterization_order_color_attachment_access,
            conservative_rasterization: self.conservative_rasterization | other.conservative_rasterization,
            ray_query: self.ray_query | other.ray_query,
            geometry_shader: self.geometry_shader | other.geometry_shader,
            tessellation_shader: self.tessellation_shader | other.tessellation_shader,
            fill_mode_non_solid: self.fill_mode_non_solid | other.fill_mode_non_solid,
            vertex_layer_output: self.vertex_layer_output | other.vertex_layer_output,
            multi_viewport: self.multi_viewport | other.multi_viewport,
            storage_image_extended_formats: self.storage_image_extended_formats | other.storage_image_extended_formats,
            fragment_stores_and_atomics: self.fragment_stores_and_atomics | other.fragment_stores_and_atomics,
            compute_full_subgroups: self.compute_full_subgroups | other.compute_full_subgroups,
            buffer_int64_atomics: self.buffer_int64_atomics | other.buffer_int64_atomics,
            calibrated_timestamps: self.calibrated_timestamps | other.calibrated_timestamps,
            pipeline_statistics_query: self.pipeline_statistics_query | other.pipeline_statistics_query,
            pipeline_executable_info: self.pipeline_executable_info | other.pipeline_executable_info,
            shader_sm_builtins: self.shader_sm_builtins | other.shader_sm_builtins,
            debug_utils: self.debug_utils | other.debug_utils,
            timestamps: self.timestamps | other.timestamps,
        }
    }

    /// Returns the device extensions that provide these features.
    pub fn extensions(&self) -> Vec<&'static CStr> {
        let mut names = Vec::new();
        for (wanted, name) in [
            (self.fragment_shader_pixel_interlock, ext::fragment_shader_interlock::NAME),
            (self.rasterization_order_color_attachment_access, ext::rasterization_order_attachment_access::NAME),
            (self.conservative_rasterization, ext::conservative_rasterization::NAME),
            (self.calibrated_timestamps, ext::calibrated_timestamps::NAME),
            (self.pipeline_executable_info, khr::pipeline_executable_properties::NAME),
            (self.shader_sm_builtins, nv::shader_sm_builtins::NAME),
        ] {
            if wanted {
                names.push(name);
            }
        }
        if self.ray_query {
            names.extend(RAY_QUERY_EXTENSIONS);
        }
        names
    }

    /// Returns the feature structures for VkDeviceCreateInfo.
    pub fn structures(&self) -> EnabledStructures {
        let interlock = vk::PhysicalDeviceFragmentShaderInterlockFeaturesEXT::default();
        let order = vk::PhysicalDeviceRasterizationOrderAttachmentAccessFeaturesEXT::default();
        let executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
        let processors = vk::PhysicalDeviceShaderSMBuiltinsFeaturesNV::default();
        EnabledStructures {
            core: vk::PhysicalDeviceFeatures::default()
                .geometry_shader(self.geometry_shader)
                .tessellation_shader(self.tessellation_shader)
                .fill_mode_non_solid(self.fill_mode_non_solid)
                .shader_int64(self.buffer_int64_atomics)
                .multi_viewport(self.multi_viewport)
                .shader_storage_image_extended_formats(self.storage_image_extended_formats)
                .fragment_stores_and_atomics(self.fragment_stores_and_atomics)
                .pipeline_statistics_query(self.pipeline_statistics_query),
            vulkan12: vk::PhysicalDeviceVulkan12Features::default()
                .scalar_block_layout(self.scalar_block_layout)
                .shader_buffer_int64_atomics(self.buffer_int64_atomics)
                .buffer_device_address(self.ray_query)
                .shader_output_layer(self.vertex_layer_output)
                .shader_output_viewport_index(self.vertex_layer_output),
            vulkan13: vk::PhysicalDeviceVulkan13Features::default()
                .synchronization2(self.synchronization2)
                .dynamic_rendering(self.dynamic_rendering)
                .subgroup_size_control(self.compute_full_subgroups)
                .compute_full_subgroups(self.compute_full_subgroups),
            interlock: self.fragment_shader_pixel_interlock.then(|| interlock.fragment_shader_pixel_interlock(true)),
            order: self
                .rasterization_order_color_attachment_access
                .then(|| order.rasterization_order_color_attachment_access(true)),
            executables: self.pipeline_executable_info.then(|| executables.pipeline_executable_info(true)),
            processors: self.shader_sm_builtins.then(|| processors.shader_sm_builtins(true)),
            rays: self.ray_query.then(|| {
                (
                    vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true),
                    vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true),
                )
            }),
        }
    }
}

/// [`Enabled`] as Vulkan structures. A caller that has its own structures for the same features must set the same fields in them.
pub struct EnabledStructures {
    /// Features of Vulkan 1.0.
    pub core: vk::PhysicalDeviceFeatures,
    /// Features of Vulkan 1.2.
    pub vulkan12: vk::PhysicalDeviceVulkan12Features<'static>,
    /// Features of Vulkan 1.3.
    pub vulkan13: vk::PhysicalDeviceVulkan13Features<'static>,
    /// Features of VK_EXT_fragment_shader_interlock.
    pub interlock: Option<vk::PhysicalDeviceFragmentShaderInterlockFeaturesEXT<'static>>,
    /// Features of VK_EXT_rasterization_order_attachment_access.
    pub order: Option<vk::PhysicalDeviceRasterizationOrderAttachmentAccessFeaturesEXT<'static>>,
    /// Features of VK_KHR_pipeline_executable_properties.
    pub executables: Option<vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR<'static>>,
    /// Features of VK_NV_shader_sm_builtins.
    pub processors: Option<vk::PhysicalDeviceShaderSMBuiltinsFeaturesNV<'static>>,
    /// Features of VK_KHR_acceleration_structure and VK_KHR_ray_query.
    pub rays: Option<(
        vk::PhysicalDeviceAccelerationStructureFeaturesKHR<'static>,
        vk::PhysicalDeviceRayQueryFeaturesKHR<'static>,
    )>,
}

impl EnabledStructures {
    /// Chains all structures for `VkDeviceCreateInfo::pNext`.
    pub fn chain(&mut self) -> vk::PhysicalDeviceFeatures2<'_> {
        let mut all = vk::PhysicalDeviceFeatures2::default()
            .features(self.core)
            .push_next(&mut self.vulkan12)
            .push_next(&mut self.vulkan13);
        if let Some(interlock) = &mut self.interlock {
            all = all.push_next(interlock);
        }
        if let Some(order) = &mut self.order {
            all = all.push_next(order);
        }
        if let Some(executables) = &mut self.executables {
            all = all.push_next(executables);
        }
        if let Some(processors) = &mut self.processors {
            all = all.push_next(processors);
        }
        if let Some((structures, query)) = &mut self.rays {
            all = all.push_next(structures).push_next(query);
        }
        all
    }
}

impl Requirement {
    /// Returns the feature sets that meet the requirement, each in addition to [`Enabled::FLOOR`]. Any one of them is
    /// enough.
    pub fn any_of(self) -> Vec<Enabled> {
        let none = Enabled::NONE;
        let geometry = Enabled { geometry_shader: true, multi_viewport: true, ..none };
        let vertex = Enabled { vertex_layer_output: true, ..none };
        vec![match self {
            Self::PixelInterlock => Enabled { fragment_shader_pixel_interlock: true, ..none },
            Self::FragmentStores => Enabled { fragment_stores_and_atomics: true, ..none },
            Self::RasterOrder => Enabled { rasterization_order_color_attachment_access: true, ..none },
            Self::ExtendedFormats => Enabled { storage_image_extended_formats: true, ..none },
            Self::GeometryLayers => geometry,
            Self::VertexLayers => vertex,
            Self::Layers => return vec![vertex, geometry],
            Self::Viewports => Enabled { multi_viewport: true, ..none },
            Self::Tessellation => Enabled { tessellation_shader: true, ..none },
            Self::Lines => Enabled { fill_mode_non_solid: true, ..none },
            Self::RayQuery => Enabled { ray_query: true, ..none },
        }]
    }
}

impl Features {
    /// Returns the features that are also set in `enabled`.
    pub(in crate::gpu) fn only(self, enabled: &Enabled) -> Self {
        let floor = [
            (enabled.synchronization2, "synchronization2"),
            (enabled.dynamic_rendering, "dynamicRendering"),
            (enabled.scalar_block_layout, "scalarBlockLayout"),
        ];
        let missing = floor.into_iter().find(|(has, _)| !has).map(|(_, name)| name.to_owned());
        Self {
            below_floor: self.below_floor.or(missing),
            fragment_shader_pixel_interlock: self.fragment_shader_pixel_interlock
                && enabled.fragment_shader_pixel_interlock,
            rasterization_order_color_attachment_access: self.rasterization_order_color_attachment_access
                && enabled.rasterization_order_color_attachment_access,
            conservative_rasterization: self.conservative_rasterization && enabled.conservative_rasterization,
            ray_query: self.ray_query && enabled.ray_query,
            geometry_shader: self.geometry_shader && enabled.geometry_shader,
            tessellation_shader: self.tessellation_shader && enabled.tessellation_shader,
            fill_mode_non_solid: self.fill_mode_non_solid && enabled.fill_mode_non_solid,
            vertex_layer_output: self.vertex_layer_output && enabled.vertex_layer_output,
            multi_viewport: self.multi_viewport && enabled.multi_viewport,
            max_viewports: if enabled.multi_viewport { self.max_viewports } else { 1 },
            storage_image_extended_formats: self.storage_image_extended_formats
                && enabled.storage_image_extended_formats,
            fragment_stores_and_atomics: self.fragment_stores_and_atomics && enabled.fragment_stores_and_atomics,
            compute_full_subgroups: self.compute_full_subgroups && enabled.compute_full_subgroups,
            calibrated_timestamps: self.calibrated_timestamps && enabled.calibrated_timestamps,
            pipeline_statistics_query: self.pipeline_statistics_query && enabled.pipeline_statistics_query,
            pipeline_executable_info: self.pipeline_executable_info && enabled.pipeline_executable_info,
            shader_sm_builtins: self.shader_sm_builtins && enabled.shader_sm_builtins,
            timestamp_valid_bits: if enabled.timestamps { self.timestamp_valid_bits } else { 0 },
            ..self
        }
    }
}
