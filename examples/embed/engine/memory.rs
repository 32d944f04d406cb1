//! Buffers and an image, each with memory of its own.

use super::{Gpu, Result};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::rc::Rc;

pub struct Buffer {
    gpu: Rc<Gpu>,
    pub handle: vk::Buffer,
    pub bytes: u64,
    allocation: Option<Allocation>,
}

impl Buffer {
    /// A storage buffer that may be copied to and from; `location` says whether the host sees it.
    pub fn new(gpu: &Rc<Gpu>, name: &str, bytes: u64, location: MemoryLocation) -> Result<Self> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        // SAFETY: `info` is whole; the handle goes into its owner at once.
        let handle = unsafe { gpu.device.create_buffer(&info, None) }?;
        let mut buffer = Self { gpu: gpu.clone(), handle, bytes, allocation: None };
        // SAFETY: the buffer is of this device.
        let requirements = unsafe { gpu.device.get_buffer_memory_requirements(handle) };
        let allocation = allocate(gpu, name, requirements, location, true)?;
        let (memory, offset) = place(&allocation);
        buffer.allocation = Some(allocation);
        // SAFETY: the memory is new, is as large as the buffer asks and lives as long.
        unsafe { gpu.device.bind_buffer_memory(handle, memory, offset) }?;
        Ok(buffer)
    }

    /// Writes to the start of a buffer that the host sees.
    pub fn write<T: bytemuck::Pod>(&mut self, data: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let mapped = self.allocation.as_mut().and_then(Allocation::mapped_slice_mut);
        let to = mapped.and_then(|mapped| mapped.get_mut(..bytes.len())).ok_or("the host cannot write there")?;
        to.copy_from_slice(bytes);
        Ok(())
    }

    /// All of a buffer that the host sees. The device must be done with it.
    pub fn read<T: bytemuck::Pod>(&self) -> Result<Vec<T>> {
        let mapped = self.allocation.as_ref().and_then(Allocation::mapped_slice);
        let bytes = mapped.and_then(|mapped| mapped.get(..self.bytes as usize)).ok_or("the host cannot read there")?;
        Ok(bytemuck::pod_collect_to_vec(bytes))
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: the device is done with all frames before anything of the renderer is dropped.
        unsafe { self.gpu.device.destroy_buffer(self.handle, None) };
        free(&self.gpu, self.allocation.take());
    }
}

/// An image that is drawn to and then copied from.
pub struct Target {
    gpu: Rc<Gpu>,
    pub image: vk::Image,
    pub view: vk::ImageView,
    pub size: [u32; 2],
    allocation: Option<Allocation>,
}

impl Target {
    /// Blending is done in linear light and kept as sRGB, as the PNG has it.
    pub const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;

    pub fn new(gpu: &Rc<Gpu>, size: [u32; 2]) -> Result<Self> {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(Self::FORMAT)
            .extent(vk::Extent3D { width: size[0], height: size[1], depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC);
        // SAFETY: `info` is whole; the handle goes into its owner at once.
        let image = unsafe { gpu.device.create_image(&info, None) }?;
        let mut target = Self { gpu: gpu.clone(), image, view: vk::ImageView::null(), size, allocation: None };
        // SAFETY: the image is of this device.
        let requirements = unsafe { gpu.device.get_image_memory_requirements(image) };
        let allocation = allocate(gpu, "target", requirements, MemoryLocation::GpuOnly, false)?;
        let (memory, offset) = place(&allocation);
        target.allocation = Some(allocation);
        let range = whole_image();
        // SAFETY: the memory is new, is as large as the image asks and lives as long.
        target.view = unsafe {
            gpu.device.bind_image_memory(image, memory, offset)?;
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(Self::FORMAT)
                .subresource_range(range);
            gpu.device.create_image_view(&info, None)
        }?;
        Ok(target)
    }
}

impl Drop for Target {
    fn drop(&mut self) {
        // SAFETY: the device is done with all frames before anything of the renderer is dropped.
        unsafe {
            self.gpu.device.destroy_image_view(self.view, None);
            self.gpu.device.destroy_image(self.image, None);
        }
        free(&self.gpu, self.allocation.take());
    }
}

/// The one layer of an image of colours.
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
    let scheme = AllocationScheme::GpuAllocatorManaged;
    let wanted = AllocationCreateDesc { name, requirements, location, linear, allocation_scheme: scheme };
    let allocator = gpu.allocator()?;
    let mut allocator = allocator.lock().map_err(|_| "the allocator is broken")?;
    Ok(allocator.allocate(&wanted)?)
}

fn place(allocation: &Allocation) -> (vk::DeviceMemory, u64) {
    // SAFETY: the memory is used for what it was allocated for, and freed by `free` alone.
    unsafe { (allocation.memory(), allocation.offset()) }
}

fn free(gpu: &Gpu, allocation: Option<Allocation>) {
    if let (Some(allocation), Ok(allocator)) = (allocation, gpu.allocator())
        && let Ok(mut allocator) = allocator.lock()
    {
        // What cannot be freed is in the allocator's report.
        let _ = allocator.free(allocation);
    }
}
