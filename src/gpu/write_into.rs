//! The resources of a set, written into a set of somebody else's.

use super::{Bindings, Resource};
use ash::vk;

impl Bindings {
    /// Writes the resources as they are now into `set`, that of binding 0 to `first_binding`; samplers come with their images.
    ///
    /// # Safety
    /// `set` is of this device, and has bindings of these kinds from `first_binding` on; no command that is pending uses them;
    /// and these bindings, which keep the resources alive, outlive the commands that do.
    pub unsafe fn write_into(&self, set: vk::DescriptorSet, first_binding: u32) {
        for (binding, (resource, sampler)) in (first_binding..).zip(self.parts()) {
            let write =
                vk::WriteDescriptorSet::default().dst_set(set).dst_binding(binding).descriptor_type(resource.kind());
            let handles;
            let mut structures;
            let buffers;
            let images;
            let write = match &resource {
                Resource::Buffer(buffer) => {
                    buffers = [vk::DescriptorBufferInfo::default().buffer(buffer.handle()).range(vk::WHOLE_SIZE)];
                    write.buffer_info(&buffers)
                }
                Resource::AccelerationStructure(structure) => {
                    handles = [structure.handle()];
                    structures =
                        vk::WriteDescriptorSetAccelerationStructureKHR::default().acceleration_structures(&handles);
                    write.descriptor_count(1).push_next(&mut structures)
                }
                Resource::StorageImage(image)
                | Resource::Texture(image)
                | Resource::InputAttachment(image)
                | Resource::Sampled(image, _)
                | Resource::Gathered(image) => {
                    let is_storage = matches!(resource, Resource::StorageImage(_));
                    let view = if is_storage { image.storage_view() } else { image.view() };
                    let info = vk::DescriptorImageInfo::default().image_view(view).sampler(sampler);
                    images = [info.image_layout(vk::ImageLayout::GENERAL)];
                    write.image_info(&images)
                }
            };
            // SAFETY: the caller says that the set may be written; its resources live as long as these bindings.
            unsafe { self.device().update_descriptor_sets(&[write], &[]) };
        }
    }
}
