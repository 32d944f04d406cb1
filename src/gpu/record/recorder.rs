//! Command buffers for a device's own queue: one per submission being recorded, and spare ones for later submissions.

use crate::Result;
use crate::gpu::device::device_owner::Device;
use crate::gpu::profile::times::Queries;
use crate::gpu::testing::fault;
use crate::gpu::{Context, vk_error};
use ash::vk;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Command buffers with their pool and fence.
pub(in crate::gpu) struct Recorder {
    device: Device,
    pub pool: vk::CommandPool,
    /// The command buffer that passes are recorded into.
    pub buffer: vk::CommandBuffer,
    /// The command buffer for work pending at submission, which runs before the passes.
    pub before: vk::CommandBuffer,
    pub fence: vk::Fence,
    pub queries: Queries,
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // SAFETY: the owner has waited for the submission; null handles are ignored.
        unsafe {
            self.device.destroy_fence(self.fence, None);
            self.device.destroy_command_pool(self.pool, None);
        }
    }
}

impl Recorder {
    fn new(device: &Device, queue_family: u32) -> Result<Self> {
        let fail = |r| vk_error("create", "the command recorder", r);
        let mut recorder = Self {
            device: device.clone(),
            pool: vk::CommandPool::null(),
            buffer: vk::CommandBuffer::null(),
            before: vk::CommandBuffer::null(),
            fence: vk::Fence::null(),
            queries: Queries::new(device).map_err(fail)?,
        };
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(queue_family);
        // SAFETY: the device was opened with this queue family.
        recorder.pool = fault::creation(|| unsafe { device.create_command_pool(&info, None) }).map_err(fail)?;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(recorder.pool).command_buffer_count(2);
        // SAFETY: the pool was just created.
        let buffers = fault::creation(|| unsafe { device.allocate_command_buffers(&info) }).map_err(fail)?;
        [recorder.buffer, recorder.before] = [0, 1].map(|i| buffers.get(i).copied().unwrap_or_default());
        // SAFETY: the info is complete.
        recorder.fence =
            fault::creation(|| unsafe { device.create_fence(&vk::FenceCreateInfo::default(), None) }).map_err(fail)?;
        Ok(recorder)
    }
}

/// The recorders of a queue. No lock is held while recording, so a thread that is recording can submit other work in
/// the meantime.
pub(in crate::gpu) struct Recorders {
    waiting: Mutex<Vec<Arc<Recorder>>>,
    queue: Mutex<()>,
}

impl Recorders {
    /// Creates the first recorder, so that opening a device fails if it cannot create one.
    pub fn new(device: &Device, queue_family: u32) -> Result<Self> {
        let first = Arc::new(Recorder::new(device, queue_family)?);
        Ok(Self { waiting: Mutex::new(vec![first]), queue: Mutex::default() })
    }

    /// Locks the queue for one submission, from handing over its commands until they are done.
    pub fn queue(&self) -> MutexGuard<'_, ()> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns a spare recorder, or a new one.
    pub fn take(&self, context: &Context) -> Result<Taken<'_>> {
        let waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let recorder = match waiting {
            Some(recorder) => recorder,
            None => Arc::new(Recorder::new(context.device(), context.shared().queue_family)?),
        };
        Ok(Taken { recorders: self, recorder })
    }
}

/// A recorder in use, until its commands are done.
pub(in crate::gpu) struct Taken<'a> {
    recorders: &'a Recorders,
    pub recorder: Arc<Recorder>,
}

impl Drop for Taken<'_> {
    fn drop(&mut self) {
        self.recorders.waiting.lock().unwrap_or_else(PoisonError::into_inner).push(self.recorder.clone());
    }
}
