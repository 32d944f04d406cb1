//! Limits of a device, by their Vulkan names: how much of each is needed, and whether a device has that much.

use crate::Need;
use crate::gpu::Features;
use crate::gpu::device::features::STORAGE_BUFFERS;

/// A limit of a device, and how large it has to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    /// Its name in VkPhysicalDeviceLimits.
    pub name: &'static str,
    /// The least value that is needed.
    pub least: u64,
}

macro_rules! limits {
    ($($(#[$doc:meta])* $make:ident = $name:literal of $field:ident;)*) => {
        impl Limit {
            $($(#[$doc])* pub const fn $make(least: u64) -> Self {
                Self { name: $name, least }
            })*

            /// The device's value of this limit; 0 where no limit above has the name.
            fn of(&self, features: &Features) -> u64 {
                match self.name {
                    $($name => features.$field.into(),)*
                    _ => 0,
                }
            }
        }

        impl Features {
            /// The same features, with one less of this limit than is needed.
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
    /// Storage buffers of a shader stage.
    storage_buffers = "maxPerStageDescriptorStorageBuffers" of max_per_stage_descriptor_storage_buffers;
    /// Bytes of shared memory of a workgroup.
    shared_memory = "maxComputeSharedMemorySize" of max_compute_shared_memory_bytes;
    /// Threads of a workgroup.
    threads = "maxComputeWorkGroupInvocations" of max_compute_workgroup_threads;
    /// Bytes of a storage buffer.
    buffer_range = "maxStorageBufferRange" of max_storage_buffer_range;
    /// Texels per side of an image.
    image_2d = "maxImageDimension2D" of max_image_dimension_2d;
    /// Texels per side of a volume.
    image_3d = "maxImageDimension3D" of max_image_dimension_3d;
    /// Layers of a render.
    layers = "maxFramebufferLayers" of max_framebuffer_layers;
    /// Color attachments of a render.
    color_attachments = "maxColorAttachments" of max_color_attachments;
    /// Color attachments that a fragment shader writes.
    output_attachments = "maxFragmentOutputAttachments" of max_fragment_output_attachments;
    /// Input attachments that a fragment shader reads.
    input_attachments = "maxPerStageDescriptorInputAttachments" of max_per_stage_descriptor_input_attachments;
    /// Color attachments, storage buffers and storage images of a fragment shader together.
    output_resources = "maxFragmentCombinedOutputResources" of max_fragment_combined_output_resources;
}

impl Limit {
    /// The limits that everything needs, beyond those that Vulkan 1.3 guarantees.
    pub const FLOOR: [Self; 1] = [Self::storage_buffers(STORAGE_BUFFERS as u64)];

    /// The limits that a fragment shader needs, with `buffers` storage buffers and `attachments` color attachments
    /// that it also reads.
    pub fn attachments(attachments: u32, buffers: u32) -> [Self; 4] {
        let (attachments, buffers) = (u64::from(attachments), u64::from(buffers));
        [
            Self::color_attachments(attachments),
            Self::output_attachments(attachments),
            Self::input_attachments(attachments),
            Self::output_resources(attachments + buffers),
        ]
    }

    /// The reason to refuse a device that has less, with `what` behind the number; none where the device has enough.
    pub fn lacks(&self, features: &Features, what: &str) -> Option<Need> {
        let has = self.of(features);
        (has < self.least).then(|| Need::Limit { limit: *self, has, what: what.into() })
    }
}
