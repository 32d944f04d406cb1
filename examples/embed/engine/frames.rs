//! Two frames in flight: while the device works on one, the host records the next.

use super::{Gpu, Result};
use ash::vk;
use std::rc::Rc;

pub const FRAMES_IN_FLIGHT: u32 = 2;

/// Timestamps of a frame: before and after each of its steps.
const TIMESTAMPS: u32 = 4;

/// What a frame needs for itself until the device is done with it.
struct Slot {
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    done: vk::Fence,
    queries: vk::QueryPool,
    is_timed: bool,
}

pub struct Frames {
    gpu: Rc<Gpu>,
    slots: Vec<Slot>,
}

impl Frames {
    pub fn new(gpu: &Rc<Gpu>) -> Result<Self> {
        let mut frames = Self { gpu: gpu.clone(), slots: Vec::new() };
        for _ in 0..FRAMES_IN_FLIGHT {
            frames.add()?;
        }
        Ok(frames)
    }

    fn add(&mut self) -> Result<()> {
        let null = (vk::CommandBuffer::null(), vk::Fence::null(), vk::QueryPool::null());
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(self.gpu.queue_family);
        let device = &self.gpu.device;
        // SAFETY: each handle goes into its owner at once.
        unsafe {
            let pool = device.create_command_pool(&pool, None)?;
            self.slots.push(Slot { pool, commands: null.0, done: null.1, queries: null.2, is_timed: false });
            let Some(slot) = self.slots.last_mut() else { return Ok(()) };
            let commands = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            slot.commands = device.allocate_command_buffers(&commands)?[0];
            // Signalled: nothing has to be waited for before the first frame.
            let done = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
            slot.done = device.create_fence(&done, None)?;
            if self.gpu.tick_ns > 0.0 {
                let queries = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP);
                slot.queries = device.create_query_pool(&queries.query_count(TIMESTAMPS), None)?;
            }
        }
        Ok(())
    }

    fn slot(&self, frame: u64) -> &Slot {
        &self.slots[(frame % u64::from(FRAMES_IN_FLIGHT)) as usize]
    }

    /// Waits until the device is done with the frame before the last one, and begins to record.
    pub fn begin(&mut self, frame: u64) -> Result<vk::CommandBuffer> {
        self.wait(frame)?;
        let (slot, device) = (self.slot(frame), &self.gpu.device);
        let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the frame that used these before is over.
        unsafe {
            device.reset_command_pool(slot.pool, vk::CommandPoolResetFlags::empty())?;
            device.begin_command_buffer(slot.commands, &once)?;
            if slot.queries != vk::QueryPool::null() {
                device.cmd_reset_query_pool(slot.commands, slot.queries, 0, TIMESTAMPS);
            }
        }
        Ok(slot.commands)
    }

    /// Notes the time at which the device is done with all before.
    pub fn stamp(&self, frame: u64, index: u32) {
        let slot = self.slot(frame);
        if slot.queries != vk::QueryPool::null() {
            let all = vk::PipelineStageFlags2::ALL_COMMANDS;
            // SAFETY: the frame is being recorded, and its queries were reset.
            unsafe { self.gpu.device.cmd_write_timestamp2(slot.commands, all, slot.queries, index) };
        }
    }

    pub fn submit(&mut self, frame: u64, is_timed: bool) -> Result<()> {
        let (slot, device) = (self.slot(frame), &self.gpu.device);
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(slot.commands)];
        let submit = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
        // SAFETY: the frame is recorded, and all that it uses lives until its fence is signalled.
        unsafe {
            device.end_command_buffer(slot.commands)?;
            device.reset_fences(&[slot.done])?;
            device.queue_submit2(self.gpu.queue, &submit, slot.done)?;
        }
        self.slots[(frame % u64::from(FRAMES_IN_FLIGHT)) as usize].is_timed = is_timed;
        Ok(())
    }

    /// Waits for the frame, or the one before it that used the same slot.
    pub fn wait(&self, frame: u64) -> Result<()> {
        // SAFETY: the fence is of this device.
        Ok(unsafe { self.gpu.device.wait_for_fences(&[self.slot(frame).done], true, u64::MAX) }?)
    }

    /// How long each step of the frame that last used this slot took, nanoseconds; none without timestamps.
    pub fn times(&self, frame: u64) -> Result<Option<[f64; 3]>> {
        let slot = self.slot(frame);
        if slot.queries == vk::QueryPool::null() || !slot.is_timed {
            return Ok(None);
        }
        let mut ticks = [0u64; TIMESTAMPS as usize];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: the frame is over and wrote all of them.
        unsafe { self.gpu.device.get_query_pool_results(slot.queries, 0, &mut ticks, flags) }?;
        let ns = |i: usize| ticks[i + 1].saturating_sub(ticks[i]) as f64 * self.gpu.tick_ns;
        Ok(Some([ns(0), ns(1), ns(2)]))
    }
}

impl Drop for Frames {
    fn drop(&mut self) {
        // SAFETY: the device is idle, so nothing uses these; a null handle is ignored.
        unsafe {
            let _ = self.gpu.device.device_wait_idle();
            for slot in self.slots.drain(..) {
                self.gpu.device.destroy_query_pool(slot.queries, None);
                self.gpu.device.destroy_fence(slot.done, None);
                self.gpu.device.destroy_command_pool(slot.pool, None);
            }
        }
    }
}

/// Makes all that comes after wait for all before, and see what it wrote.
pub fn barrier(device: &ash::Device, commands: vk::CommandBuffer) {
    let (all, write) = (vk::PipelineStageFlags2::ALL_COMMANDS, vk::AccessFlags2::MEMORY_WRITE);
    let barriers = [vk::MemoryBarrier2::default()
        .src_stage_mask(all)
        .src_access_mask(write)
        .dst_stage_mask(all)
        .dst_access_mask(write | vk::AccessFlags2::MEMORY_READ)];
    let info = vk::DependencyInfo::default().memory_barriers(&barriers);
    // SAFETY: the commands are being recorded, outside a render.
    unsafe { device.cmd_pipeline_barrier2(commands, &info) };
}
