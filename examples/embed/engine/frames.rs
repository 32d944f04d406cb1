//! Two frames in flight: while the device works on one, the host records the next.

use super::device::Kept;
use super::{Gpu, Result};
use ash::vk;

pub const FRAMES_IN_FLIGHT: u32 = 2;

/// Timestamps of a frame: before and after each of its steps.
const TIMESTAMPS: u32 = 4;

/// What a frame needs for itself until the device is done with it.
struct Slot {
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    done: vk::Fence,
    /// Null without timestamps.
    queries: vk::QueryPool,
    is_timed: bool,
}

impl Slot {
    fn new(gpu: &mut Gpu) -> Result<Self> {
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(gpu.queue_family);
        // Signalled: nothing has to be waited for before the first frame.
        let fence = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
        let queries = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(TIMESTAMPS);
        // SAFETY: each handle is kept at once.
        unsafe {
            let pool = gpu.device.create_command_pool(&pool, None)?;
            gpu.keep(Kept::Commands(pool));
            let commands = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let commands = gpu.device.allocate_command_buffers(&commands)?[0];
            let done = gpu.device.create_fence(&fence, None)?;
            gpu.keep(Kept::Fence(done));
            let mut slot = Self { pool, commands, done, queries: vk::QueryPool::null(), is_timed: false };
            if gpu.tick_ns > 0.0 {
                slot.queries = gpu.device.create_query_pool(&queries, None)?;
                gpu.keep(Kept::Queries(slot.queries));
            }
            Ok(slot)
        }
    }
}

pub struct Frames {
    device: ash::Device,
    queue: vk::Queue,
    tick_ns: f64,
    slots: [Slot; FRAMES_IN_FLIGHT as usize],
}

impl Frames {
    pub fn new(gpu: &mut Gpu) -> Result<Self> {
        let slots = [Slot::new(gpu)?, Slot::new(gpu)?];
        Ok(Self { device: gpu.device.clone(), queue: gpu.queue, tick_ns: gpu.tick_ns, slots })
    }

    fn slot(&self, frame: u64) -> &Slot {
        &self.slots[(frame % u64::from(FRAMES_IN_FLIGHT)) as usize]
    }

    /// Waits until the device is done with the frame before the last one, and begins to record.
    pub fn begin(&mut self, frame: u64) -> Result<vk::CommandBuffer> {
        self.wait(frame)?;
        let (slot, device) = (self.slot(frame), &self.device);
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
            unsafe { self.device.cmd_write_timestamp2(slot.commands, all, slot.queries, index) };
        }
    }

    pub fn submit(&mut self, frame: u64, is_timed: bool) -> Result<()> {
        let (slot, device) = (self.slot(frame), &self.device);
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(slot.commands)];
        let submit = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
        // SAFETY: the frame is recorded, and all that it uses lives until its fence is signalled.
        unsafe {
            device.end_command_buffer(slot.commands)?;
            device.reset_fences(&[slot.done])?;
            device.queue_submit2(self.queue, &submit, slot.done)?;
        }
        self.slots[(frame % u64::from(FRAMES_IN_FLIGHT)) as usize].is_timed = is_timed;
        Ok(())
    }

    /// Waits for the frame, or the one before it that used the same slot.
    pub fn wait(&self, frame: u64) -> Result<()> {
        // SAFETY: the fence is of this device.
        Ok(unsafe { self.device.wait_for_fences(&[self.slot(frame).done], true, u64::MAX) }?)
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
        unsafe { self.device.get_query_pool_results(slot.queries, 0, &mut ticks, flags) }?;
        let ns = |i: usize| ticks[i + 1].saturating_sub(ticks[i]) as f64 * self.tick_ns;
        Ok(Some([ns(0), ns(1), ns(2)]))
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
