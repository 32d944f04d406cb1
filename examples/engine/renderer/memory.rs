//! Buffers and the render target, in memory from the renderer's allocator, and descriptor sets.

use super::{Gpu, Result};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{AllocationCreateDesc, AllocationScheme};
use std::ffi::c_void;
use std::ptr::NonNull;

pub struct Buffer {
    pub handle: vk::Buffer,
    pub bytes: u64,
    /// Address at which the host sees the buffer.
    pub mapped: Option<NonNull<c_void>>,
}

impl Buffer {
    /// Creates a storage buffer that may be copied to and from; `location` decides whether the host can access it.
    pub fn new(gpu: &mut Gpu, name: &str, bytes: u32, location: MemoryLocation) -> Result<Self> {
        let copied = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().usage(vk::BufferUsageFlags::STORAGE_BUFFER | copied);
        let allocation_scheme = AllocationScheme::GpuAllocatorManaged;
        // SAFETY: `info` is complete, the handle is passed to `keep` at once, and the memory is new and as large as the buffer needs.
        unsafe {
            let handle = gpu.device.create_buffer(&info.size(bytes.into()), None)?;
            gpu.keep(move |device| device.destroy_buffer(handle, None));
            let requirements = gpu.device.get_buffer_memory_requirements(handle);
            let wanted = AllocationCreateDesc { name, requirements, location, linear: true, allocation_scheme };
            let (memory, offset, mapped) = allocate(gpu, &wanted)?;
            gpu.device.bind_buffer_memory(handle, memory, offset)?;
            Ok(Self { handle, bytes: bytes.into(), mapped })
        }
    }

    /// Reads a whole buffer that is mapped on the host. The device must be done with it.
    pub fn read<T: bytemuck::Pod>(&self) -> Result<Vec<T>> {
        let from = self.mapped.ok_or("the host cannot read there")?;
        // SAFETY: the memory is mapped while the device is open. The device or the allocator has written it, so that every byte is
        // initialized.
        let bytes = unsafe { std::slice::from_raw_parts(from.as_ptr().cast::<u8>(), self.bytes as usize) };
        Ok(bytemuck::pod_collect_to_vec(bytes))
    }
}

/// An image that is rendered to and then copied from.
pub struct Target {
    pub image: vk::Image,
    pub view: vk::ImageView,
    pub size: [u32; 2],
}

impl Target {
    /// Blended in linear light and stored as sRGB, as in the PNG.
    pub const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;
    /// Used for both rendering and copying.
    pub const LAYOUT: vk::ImageLayout = vk::ImageLayout::GENERAL;

    pub fn new(gpu: &mut Gpu, size: [u32; 2]) -> Result<Self> {
        let copied = vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
        let info = vk::ImageCreateInfo::default().image_type(vk::ImageType::TYPE_2D).format(Self::FORMAT);
        let info = info.extent(vk::Extent3D { width: size[0], height: size[1], depth: 1 });
        let info = info.mip_levels(1).array_layers(1).samples(vk::SampleCountFlags::TYPE_1);
        let info = info.usage(vk::ImageUsageFlags::COLOR_ATTACHMENT | copied);
        let view = vk::ImageViewCreateInfo::default().view_type(vk::ImageViewType::TYPE_2D).format(Self::FORMAT);
        let (location, allocation_scheme) = (MemoryLocation::GpuOnly, AllocationScheme::GpuAllocatorManaged);
        // SAFETY: both structures are complete, each handle is passed to `keep` at once, and the memory is new and as large as the image
        // needs.
        unsafe {
            let image = gpu.device.create_image(&info, None)?;
            gpu.keep(move |device| device.destroy_image(image, None));
            let (name, requirements) = ("target", gpu.device.get_image_memory_requirements(image));
            let wanted = AllocationCreateDesc { name, requirements, location, linear: false, allocation_scheme };
            let (memory, offset, _) = allocate(gpu, &wanted)?;
            gpu.device.bind_image_memory(image, memory, offset)?;
            let view = gpu.device.create_image_view(&view.image(image).subresource_range(whole_image()), None)?;
            gpu.keep(move |device| device.destroy_image_view(view, None));
            Ok(Self { image, view, size })
        }
    }
}

