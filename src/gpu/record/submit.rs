//! Submitting commands and waiting for them, on the queue of a device that was opened here.

use crate::gpu::profile::MAX_PASSES;
use crate::gpu::profile::times::PassTime;
use crate::gpu::record::commands::Owner;
use crate::gpu::record::pending;
use crate::gpu::record::pending::Step;
use crate::gpu::record::recorder::{Recorder, Recorders};
use crate::gpu::testing::fault;
use crate::gpu::{Commands, Context, vk_error};
use crate::{Error, Result};
use ash::prelude::VkResult;
use ash::vk;
use std::sync::atomic::Ordering;

impl Context {
    /// Records and runs commands, waits for them, and returns the time of each pass, or of all passes as one
    /// ([`Context::time_passes`]); empty if the device has no timestamps. One submission runs at a time. Work that is
    /// submitted or written while `record` runs is executed before its commands.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost or more than 512 passes are recorded; [`Error::Refused`] on an adopted device.
    pub fn submit(&self, record: impl FnOnce(&mut Commands)) -> Result<Vec<PassTime>> {
        self.try_submit(|commands| {
            record(commands);
            Ok(())
        })
    }

    /// Like [`Context::submit`], but runs nothing if recording fails.
    ///
    /// # Errors
    /// The error of `record`, or any error of [`Context::submit`].
    pub fn try_submit(&self, record: impl FnOnce(&mut Commands) -> Result<()>) -> Result<Vec<PassTime>> {
        let fail = |r| {
            self.note_lost(r);
            vk_error("run", "a submission", r)
        };
        if self.is_lost() {
            return Err(fail(vk::Result::ERROR_DEVICE_LOST));
        }
        let queue = self.queue()?;
        let taken = queue.recorders.take(self)?;
        let recorder = &taken.recorder;
        let device = self.device();
        // SAFETY: the recorder's last submission was waited for, so the pool's buffers are idle.
        unsafe { device.reset_command_pool(recorder.pool, vk::CommandPoolResetFlags::empty()) }.map_err(fail)?;
        self.begin(recorder.buffer).map_err(fail)?;
        recorder.queries.reset(recorder.buffer);
        let frame = self.shared().begun.fetch_add(1, Ordering::Relaxed);
        let mut commands =
            Commands::new(self, recorder.buffer, (Owner::Own, frame), recorder.queries.handle, Vec::new());
        if self.shared().counts_passes.load(Ordering::Relaxed) && self.shared().times_passes.load(Ordering::Relaxed) {
            commands.counts = recorder.queries.counts(recorder.buffer).map_err(fail)?;
        }
        let counts = commands.counts;
        record(&mut commands)?;
        let recorded = commands.finish();
        let ran = self.run(&queue.recorders, queue.handle, recorder);
        drop(recorded.used);
        ran.map_err(fail)?;
        if recorded.passes > MAX_PASSES {
            return Err(Error::Gpu {
                operation: "time",
                name: "a submission".into(),
                cause: format!("{} passes, and at most {MAX_PASSES} are timed", recorded.passes).into(),
                way_out: "report this as a bug".into(),
            });
        }
        recorder.queries.read(&recorded.timed, counts, vk::QueryResultFlags::WAIT).map_err(fail)
    }

    /// Runs one submission at a time, so that submissions do not add to each other's times.
    fn run(&self, recorders: &Recorders, queue: vk::Queue, recorder: &Recorder) -> VkResult<()> {
        let alone = recorders.queue();
        let steps = self.shared().pending.take();
        // SAFETY: all passes have been recorded.
        let ended = unsafe { self.device().end_command_buffer(recorder.buffer) };
        if let Err(error) = ended.and_then(|()| self.hand_over(queue, recorder, &steps)) {
            self.shared().pending.put_back(steps);
            return Err(error);
        }
        // SAFETY: this fence was submitted with these commands.
        let waited = fault::wait(|| unsafe { self.device().wait_for_fences(&[recorder.fence], true, u64::MAX) });
        if waited.is_err() {
            // The host may be out of memory while the device is still running. SAFETY: the queue is the context's own,
            // and nothing else submits now.
            let _ = unsafe { self.device().device_wait_idle() };
        }
        drop(alone);
        waited
    }

    /// Submits pending work, then the passes.
    fn hand_over(&self, queue: vk::Queue, recorder: &Recorder, steps: &[Step]) -> VkResult<()> {
        let device = self.device();
        let buffer = |buffer| vk::CommandBufferSubmitInfo::default().command_buffer(buffer);
        let mut buffers = vec![buffer(recorder.buffer)];
        if !steps.is_empty() {
            self.begin(recorder.before)?;
            pending::record(device, recorder.before, steps);
            let everybody = vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE;
            pending::barrier(device, recorder.before, vk::PipelineStageFlags2::ALL_COMMANDS, everybody);
            // SAFETY: it was begun above.
            unsafe { device.end_command_buffer(recorder.before) }?;
            buffers.insert(0, buffer(recorder.before));
        }
        let submit = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
        // SAFETY: the caller keeps all resources alive until the fence is signalled, and alone uses the queue meanwhile.
        unsafe {
            device.reset_fences(&[recorder.fence])?;
            fault::submission(|| device.queue_submit2(queue, &submit, recorder.fence))
        }
    }

    fn begin(&self, buffer: vk::CommandBuffer) -> VkResult<()> {
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the buffer's pool was reset, and nothing has been recorded since.
        unsafe { self.device().begin_command_buffer(buffer, &begin) }
    }
}
