//! Command buffers: one a submission that is being recorded, and those that wait for the next.

use super::commands::MAX_PASSES;
use super::{Context, fault, vk_error};
use crate::{Error, Result};
use ash::vk;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};

/// A command buffer with what it needs. Not an owner of the context, which owns it.
pub(super) struct Recorder {
    device: ash::Device,
    pub pool: vk::CommandPool,
    pub buffer: vk::CommandBuffer,
    pub fence: vk::Fence,
    pub queries: vk::QueryPool,
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // SAFETY: the context waits for the device before it drops this; null handles are ignored.
        unsafe {
            self.device.destroy_query_pool(self.queries, None);
            self.device.destroy_fence(self.fence, None);
            self.device.destroy_command_pool(self.pool, None);
        }
    }
}

impl Recorder {
    fn new(context: &Context) -> Result<Self> {
        let device = context.device().clone();
        let fail = |r| vk_error("create", "the command recorder", r);
        let mut recorder = Self {
            device,
            pool: vk::CommandPool::null(),
            buffer: vk::CommandBuffer::null(),
            fence: vk::Fence::null(),
            queries: vk::QueryPool::null(),
        };
        let device = &recorder.device;
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(context.shared().queue_family);
        // SAFETY: the family is the one the device was opened with.
        recorder.pool = fault::creation(|| unsafe { device.create_command_pool(&info, None) }).map_err(fail)?;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(recorder.pool).command_buffer_count(1);
        // SAFETY: the pool was just made.
        let buffers = fault::creation(|| unsafe { device.allocate_command_buffers(&info) }).map_err(fail)?;
        recorder.buffer = buffers.first().copied().unwrap_or_default();
        // SAFETY: the info is complete.
        recorder.fence =
            fault::creation(|| unsafe { device.create_fence(&vk::FenceCreateInfo::default(), None) }).map_err(fail)?;
        if context.features().timestamp_valid_bits > 0 {
            let info =
                vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2 * MAX_PASSES);
            // SAFETY: the info is complete and the queue has timestamps.
            recorder.queries = fault::creation(|| unsafe { device.create_query_pool(&info, None) }).map_err(fail)?;
        }
        Ok(recorder)
    }
}

/// All recorders of a context. Nobody holds a lock while recording, so that whoever records may submit something else meanwhile,
/// as an image does that is made.
#[derive(Default)]
pub(super) struct Recorders {
    state: Mutex<State>,
    nobody_records: Condvar,
    queue: Mutex<()>,
}

#[derive(Default)]
struct State {
    waiting: Vec<Arc<Recorder>>,
    /// Who records, once for each recording.
    recording: Vec<ThreadId>,
}

impl Recorders {
    /// Makes the first, so that a device which cannot is none.
    pub fn begin(&self, context: &Context) -> Result<()> {
        let first = Arc::new(Recorder::new(context)?);
        self.state().waiting.push(first);
        Ok(())
    }

    /// Destroys those that wait; nothing is recorded any more.
    pub fn end(&self) {
        self.state().waiting.clear();
    }

    /// The queue for one alone, from handing commands over until they are done.
    pub fn queue(&self) -> MutexGuard<'_, ()> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs `change` while nobody records and nothing runs: of what recorded commands may name.
    ///
    /// # Errors
    /// [`Error::Gpu`] where this thread itself records; `name` is what would change.
    pub fn while_idle(&self, name: &str, change: impl FnOnce()) -> Result<()> {
        let me = thread::current().id();
        let mut state = self.state();
        if state.recording.contains(&me) {
            return Err(Error::Gpu {
                operation: "change",
                name: name.into(),
                cause: "commands that may use it are being recorded".into(),
                way_out: "change it before, or in `settle`".into(),
            });
        }
        while !state.recording.is_empty() {
            state = self.nobody_records.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        change();
        Ok(())
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A recorder in use, until its commands are done.
pub(super) struct Taken<'a> {
    recorders: &'a Recorders,
    pub recorder: Arc<Recorder>,
}

impl<'a> Taken<'a> {
    /// One that waits, else a new one.
    pub fn of(context: &'a Context) -> Result<Self> {
        let recorders = &context.shared().recorders;
        let waiting = recorders.state().waiting.pop();
        let recorder = match waiting {
            Some(recorder) => recorder,
            None => Arc::new(Recorder::new(context)?),
        };
        recorders.state().recording.push(thread::current().id());
        Ok(Self { recorders, recorder })
    }
}

impl Drop for Taken<'_> {
    fn drop(&mut self) {
        let me = thread::current().id();
        let mut state = self.recorders.state();
        state.waiting.push(self.recorder.clone());
        if let Some(place) = state.recording.iter().rposition(|thread| *thread == me) {
            state.recording.swap_remove(place);
        }
        if state.recording.is_empty() {
            self.recorders.nobody_records.notify_all();
        }
    }
}
