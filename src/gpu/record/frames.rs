//! The caller's frames. Some still run while the next is recorded, so the resources of those frames are kept alive until they finish.

use crate::gpu::profile::times::{PassTime, Queries, TimedPasses};
use crate::gpu::record::commands::{Owner, Recorded};
use crate::gpu::resource::KeepAlive;
use crate::gpu::{Commands, Context, vk_error};
use crate::{Error, Result};
use ash::vk;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The frames of a context.
pub(in crate::gpu) struct Frames {
    in_flight: u64,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// Frames that may still be running on the device.
    running: Vec<Frame>,
    /// The newest `in_flight` finished frames, kept so that their times can be read.
    over: Vec<Frame>,
    /// Queries that no frame uses.
    queries: Vec<Queries>,
}

struct Frame {
    number: u64,
    used: Vec<KeepAlive>,
    /// Queries and passes of each recording.
    timed: Vec<(Queries, TimedPasses)>,
}

impl Frame {
    /// Returns the times of the frame's passes; empty if the frame has not finished.
    fn times(&self) -> Vec<PassTime> {
        let read = |(queries, passes): &(Queries, TimedPasses)| {
            queries.read(passes, vk::QueryPool::null(), vk::QueryResultFlags::empty()).unwrap_or_default()
        };
        self.timed.iter().flat_map(read).collect()
    }
}

impl Frames {
    pub fn new(in_flight: u32) -> Self {
        Self { in_flight: in_flight.into(), state: Mutex::default() }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins or continues frame `number`. Frame `number - in_flight` and all earlier ones have finished. Returns the resources that were
    /// kept alive for those frames; the caller may reuse the list itself.
    fn begin(&self, number: u64) -> Result<Vec<KeepAlive>> {
        let mut state = self.state();
        if let Some(last) = state.running.last().filter(|last| last.number > number) {
            return Err(Error::Gpu {
                operation: "record",
                name: format!("frame {number}"),
                cause: format!("frame {} was recorded before it", last.number).into(),
                way_out: "number frames in the order in which they are recorded".into(),
            });
        }
        let mut kept = Vec::new();
        let is_over = |frame: &&Frame| frame.number.saturating_add(self.in_flight) <= number;
        while state.running.first().filter(is_over).is_some() {
            let mut frame = state.running.remove(0);
            if kept.is_empty() {
                std::mem::swap(&mut kept, &mut frame.used);
            }
            kept.append(&mut frame.used);
            state.over.push(frame);
        }
        while state.over.len() > self.in_flight as usize {
            let old = state.over.remove(0);
            state.queries.extend(old.timed.into_iter().map(|(queries, _)| queries));
        }
        if state.running.last().is_none_or(|last| last.number < number) {
            state.running.push(Frame { number, used: Vec::new(), timed: Vec::new() });
        }
        Ok(kept)
    }

    /// Returns the queries for a recording of the newest frame. [`Frames::keep`] sets its passes.
    fn time(&self, context: &Context) -> Result<vk::QueryPool> {
        let unused = self.state().queries.pop();
        let queries = match unused {
            Some(queries) => queries,
            None => Queries::new(context.device()).map_err(|r| vk_error("create", "timestamps", r))?,
        };
        let handle = queries.handle;
        if let Some(frame) = self.state().running.last_mut() {
            frame.timed.push((queries, TimedPasses::default()));
        }
        Ok(handle)
    }

    /// Keeps the resources of recorded commands alive until the frame has finished.
    pub(in crate::gpu) fn keep(&self, number: u64, queries: vk::QueryPool, recorded: Recorded) {
        let mut state = self.state();
        if let Some(frame) = state.running.iter_mut().find(|frame| frame.number == number) {
            if frame.used.is_empty() {
                frame.used = recorded.used;
            } else {
                frame.used.extend(recorded.used);
            }
            if let Some((_, passes)) = frame.timed.iter_mut().find(|(timed, _)| timed.handle == queries) {
                *passes = recorded.timed;
            }
        }
    }

    /// Keeps a dropped resource alive until the newest frame, which may still use it, has finished.
    pub(in crate::gpu) fn retire(&self, thing: KeepAlive) {
        if let Some(frame) = self.state().running.last_mut() {
            frame.used.push(thing);
        }
    }

    fn times(&self, number: u64) -> Vec<PassTime> {
        let state = self.state();
        let frame = state.running.iter().chain(&state.over).find(|frame| frame.number == number);
        frame.map(Frame::times).unwrap_or_default()
    }
}

impl<'a> Commands<'a> {
    /// Records into the caller's command buffer, on an adopted device. Nothing is submitted or waited for. Later
    /// commands in that command buffer, and in command buffers submitted after it, see everything recorded before these
    /// [`Commands`] are dropped.
    ///
    /// `frame` numbers the caller's frames and must not decrease; a frame may be recorded in several parts. By the time frame `f` is
    /// recorded, frame `f - frames_in_flight` has finished, and resources that only it used are freed here.
    ///
    /// # Errors
    /// [`Error::Gpu`] if a later frame was recorded before, or if memory runs out; [`Error::Refused`] on a device that
    /// was opened here.
    ///
    /// # Safety
    /// The command buffer must belong to the adopted device and its queue family, be in the recording state outside a render, and be
    /// submitted once, to a queue of that family, in the order in which frames and their parts were recorded, before frame `frame` counts
    /// as finished. Nothing else may record into it while these [`Commands`] live. Frame `frame - frames_in_flight` must have finished.
    pub unsafe fn on(context: &'a Context, buffer: vk::CommandBuffer, frame: u64) -> Result<Self> {
        if context.shared().queue.is_some() {
            return Err(Error::Refused("an adopted device: this one has a queue of its own".into()));
        }
        let frames = &context.shared().frames;
        // The resources are freed here, after the lock on the frames has been released.
        let mut used = frames.begin(frame)?;
        used.clear();
        let mut handle = vk::QueryPool::null();
        if context.features().timestamp_valid_bits > 0 {
            handle = frames.time(context)?;
            // SAFETY: the command buffer is being recorded, outside a render; no running frame uses the pool.
            unsafe { context.device().cmd_reset_query_pool(buffer, handle, 0, 2 * crate::gpu::profile::MAX_PASSES) };
        }
        Ok(Self::new(context, buffer, (Owner::Caller, frame), handle, used))
    }

    /// Ends the recording. Dropping it does the same.
    pub fn end(self) {}
}

impl Context {
    /// Returns the time of each pass of a finished frame, on an adopted device; empty if the device has no timestamps. Times are kept for
    /// the last `frames_in_flight` finished frames.
    pub fn times(&self, frame: u64) -> Vec<PassTime> {
        self.shared().frames.times(frame)
    }
}
