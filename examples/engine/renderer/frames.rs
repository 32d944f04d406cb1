//! Two frames in flight: while the device works on one, the host records the next.

use super::{Gpu, Result};
use ash::vk;

pub const FRAMES_IN_FLIGHT: u32 = 2;

pub struct Frames {
    device: ash::Device,
    queue: vk::Queue,
    /// Per frame in flight: its commands, and the fence that is signalled when the device is done with them.
    slots: Vec<(vk::CommandBuffer, vk::Fence)>,
    /// Index of the frame being recorded or, between frames, of the next frame.
    pub next: u64,
}

impl Frames {
    pub fn new(gpu: &mut Gpu) -> Result<Self> {
        let reset = vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER;
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(gpu.queue_family).flags(reset);
        let commands = vk::CommandBufferAllocateInfo::default().command_buffer_count(FRAMES_IN_FLIGHT);
        // Signalled, so that the first frame waits for nothing.
        let fence = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
        let mut slots = Vec::new();
        // SAFETY: each handle is passed to `keep` at once.
        unsafe {
            let pool = gpu.device.create_command_pool(&pool, None)?;
            gpu.keep(move |device| device.destroy_command_pool(pool, None));
            for commands in gpu.device.allocate_command_buffers(&commands.command_pool(pool))? {
                let done = gpu.device.create_fence(&fence, None)?;
                gpu.keep(move |device| device.destroy_fence(done, None));
                slots.push((commands, done));
            }
        }
        Ok(Self { device: gpu.device.clone(), queue: gpu.queue, slots, next: 0 })
    }

    /// Waits on the host for the frame before the previous one, and starts recording. The previous frame uses the same buffers, so a
    /// barrier makes the device wait for it.
    pub fn begin(&self) -> Result<vk::CommandBuffer> {
        self.wait(self.next)?;
        let (commands, _) = self.slots[self.next as usize % self.slots.len()];
        let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the frame that used these commands has finished.
        unsafe { self.device.begin_command_buffer(commands, &once) }?;
        barrier(&self.device, commands);
        Ok(commands)
    }

    pub fn submit(&mut self) -> Result<()> {
        let (commands, done) = self.slots[self.next as usize % self.slots.len()];
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        let submit = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
        // SAFETY: the frame is recorded, and everything that it uses lives until its fence is signalled.
        unsafe {
            self.device.end_command_buffer(commands)?;
            self.device.reset_fences(&[done])?;
            self.device.queue_submit2(self.queue, &submit, done)?;
        }
        self.next += 1;
        Ok(())
    }

    /// Waits for the frame, or for the earlier one that used the same commands.
    pub fn wait(&self, frame: u64) -> Result<()> {
        let (_, done) = self.slots[frame as usize % self.slots.len()];
        // SAFETY: the fence belongs to this device.
        Ok(unsafe { self.device.wait_for_fences(&[done], true, u64::MAX) }?)
    }
}

/// Records a barrier: all later commands wait for all earlier ones and see their writes, and so does the host once the frame has finished.
pub fn barrier(device: &ash::Device, commands: vk::CommandBuffer) {
    let (all, write) = (vk::PipelineStageFlags2::ALL_COMMANDS, vk::AccessFlags2::MEMORY_WRITE);
    let barrier = vk::MemoryBarrier2::default().src_stage_mask(all).src_access_mask(write);
    let barrier = barrier.dst_stage_mask(all | vk::PipelineStageFlags2::HOST);
    let barriers = [barrier.dst_access_mask(write | vk::AccessFlags2::MEMORY_READ)];
    // SAFETY: the commands are being recorded, outside rendering.
    unsafe { device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().memory_barriers(&barriers)) };
}
