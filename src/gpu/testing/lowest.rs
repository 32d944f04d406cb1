//! For tests: a device that reports less than it supports, so that code for less capable devices can be tested on any
//! device.

use crate::gpu::Features;
use crate::gpu::device::features::STORAGE_BUFFERS;
use crate::gpu::testing::{lowered, testing};

impl Features {
    /// Returns the device's features, or fewer and lower ones if tests request them: limits as low as Vulkan 1.3
    /// allows, or no optional features. Features that are not reported are not enabled, so that the validation layer
    /// catches their use.
    pub(in crate::gpu) fn lowered_for_tests(self) -> Self {
        let limited = if testing().lowest_limits { self.with_lowest_limits() } else { self };
        let limited = if testing().no_features { limited.without_features() } else { limited };
        lowered().into_iter().fold(limited, Self::just_below)
    }

    /// Applies the Required Limits of the Vulkan 1.3 specification, except for storage buffers, whose number is this
    /// program's floor.
    fn with_lowest_limits(self) -> Self {
        Self {
            max_storage_buffer_range: 1 << 27,
            max_color_attachments: 4,
            max_fragment_output_attachments: 4,
            max_per_stage_descriptor_input_attachments: 4,
            max_fragment_combined_output_resources: 4,
            max_per_stage_descriptor_storage_buffers: STORAGE_BUFFERS,
            max_per_stage_descriptor_storage_images: 4,
            max_bound_descriptor_sets: 4,
            max_image_dimension_2d: 4096,
            max_image_dimension_3d: 256,
            max_viewports: self.max_viewports.min(16),
            max_framebuffer_layers: 256,
            max_compute_shared_memory_bytes: 16 << 10,
            max_compute_workgroup_threads: 128,
            // The rasterizer keeps its real precision; it is safe to assume a coarser one.
            sub_pixel_precision_bits: 4,
            ..self
        }
    }

    fn without_features(self) -> Self {
        Self {
            fragment_shader_pixel_interlock: false,
            rasterization_order_color_attachment_access: false,
            conservative_rasterization: false,
            ray_query: false,
            dynamic_rendering_local_read: false,
            geometry_shader: false,
            tessellation_shader: false,
            fill_mode_non_solid: false,
            vertex_layer_output: false,
            multi_viewport: false,
            max_viewports: 1,
            storage_image_extended_formats: false,
            fragment_stores_and_atomics: false,
            float32_blend: false,
            calibrated_timestamps: false,
            pipeline_statistics_query: false,
            pipeline_executable_info: false,
            shader_sm_builtins: false,
            subgroup_arithmetic: false,
            subgroup_ballot: false,
            compute_full_subgroups: false,
            buffer_int64_atomics: false,
            timestamp_valid_bits: 0,
            ..self
        }
    }
}