/// Returns the only layer of a color image, for copies.
pub fn whole_layer() -> vk::ImageSubresourceLayers {
    vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1)
}

/// Returns the whole of a color image, for views and barriers.
pub fn whole_image() -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange::default().aspect_mask(vk::ImageAspectFlags::COLOR).level_count(1).layer_count(1)
}

/// Allocates memory that is kept while the device is open. Returns the memory, the offset in it, and its host address if it has one.
fn allocate(gpu: &mut Gpu, wanted: &AllocationCreateDesc) -> Result<(vk::DeviceMemory, u64, Option<NonNull<c_void>>)> {
    let allocator = (*gpu.allocator).clone();
    let allocation = allocator.lock().map_err(|_| "the allocator is broken")?.allocate(wanted)?;
    // SAFETY: the allocation is kept as long as the memory is used.
    let place = (unsafe { allocation.memory() }, allocation.offset(), allocation.mapped_ptr());
    // Memory that cannot be freed shows up in the allocator's report.
    gpu.keep(move |_| drop(allocator.lock().map(|mut allocator| allocator.free(allocation))));
    Ok(place)
}

/// A descriptor set that is visible to all stages.
pub struct Set {
    pub layout: vk::DescriptorSetLayout,
    pub handle: vk::DescriptorSet,
}

impl Set {
    /// Creates a set with these bindings, one descriptor each. The descriptors are still to be written.
    pub fn new(gpu: &mut Gpu, bindings: &[vk::DescriptorSetLayoutBinding]) -> Result<Self> {
        let size = vk::DescriptorPoolSize::default().descriptor_count(1);
        let sizes: Vec<_> = bindings.iter().map(|binding| size.ty(binding.descriptor_type)).collect();
        let layout = vk::DescriptorSetLayoutCreateInfo::default().bindings(bindings);
        let pool = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: each handle is passed to `keep` at once, and everything that the structures point to is alive.
        unsafe {
            let layout = gpu.device.create_descriptor_set_layout(&layout, None)?;
            gpu.keep(move |device| device.destroy_descriptor_set_layout(layout, None));
            let pool = gpu.device.create_descriptor_pool(&pool, None)?;
            gpu.keep(move |device| device.destroy_descriptor_pool(pool, None));
            let layouts = [layout];
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            Ok(Self { layout, handle: gpu.device.allocate_descriptor_sets(&info)?[0] })
        }
    }

    /// Creates a set that binds these storage buffers, from binding 0 on.
    pub fn of_buffers(gpu: &mut Gpu, buffers: &[&Buffer]) -> Result<Self> {
        let (storage, all) = (vk::DescriptorType::STORAGE_BUFFER, vk::ShaderStageFlags::ALL);
        let binding = vk::DescriptorSetLayoutBinding::default().descriptor_type(storage).descriptor_count(1);
        let binding = |i| binding.stage_flags(all).binding(i as u32);
        let set = Self::new(gpu, &(0..buffers.len()).map(binding).collect::<Vec<_>>())?;
        for (i, buffer) in buffers.iter().enumerate() {
            let buffers = [vk::DescriptorBufferInfo::default().buffer(buffer.handle).range(vk::WHOLE_SIZE)];
            let write = vk::WriteDescriptorSet::default().dst_set(set.handle).dst_binding(i as u32);
            // SAFETY: no commands use the set yet, and the buffers live as long as the set.
            unsafe { gpu.device.update_descriptor_sets(&[write.descriptor_type(storage).buffer_info(&buffers)], &[]) };
        }
        Ok(set)
    }
}
