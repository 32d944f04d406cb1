//! Frames in flight: while the device works on one frame, the host records the next.

use super::device::Device;
use super::failed;
use super::swapchain::Swapchain;
use crate::Result;
use crate::gpu::{Buffer, fault};
use ash::vk;

pub const FRAMES_IN_FLIGHT: u32 = 2;

/// Resources of one frame, in use until the device is done with it.
struct Slot {
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    acquired: vk::Semaphore,
    done: vk::Fence,
}

pub struct Frames {
    device: ash::Device,
    slots: Vec<Slot>,
    /// Command pool for copies between frames.
    pool: vk::CommandPool,
}

/// Background color outside the picture.
const BEHIND: [f32; 4] = [0.1, 0.1, 0.1, 1.0];

impl Frames {
    pub fn new(device: &Device) -> Result<Self> {
        let handle = device.handle.clone();
        let mut frames = Self { device: handle.clone(), slots: Vec::new(), pool: vk::CommandPool::null() };
        let fail = failed("make", "frames");
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(device.queue_family);
        // Signalled initially: the first frame has nothing to wait for.
        let fence = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
        // SAFETY: the device was opened with this queue family.
        frames.pool = unsafe { handle.create_command_pool(&pool, None) }.map_err(&fail)?;
        for _ in 0..FRAMES_IN_FLIGHT {
            // SAFETY: as above, and each handle is stored at once.
            unsafe {
                frames.slots.push(Slot {
                    pool: handle.create_command_pool(&pool, None).map_err(&fail)?,
                    commands: vk::CommandBuffer::null(),
                    acquired: vk::Semaphore::null(),
                    done: vk::Fence::null(),
                });
                let Some(slot) = frames.slots.last_mut() else { continue };
                let commands = vk::CommandBufferAllocateInfo::default().command_pool(slot.pool).command_buffer_count(1);
                slot.commands = handle.allocate_command_buffers(&commands).map_err(&fail)?[0];
                slot.acquired = handle.create_semaphore(&vk::SemaphoreCreateInfo::default(), None).map_err(&fail)?;
                slot.done = handle.create_fence(&fence, None).map_err(&fail)?;
            }
        }
        Ok(frames)
    }

    fn slot(&self, frame: u64) -> &Slot {
        &self.slots[(frame % u64::from(FRAMES_IN_FLIGHT)) as usize]
    }

    /// Returns the command pool for copies between frames.
    pub fn pool(&self) -> vk::CommandPool {
        self.pool
    }

    /// Returns the semaphore that is signalled once the frame may draw to its image.
    pub fn acquired(&self, frame: u64) -> vk::Semaphore {
        self.slot(frame).acquired
    }

    /// Waits until the device is done with the previous frame that used the same slot.
    pub fn wait(&self, frame: u64) -> Result<()> {
        // SAFETY: the fence belongs to this device.
        let waited = unsafe { self.device.wait_for_fences(&[self.slot(frame).done], true, u64::MAX) };
        waited.map_err(failed("wait for", "a frame of the window"))
    }

    /// Begins recording the frame. The previous frame that used the same slot must be complete.
    pub fn begin(&self, frame: u64) -> Result<vk::CommandBuffer> {
        let (slot, fail) = (self.slot(frame), failed("record", "a frame of the window"));
        let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the frame that used this pool and buffer before is complete.
        unsafe {
            self.device.reset_command_pool(slot.pool, vk::CommandPoolResetFlags::empty()).map_err(&fail)?;
            self.device.begin_command_buffer(slot.commands, &once).map_err(&fail)?;
        }
        Ok(slot.commands)
    }

