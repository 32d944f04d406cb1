//! Buffers, and the image that is drawn to, each with memory of its own.

use super::device::Kept;
use super::{Gpu, Result};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::ffi::c_void;
use std::ptr::NonNull;

pub struct Buffer {
    pub handle: vk::Buffer,
    pub bytes: u64,
    /// Where the host sees it.
    mapped: Option<NonNull<c_void>>,
}

impl Buffer {
    /// A storage buffer that may be copied to and from; `location` says whether the host sees it.
    pub fn new(gpu: &mut Gpu, name: &str, bytes: usize, location: MemoryLocation) -> Result<Self> {
        let copied = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().usage(vk::BufferUsageFlags::STORAGE_BUFFER | copied);
        // SAFETY: `info` is whole, and the handle is kept at once.
        let handle = unsafe { gpu.device.create_buffer(&info.size(bytes as u64), None) }?;
        gpu.keep(Kept::Buffer(handle));
        // SAFETY: the buffer is of this device.
        let needs = unsafe { gpu.device.get_buffer_memory_requirements(handle) };
        let allocation = allocate(gpu, name, needs, location, true)?;
        let mapped = allocation.mapped_ptr();
        // SAFETY: the memory is new, is as large as the buffer needs and is kept as long.
        let bound = unsafe { gpu.device.bind_buffer_memory(handle, allocation.memory(), allocation.offset()) };
        gpu.keep(Kept::Memory(allocation));
        bound?;
        Ok(Self { handle, bytes: bytes as u64, mapped })
    }

    /// Writes to the start of a buffer that the host sees. The device must be done with it.
    pub fn write<T: bytemuck::Pod>(&self, data: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let to = self.mapped.filter(|_| bytes.len() as u64 <= self.bytes).ok_or("the host cannot write there")?;
        // SAFETY: the memory is mapped as long as the device is open, and as long as the buffer.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), to.as_ptr().cast(), bytes.len()) };
        Ok(())
    }

    /// All of a buffer that the host sees. The device must be done with it.
    pub fn read<T: bytemuck::Pod>(&self) -> Result<Vec<T>> {
        let from = self.mapped.ok_or("the host cannot read there")?;
        // SAFETY: as in `write`; the device wrote, or the allocator, so that no byte is without a value.
        let bytes = unsafe { std::slice::from_raw_parts(from.as_ptr().cast::<u8>(), self.bytes as usize) };
        Ok(bytemuck::pod_collect_to_vec(bytes))
    }
}

/// An image that is drawn to and then copied from.
pub struct Target {
    pub image: vk::Image,
    pub view: vk::ImageView,
    pub size: [u32; 2],
}

impl Target {
    /// Blended in linear light, kept as sRGB, as the PNG has it.
    pub const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;

    pub fn new(gpu: &mut Gpu, size: [u32; 2]) -> Result<Self> {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(Self::FORMAT)
            .extent(vk::Extent3D { width: size[0], height: size[1], depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(
                vk::ImageUsageFlags::COLOR_ATTACHMENT
                    | vk::ImageUsageFlags::TRANSFER_SRC
                    | vk::ImageUsageFlags::TRANSFER_DST,
            );
        // SAFETY: `info` is whole, and the handle is kept at once.
        let image = unsafe { gpu.device.create_image(&info, None) }?;
        gpu.keep(Kept::Image(image));
        // SAFETY: the image is of this device.
        let needs = unsafe { gpu.device.get_image_memory_requirements(image) };
        let allocation = allocate(gpu, "target", needs, MemoryLocation::GpuOnly, false)?;
        // SAFETY: the memory is new, is as large as the image needs and is kept as long.
        let bound = unsafe { gpu.device.bind_image_memory(image, allocation.memory(), allocation.offset()) };
        gpu.keep(Kept::Memory(allocation));
        bound?;
        let info = vk::ImageViewCreateInfo::default()
            .image(image)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(Self::FORMAT)
            .subresource_range(whole_image());
        // SAFETY: the image has its memory, and the handle is kept at once.
        let view = unsafe { gpu.device.create_image_view(&info, None) }?;
        gpu.keep(Kept::View(view));
        Ok(Self { image, view, size })
    }
}

/// The one layer of an image of colors.
pub fn whole_image() -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange::default().aspect_mask(vk::ImageAspectFlags::COLOR).level_count(1).layer_count(1)
}

fn allocate(
    gpu: &Gpu,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
) -> Result<Allocation> {
    let allocation_scheme = AllocationScheme::GpuAllocatorManaged;
    let wanted = AllocationCreateDesc { name, requirements, location, linear, allocation_scheme };
    let allocator = gpu.allocator()?;
    let allocation = allocator.lock().map_err(|_| "the allocator is broken")?.allocate(&wanted)?;
    Ok(allocation)
}
