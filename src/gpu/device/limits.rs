//! Device limits by their Vulkan names: the values required, and whether a device meets them.

use crate::Need;
use crate::gpu::Features;
use crate::gpu::device::features::STORAGE_BUFFERS;

/// A device limit and the lowest value that suffices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    /// Name in VkPhysicalDeviceLimits.
    pub name: &'static str,
    /// Lowest value that suffices.
    pub least: u64,
}

macro_rules! limits {
    ($($(#[$doc:meta])* $make:ident = $name:literal of $field:ident;)*) => {
        impl Limit {
            $($(#[$doc])* pub const fn $make(least: u64) -> Self {
                Self { name: $name, least }
            })*

            /// Returns the device's value of this limit; 0 if no limit above has this name.
            fn of(&self, features: &Features) -> u64 {
                match self.name {
                    $($name => features.$field.into(),)*
                    _ => 0,
                }
            }
        }

        impl Features {
            /// Returns the same features with this limit one below the required value.
            pub(in crate::gpu) fn just_below(mut self, limit: Limit) -> Self {
                let below = u32::try_from(limit.least.saturating_sub(1)).unwrap_or(u32::MAX);
                match limit.name {
                    $($name => self.$field = self.$field.min(below),)*
                    _ => {}
                }
                self
            }
        }
    };
}

limits! {
    /// Storage buffers per shader stage.
    storage_buffers = "maxPerStageDescriptorStorageBuffers" of max_per_stage_descriptor_storage_buffers;
    /// Shared memory per workgroup, in bytes.
    shared_memory = "maxComputeSharedMemorySize" of max_compute_shared_memory_bytes;
    /// Threads per workgroup.
    threads = "maxComputeWorkGroupInvocations" of max_compute_workgroup_threads;
    /// Size of a storage buffer, in bytes.
    buffer_range = "maxStorageBufferRange" of max_storage_buffer_range;
    /// Side of a 2D image, in texels.
    image_2d = "maxImageDimension2D" of max_image_dimension_2d;
    /// Side of a 3D image, in texels.
    image_3d = "maxImageDimension3D" of max_image_dimension_3d;
    /// Layers per render pass.
    layers = "maxFramebufferLayers" of max_framebuffer_layers;
    /// Color attachments per render pass.
    color_attachments = "maxColorAttachments" of max_color_attachments;
    /// Color attachments that a fragment shader writes.
    output_attachments = "maxFragmentOutputAttachments" of max_fragment_output_attachments;
    /// Input attachments that a fragment shader reads.
    input_attachments = "maxPerStageDescriptorInputAttachments" of max_per_stage_descriptor_input_attachments;
    /// Color attachments, storage buffers and storage images of a fragment shader combined.
    output_resources = "maxFragmentCombinedOutputResources" of max_fragment_combined_output_resources;
}

impl Limit {
    /// The limits that every path needs, beyond the guarantees of Vulkan 1.3.
    pub const FLOOR: [Self; 1] = [Self::storage_buffers(STORAGE_BUFFERS as u64)];

    /// Returns the limits required by a fragment shader with `buffers` storage buffers and `attachments` color
    /// attachments that it also reads.
    pub fn attachments(attachments: u32, buffers: u32) -> [Self; 4] {
        let (attachments, buffers) = (u64::from(attachments), u64::from(buffers));
        [
            Self::color_attachments(attachments),
            Self::output_attachments(attachments),
            Self::input_attachments(attachments),
            Self::output_resources(attachments + buffers),
        ]
    }

    /// Returns why a device with a lower value is refused, with `what` after the number; `None` if the device has enough.
    pub fn lacks(&self, features: &Features, what: &str) -> Option<Need> {
        let has = self.of(features);
        (has < self.least).then(|| Need::Limit { limit: *self, has, what: what.into() })
    }
}
