//! The window's swapchain.

use super::device::Device;
use super::failed;
use crate::{Error, Result};
use ash::{khr, vk};

/// The window's images, all of one size.
pub struct Swapchain {
    device: ash::Device,
    loader: khr::swapchain::Device,
    pub handle: vk::SwapchainKHR,
    pub format: vk::Format,
    pub size: [u32; 2],
    /// Whether the images can be copied from.
    pub is_readable: bool,
    pub images: Vec<vk::Image>,
    pub views: Vec<vk::ImageView>,
    /// One semaphore per image, signalled when the image has been drawn.
    pub drawn: Vec<vk::Semaphore>,
}

/// Result of acquiring or presenting an image.
pub enum Turn<T> {
    Done(T),
    /// The window has a new size: the images must be recreated.
    Stale,
}

impl Swapchain {
    /// Creates images for a window of `size` pixels, to replace `old` ones that are no longer in use. Returns `None` if the window has no
    /// area.
    pub fn new(device: &Device, size: [u32; 2], old: Option<Self>) -> Result<Option<Self>> {
        let (surfaces, surface) = device.surface();
        let fail = failed("make", "the window's images");
        // SAFETY: device and surface belong together.
        let (can, formats) = unsafe {
            let can = surfaces.get_physical_device_surface_capabilities(device.physical, surface);
            (
                can.map_err(&fail)?,
                surfaces.get_physical_device_surface_formats(device.physical, surface).map_err(&fail)?,
            )
        };
        // A width of all ones means that the images determine the size of the window.
        let own = can.current_extent.width != u32::MAX;
        let (least, most) = (can.min_image_extent, can.max_image_extent);
        let size = match own {
            true => [can.current_extent.width, can.current_extent.height],
            false => [size[0].clamp(least.width, most.width), size[1].clamp(least.height, most.height)],
        };
        if size.contains(&0) {
            return Ok(None);
        }
        // The bytes are already encoded for display, so the device must not encode them again.
        let plain = [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM];
        let is_plain = |format: &&vk::SurfaceFormatKHR| {
            plain.contains(&format.format) && format.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR
        };
        let usage = vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::COLOR_ATTACHMENT;
        let read = can.supported_usage_flags & vk::ImageUsageFlags::TRANSFER_SRC;
        let Some(format) = formats.iter().find(is_plain).filter(|_| can.supported_usage_flags.contains(usage)) else {
            return Err(Error::Refused("a window of 8-bit channels that pictures can be copied to".into()));
        };
        let most = if can.max_image_count == 0 { u32::MAX } else { can.max_image_count };
        let alpha = [vk::CompositeAlphaFlagsKHR::OPAQUE, vk::CompositeAlphaFlagsKHR::INHERIT];
        let alpha = alpha.into_iter().find(|flag| can.supported_composite_alpha.contains(*flag));
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface)
            .min_image_count((can.min_image_count + 1).min(most))
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(vk::Extent2D { width: size[0], height: size[1] })
            .image_array_layers(1)
            .image_usage(usage | read)
            .pre_transform(can.current_transform)
            .composite_alpha(alpha.unwrap_or(vk::CompositeAlphaFlagsKHR::OPAQUE))
            .present_mode(vk::PresentModeKHR::FIFO)
            .clipped(true)
            .old_swapchain(old.as_ref().map_or(vk::SwapchainKHR::null(), |old| old.handle));
        let loader = khr::swapchain::Device::new(&device.origin().1, &device.handle);
        // SAFETY: `info` is complete, and the old images belong to this surface.
        let handle = unsafe { loader.create_swapchain(&info, None) }.map_err(&fail)?;
        let mut chain = Self {
            device: device.handle.clone(),
            loader,
            handle,
            format: format.format,
            size,
            is_readable: !read.is_empty(),
            images: Vec::new(),
            views: Vec::new(),
            drawn: Vec::new(),
        };
        // SAFETY: the swapchain was just created.
        chain.images = unsafe { chain.loader.get_swapchain_images(handle) }.map_err(&fail)?;
        for image in &chain.images {
            let range = vk::ImageSubresourceRange::default()
                .aspect_mask(vk::ImageAspectFlags::COLOR)
                .level_count(1)
                .layer_count(1);
            let info = vk::ImageViewCreateInfo::default()
                .image(*image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format.format)
                .subresource_range(range);
            // SAFETY: the image has this format; both handles are stored at once.
            unsafe {
                chain.views.push(device.handle.create_image_view(&info, None).map_err(&fail)?);
                let semaphore = device.handle.create_semaphore(&vk::SemaphoreCreateInfo::default(), None);
                chain.drawn.push(semaphore.map_err(&fail)?);
            }
        }
        Ok(Some(chain))
    }

    /// Returns the next image to draw to; `acquired` is signalled once drawing to it may begin.
    pub fn acquire(&self, acquired: vk::Semaphore) -> Result<Turn<usize>> {
        // SAFETY: the semaphore belongs to this device, and nothing waits for it.
        match unsafe { self.loader.acquire_next_image(self.handle, u64::MAX, acquired, vk::Fence::null()) } {
            Ok((image, _)) => Ok(Turn::Done(image as usize)),
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(Turn::Stale),
            Err(result) => Err(failed("ask for", "the window's next image")(result)),
        }
    }

    /// Presents an image once it has been drawn.
    pub fn present(&self, queue: vk::Queue, image: usize) -> Result<Turn<()>> {
        let (chains, images, drawn) = ([self.handle], [image as u32], [self.drawn[image]]);
        let info = vk::PresentInfoKHR::default().swapchains(&chains).image_indices(&images).wait_semaphores(&drawn);
        // SAFETY: the image was acquired, and the submitted work will signal its semaphore.
        match unsafe { self.loader.queue_present(queue, &info) } {
            Ok(false) => Ok(Turn::Done(())),
            Ok(true) | Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(Turn::Stale),
            Err(result) => Err(failed("show", "the window's image")(result)),
        }
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        // SAFETY: the owner has waited until nothing uses the images.
        unsafe {
            self.views.iter().for_each(|view| self.device.destroy_image_view(*view, None));
            self.drawn.iter().for_each(|semaphore| self.device.destroy_semaphore(*semaphore, None));
            self.loader.destroy_swapchain(self.handle, None);
        }
    }
}