    /// Clears the window's image, and copies the picture to its upper left corner, cropped to fit.
    pub fn copy(
        &self,
        commands: vk::CommandBuffer,
        chain: &Swapchain,
        index: usize,
        picture: Option<(&Buffer, [u32; 2])>,
    ) {
        let (image, layout) = (chain.images[index], vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        let transfer = (vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::TRANSFER_WRITE);
        let nothing = (vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::NONE);
        self.barrier(commands, image, [vk::ImageLayout::UNDEFINED, layout], nothing, transfer);
        let color = vk::ClearColorValue { float32: BEHIND };
        // SAFETY: the image belongs to the window, is in this layout, and is acquired.
        unsafe { self.device.cmd_clear_color_image(commands, image, layout, &color, &[RANGE]) };
        self.barrier(commands, image, [layout, layout], transfer, transfer);
        let Some((buffer, size)) = picture else { return };
        let extent = |i: usize| size[i].min(chain.size[i]);
        let regions = [vk::BufferImageCopy::default()
            .buffer_row_length(size[0])
            .buffer_image_height(size[1])
            .image_subresource(vk::ImageSubresourceLayers::default().aspect_mask(RANGE.aspect_mask).layer_count(1))
            .image_extent(vk::Extent3D { width: extent(0), height: extent(1), depth: 1 })];
        if buffer.bytes() >= u64::from(size[0]) * u64::from(size[1]) * 4 {
            // SAFETY: the buffer has four bytes per pixel, and `Host` keeps it until the frame is complete. The commands that Gobo recorded
            // before ended with a barrier for everything that follows.
            unsafe { self.device.cmd_copy_buffer_to_image(commands, buffer.handle(), image, layout, &regions) };
        }
    }

    /// Draws over the window's image, copies the image to `film`, and prepares it for presentation.
    pub fn over(
        &self,
        commands: vk::CommandBuffer,
        chain: &Swapchain,
        index: usize,
        film: Option<&Buffer>,
        draw: impl FnOnce(vk::CommandBuffer) -> Result<()>,
    ) -> Result<()> {
        let (image, layout) = (chain.images[index], vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
        let copied = (vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::TRANSFER_WRITE);
        let drawn = (
            vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT,
            vk::AccessFlags2::COLOR_ATTACHMENT_READ | vk::AccessFlags2::COLOR_ATTACHMENT_WRITE,
        );
        self.barrier(commands, image, [vk::ImageLayout::TRANSFER_DST_OPTIMAL, layout], copied, drawn);
        let colors = [vk::RenderingAttachmentInfo::default()
            .image_view(chain.views[index])
            .image_layout(layout)
            .load_op(vk::AttachmentLoadOp::LOAD)
            .store_op(vk::AttachmentStoreOp::STORE)];
        let extent = vk::Extent2D { width: chain.size[0], height: chain.size[1] };
        let info = vk::RenderingInfo::default()
            .render_area(vk::Rect2D { extent, ..Default::default() })
            .layer_count(1)
            .color_attachments(&colors);
        // SAFETY: the image is in this layout, and rendering is ended below whether or not drawing succeeds.
        unsafe { self.device.cmd_begin_rendering(commands, &info) };
        let outcome = draw(commands);
        // SAFETY: begun above.
        unsafe { self.device.cmd_end_rendering(commands) };
        let shown = (vk::PipelineStageFlags2::NONE, vk::AccessFlags2::NONE);
        let wanted = u64::from(extent.width) * u64::from(extent.height) * 4;
        match film.filter(|film| chain.is_readable && film.bytes() >= wanted) {
            Some(film) => {
                let read = (vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::TRANSFER_READ);
                let from = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
                self.barrier(commands, image, [layout, from], drawn, read);
                let regions = [vk::BufferImageCopy::default()
                    .image_subresource(
                        vk::ImageSubresourceLayers::default().aspect_mask(RANGE.aspect_mask).layer_count(1),
                    )
                    .image_extent(vk::Extent3D { width: extent.width, height: extent.height, depth: 1 })];
                // SAFETY: the image is in this layout and readable, and the buffer has room for all of it.
                unsafe { self.device.cmd_copy_image_to_buffer(commands, image, from, film.handle(), &regions) };
                self.barrier(commands, image, [from, vk::ImageLayout::PRESENT_SRC_KHR], read, shown);
                let copied = [vk::MemoryBarrier2::default()
                    .src_stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)
                    .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
                    .dst_stage_mask(vk::PipelineStageFlags2::HOST)
                    .dst_access_mask(vk::AccessFlags2::HOST_READ)];
                // SAFETY: the commands are being recorded, outside rendering.
                unsafe {
                    let info = vk::DependencyInfo::default().memory_barriers(&copied);
                    self.device.cmd_pipeline_barrier2(commands, &info);
                }
            }
            None => self.barrier(commands, image, [layout, vk::ImageLayout::PRESENT_SRC_KHR], drawn, shown),
        }
        outcome
    }

    fn barrier(
        &self,
        commands: vk::CommandBuffer,
        image: vk::Image,
        [from, to]: [vk::ImageLayout; 2],
        before: (vk::PipelineStageFlags2, vk::AccessFlags2),
        after: (vk::PipelineStageFlags2, vk::AccessFlags2),
    ) {
        let barriers = [vk::ImageMemoryBarrier2::default()
            .image(image)
            .subresource_range(RANGE)
            .old_layout(from)
            .new_layout(to)
            .src_stage_mask(before.0)
            .src_access_mask(before.1)
            .dst_stage_mask(after.0)
            .dst_access_mask(after.1)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)];
        let info = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: the commands are being recorded, outside rendering.
        unsafe { self.device.cmd_pipeline_barrier2(commands, &info) };
    }

    /// Submits the frame. If the frame draws to an image of the window, `drawn` is signalled when the frame is complete.
    pub fn submit(&self, queue: vk::Queue, frame: u64, drawn: Option<vk::Semaphore>) -> Result<()> {
        let (slot, fail) = (self.slot(frame), failed("submit", "a frame of the window"));
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(slot.commands)];
        let waits = [vk::SemaphoreSubmitInfo::default()
            .semaphore(slot.acquired)
            .stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)];
        let signals = [vk::SemaphoreSubmitInfo::default()
            .semaphore(drawn.unwrap_or_default())
            .stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)];
        let mut submit = vk::SubmitInfo2::default().command_buffer_infos(&buffers);
        if drawn.is_some() {
            submit = submit.wait_semaphore_infos(&waits).signal_semaphore_infos(&signals);
        }
        // SAFETY: the frame is recorded, and everything it uses lives until its fence is signalled.
        unsafe {
            self.device.end_command_buffer(slot.commands).map_err(&fail)?;
            self.device.reset_fences(&[slot.done]).map_err(&fail)?;
            fault::submission(|| self.device.queue_submit2(queue, &[submit], slot.done)).map_err(&fail)
        }
    }
}

/// The entire image of the window.
const RANGE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

impl Drop for Frames {
    fn drop(&mut self) {
        // SAFETY: the device is idle (`Host::drop` waited); null handles are ignored.
        unsafe {
            self.device.destroy_command_pool(self.pool, None);
            for slot in &self.slots {
                self.device.destroy_fence(slot.done, None);
                self.device.destroy_semaphore(slot.acquired, None);
                self.device.destroy_command_pool(slot.pool, None);
            }
        }
    }
}
