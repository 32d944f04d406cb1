//! Recording and running commands: one call a pass writes the barrier, the label and the two timestamps.

use super::kernel::PUSH_BYTES;
use super::recorder::Taken;
use super::{Buffer, Context, Image, Kernel, Push, fault, vk_error};
use crate::{Error, Result};
use ash::vk;
use std::any::Any;
use std::ffi::CString;
use std::sync::atomic::Ordering;

/// Passes in one submission, at most: two timestamps each.
pub(super) const MAX_PASSES: u32 = 512;

/// The name of all passes of a submission that are timed together.
const ALL_PASSES: &str = "all passes";

/// What Vulkan takes in one vkCmdUpdateBuffer.
pub const MAX_UPDATE_BYTES: usize = 65536;

/// When a pass ran.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// The pass's label.
    pub name: String,
    /// Device time since the first pass of the submission began, nanoseconds.
    pub start_ns: f64,
    /// Likewise.
    pub end_ns: f64,
}

/// A submission being recorded.
pub struct Commands<'a> {
    pub(super) context: &'a Context,
    pub(super) buffer: vk::CommandBuffer,
    queries: vk::QueryPool,
    names: Vec<String>,
    /// Not all passes together.
    times_passes: bool,
    /// Whatever a recorded command uses, kept alive until the device is done.
    pub(super) used: Vec<Box<dyn Any>>,
    /// Copied behind the last pass.
    read_backs: Vec<(Buffer, Buffer)>,
}

/// Data on their way to a buffer.
pub struct Staged {
    from: Buffer,
    to: Buffer,
    bytes: u64,
}

/// A pass being recorded.
pub struct Pass<'c, 'a> {
    pub(super) commands: &'c mut Commands<'a>,
}

impl Context {
    /// Records and runs commands, waits for them, and returns the time of each pass, or of all as one
    /// ([`Context::time_passes`]); none where the device has no timestamps. One submission runs at a time. What is submitted
    /// while another is recorded runs before it.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the device is lost, or more than 512 passes are recorded.
    pub fn submit(&self, record: impl FnOnce(&mut Commands)) -> Result<Vec<PassTime>> {
        self.try_submit(|commands| {
            record(commands);
            Ok(())
        })
    }

    /// As [`Context::submit`], but nothing runs where recording fails.
    ///
    /// # Errors
    /// That of `record`, else as [`Context::submit`].
    pub fn try_submit(&self, record: impl FnOnce(&mut Commands) -> Result<()>) -> Result<Vec<PassTime>> {
        let device = self.device();
        let fail = |r| {
            self.note_lost(r);
            vk_error("run", "a submission", r)
        };
        if self.is_lost() {
            return Err(fail(vk::Result::ERROR_DEVICE_LOST));
        }
        let taken = Taken::of(self)?;
        let recorder = &taken.recorder;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: whoever had the recorder waited for its submission, so the pool's only buffer is idle.
        unsafe {
            device.reset_command_pool(recorder.pool, vk::CommandPoolResetFlags::empty()).map_err(fail)?;
            device.begin_command_buffer(recorder.buffer, &begin).map_err(fail)?;
            if recorder.queries != vk::QueryPool::null() {
                device.cmd_reset_query_pool(recorder.buffer, recorder.queries, 0, 2 * MAX_PASSES);
            }
        }
        let mut commands = Commands {
            context: self,
            buffer: recorder.buffer,
            queries: recorder.queries,
            names: Vec::new(),
            times_passes: self.shared().times_passes.load(Ordering::Relaxed),
            used: Vec::new(),
            read_backs: Vec::new(),
        };
        record(&mut commands)?;
        commands.end_passes();
        commands.copy_read_backs();
        commands.barrier(vk::PipelineStageFlags2::HOST, vk::AccessFlags2::HOST_READ);
        let Commands { mut names, times_passes, used, .. } = commands;
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(recorder.buffer)];
        let submit = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
        // One submission after the other, so that they are not in each other's time.
        let queue = self.shared().recorders.queue();
        // SAFETY: everything recorded is kept in `used` until the fence is signalled; the queue is nobody else's meanwhile.
        let waited = unsafe {
            device.end_command_buffer(recorder.buffer).map_err(fail)?;
            device.reset_fences(&[recorder.fence]).map_err(fail)?;
            fault::submission(|| device.queue_submit2(self.shared().queue, &submit, recorder.fence)).map_err(fail)?;
            fault::wait(|| device.wait_for_fences(&[recorder.fence], true, u64::MAX))
        };
        if waited.is_err() {
            // The host may be out of memory while the device runs on with what it was given.
            // SAFETY: the queue is the context's own, and nobody else submits now.
            let _ = unsafe { device.device_wait_idle() };
        }
        drop(queue);
        drop(used);
        waited.map_err(fail)?;
        if names.len() > MAX_PASSES as usize {
            return Err(Error::Gpu {
                operation: "time",
                name: "a submission".into(),
                cause: format!("{} passes, and at most {MAX_PASSES} are timed", names.len()),
                way_out: "report this as a bug".into(),
            });
        }
        if names.is_empty() || recorder.queries == vk::QueryPool::null() {
            return Ok(Vec::new());
        }
        if !times_passes {
            names = vec![ALL_PASSES.into()];
        }
        let mut ticks = vec![0u64; 2 * names.len()];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: all of these queries were written by the submission that just ended.
        unsafe { device.get_query_pool_results(recorder.queries, 0, &mut ticks, flags) }.map_err(fail)?;
        let features = self.features();
        let mask = u64::MAX >> (64 - features.timestamp_valid_bits.clamp(1, 64));
        let first = ticks[0];
        // Differences modulo the valid bits: a counter may wrap within a submission.
        let ns = |tick: u64| (tick.wrapping_sub(first) & mask) as f64 * f64::from(features.timestamp_period_ns);
        Ok(names
            .into_iter()
            .zip(ticks.chunks_exact(2))
            .map(|(name, t)| PassTime { name, start_ns: ns(t[0]), end_ns: ns(t[1]) })
            .collect())
    }
}

impl<'a> Commands<'a> {
    /// Records a pass: waits for all that came before, labels, and times what `record` adds.
    pub fn pass(&mut self, name: &str, record: impl FnOnce(&mut Pass<'_, 'a>)) {
        self.barrier(
            vk::PipelineStageFlags2::ALL_COMMANDS,
            vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE,
        );
        let index = self.names.len() as u32;
        self.names.push(name.into());
        if let (Some(labels), Ok(text)) = (&self.context.shared().labels, CString::new(name)) {
            let label = vk::DebugUtilsLabelEXT::default().label_name(&text);
            // SAFETY: the command buffer is being recorded.
            unsafe { labels.cmd_begin_debug_utils_label(self.buffer, &label) };
        }
        if self.times_passes || index == 0 {
            self.timestamp(2 * index);
        }
        self.settle();
        record(&mut Pass { commands: self });
        self.settle();
        if self.times_passes {
            self.timestamp(2 * index + 1);
        }
        if let Some(labels) = &self.context.shared().labels {
            // SAFETY: as above; the label was begun above.
            unsafe { labels.cmd_end_debug_utils_label(self.buffer) };
        }
    }

    /// Behind the last pass, where all are timed together.
    fn end_passes(&self) {
        if !self.times_passes && !self.names.is_empty() {
            self.timestamp(1);
        }
    }

    /// Lays `data` out for a pass that copies it to the start of `to`; nothing where there are no data.
    ///
    /// # Errors
    /// [`Error::Gpu`] where memory runs out.
    pub fn stage<T: bytemuck::Pod>(&self, to: &Buffer, data: &[T]) -> Result<Option<Staged>> {
        let bytes = size_of_val(data) as u64;
        if bytes == 0 {
            return Ok(None);
        }
        let from = Buffer::new(self.context, "staging", bytes, super::Memory::Upload)?;
        from.write(data)?;
        Ok(Some(Staged { from, to: to.clone(), bytes }))
    }

    /// Copies `from` to `to`, which the host reads, behind the last pass: in nobody's time.
    pub fn read_back(&mut self, from: &Buffer, to: &Buffer) {
        self.read_backs.push((from.clone(), to.clone()));
    }

    fn copy_read_backs(&mut self) {
        let read_backs = std::mem::take(&mut self.read_backs);
        if !read_backs.is_empty() {
            self.barrier(
                vk::PipelineStageFlags2::COPY,
                vk::AccessFlags2::TRANSFER_READ | vk::AccessFlags2::TRANSFER_WRITE,
            );
        }
        for (from, to) in read_backs {
            let bytes = from.bytes().min(to.bytes());
            Pass { commands: self }.copy(&from, &to, bytes);
        }
    }

    pub(super) fn device(&self) -> &'a ash::Device {
        self.context.device()
    }

    /// Software drivers only. lavapipe 22.3 writes both timestamps of a dispatch when it next flushes, after the work;
    /// a barrier makes it flush. On GPUs the timestamps need no help, and the barriers would cost time.
    fn settle(&self) {
        if self.context.features().is_software() {
            self.barrier(
                vk::PipelineStageFlags2::ALL_COMMANDS,
                vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE,
            );
        }
    }

    fn timestamp(&self, query: u32) {
        if self.queries != vk::QueryPool::null() && query < 2 * MAX_PASSES {
            let stage = vk::PipelineStageFlags2::ALL_COMMANDS;
            // SAFETY: the command buffer is being recorded and the query was reset at its start.
            unsafe { self.device().cmd_write_timestamp2(self.buffer, stage, self.queries, query) };
        }
    }

    fn barrier(&self, stage: vk::PipelineStageFlags2, access: vk::AccessFlags2) {
        let barriers = [vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(stage)
            .dst_access_mask(access)];
        let info = vk::DependencyInfo::default().memory_barriers(&barriers);
        // SAFETY: the command buffer is being recorded, outside a render.
        unsafe { self.device().cmd_pipeline_barrier2(self.buffer, &info) };
    }

    /// Brings a new image into the layout it keeps.
    pub(super) fn make_general(&mut self, image: &Image) {
        let range = vk::ImageSubresourceRange::default().aspect_mask(image.aspect()).level_count(1).layer_count(1);
        let barriers = [vk::ImageMemoryBarrier2::default()
            .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
            .new_layout(vk::ImageLayout::GENERAL)
            .image(image.handle())
            .subresource_range(range)];
        let info = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: the command buffer is being recorded; the image is new.
        unsafe { self.device().cmd_pipeline_barrier2(self.buffer, &info) };
        self.used.push(Box::new(image.clone()));
    }
}

impl<'a> Pass<'_, 'a> {
    /// Runs a compute shader over `groups` workgroups.
    pub fn dispatch<P: Push>(&mut self, kernel: &Kernel<P>, push: &P, groups: [u32; 3]) {
        self.bind(kernel, push);
        let buffer = self.commands.buffer;
        // SAFETY: kernel and sets are bound and kept alive.
        unsafe { self.commands.device().cmd_dispatch(buffer, groups[0], groups[1], groups[2]) };
    }

    /// Runs a compute shader over the workgroups that the VkDispatchIndirectCommand at `offset` of `groups` says.
    pub fn dispatch_indirect<P: Push>(&mut self, kernel: &Kernel<P>, push: &P, groups: &Buffer, offset: u64) {
        self.bind(kernel, push);
        let buffer = self.commands.buffer;
        // SAFETY: kernel and sets are bound; the buffer is kept alive and allows indirect dispatches.
        unsafe { self.commands.device().cmd_dispatch_indirect(buffer, groups.handle(), offset) };
        self.commands.used.push(Box::new(groups.clone()));
    }

    /// Writes `data`, as far as there is room, to the start of `buffer`; it travels in the commands themselves.
    pub fn update<T: bytemuck::Pod>(&mut self, buffer: &Buffer, data: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let bytes = &bytes[..bytes.len().min(buffer.bytes() as usize)];
        let mut offset = 0;
        for part in bytes.chunks(MAX_UPDATE_BYTES) {
            let commands = self.commands.buffer;
            // SAFETY: the buffer is kept alive, allows copies and is as large; all data and parts are whole words.
            unsafe { self.commands.device().cmd_update_buffer(commands, buffer.handle(), offset, part) };
            offset += part.len() as u64;
        }
        self.commands.used.push(Box::new(buffer.clone()));
    }

    /// Sets every 32-bit word of `buffer`.
    pub fn fill(&mut self, buffer: &Buffer, value: u32) {
        let commands = self.commands.buffer;
        // SAFETY: the buffer is kept alive and allows copies.
        unsafe { self.commands.device().cmd_fill_buffer(commands, buffer.handle(), 0, vk::WHOLE_SIZE, value) };
        self.commands.used.push(Box::new(buffer.clone()));
    }

    /// Sets the 32-bit words of `bytes` of a buffer from byte `offset` on; both multiples of 4.
    pub fn fill_part(&mut self, buffer: &Buffer, offset: u64, bytes: u64, value: u32) {
        let bytes = bytes.min(buffer.bytes().saturating_sub(offset));
        if bytes > 0 {
            let commands = self.commands.buffer;
            // SAFETY: the buffer is kept alive, allows copies and is as large; the caller gives whole words.
            unsafe { self.commands.device().cmd_fill_buffer(commands, buffer.handle(), offset, bytes, value) };
            self.commands.used.push(Box::new(buffer.clone()));
        }
    }

    /// Sets every texel of an image of unsigned integers.
    pub fn clear_image(&mut self, image: &Image, value: u32) {
        self.clear_color(image, vk::ClearColorValue { uint32: [value; 4] });
    }

    /// Sets every channel of every texel of an image of numbers.
    pub fn clear_volume(&mut self, image: &Image, value: f32) {
        self.clear_color(image, vk::ClearColorValue { float32: [value; 4] });
    }

    fn clear_color(&mut self, image: &Image, color: vk::ClearColorValue) {
        let commands = self.commands.buffer;
        let ranges = [vk::ImageSubresourceRange::default().aspect_mask(image.aspect()).level_count(1).layer_count(1)];
        let general = vk::ImageLayout::GENERAL;
        // SAFETY: the image is kept alive, in GENERAL, and allows copies.
        unsafe { self.commands.device().cmd_clear_color_image(commands, image.handle(), general, &color, &ranges) };
        self.commands.used.push(Box::new(image.clone()));
    }

    /// Copies what was staged.
    pub fn copy_staged(&mut self, staged: &Staged) {
        self.copy(&staged.from, &staged.to, staged.bytes);
    }

    /// Copies the first `bytes`.
    pub fn copy(&mut self, from: &Buffer, to: &Buffer, bytes: u64) {
        self.copy_from(from, 0, to, bytes);
    }

    /// Copies `bytes` from byte `offset` of `from` on to the start of `to`, as far as both have them.
    pub(super) fn copy_from(&mut self, from: &Buffer, offset: u64, to: &Buffer, bytes: u64) {
        let bytes = bytes.min(from.bytes().saturating_sub(offset)).min(to.bytes());
        let regions = [vk::BufferCopy::default().src_offset(offset).size(bytes)];
        let commands = self.commands.buffer;
        // SAFETY: both buffers are kept alive and are as large as the region.
        unsafe { self.commands.device().cmd_copy_buffer(commands, from.handle(), to.handle(), &regions) };
        self.commands.used.push(Box::new(from.clone()));
        self.commands.used.push(Box::new(to.clone()));
    }

    /// Copies all texels, row by row; `to` must have room.
    pub(super) fn copy_image(&mut self, from: &Image, to: &Buffer) {
        let size = from.size();
        let regions = [vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers::default().aspect_mask(from.aspect()).layer_count(1))
            .image_extent(vk::Extent3D { width: size[0], height: size[1], depth: from.depth() })];
        let commands = self.commands.buffer;
        let general = vk::ImageLayout::GENERAL;
        // SAFETY: both are kept alive; the caller made the buffer as large as the image.
        unsafe {
            self.commands.device().cmd_copy_image_to_buffer(commands, from.handle(), general, to.handle(), &regions);
        }
        self.commands.used.push(Box::new(from.clone()));
        self.commands.used.push(Box::new(to.clone()));
    }

    pub(super) fn bind<P: Push>(&mut self, kernel: &Kernel<P>, push: &P) {
        let kernel = kernel.inner();
        let sets: Vec<_> = kernel.sets.iter().map(|s| s.set()).collect();
        let buffer = self.commands.buffer;
        let device = self.commands.device();
        let push = bytemuck::bytes_of(push);
        let push = &push[..push.len().min(PUSH_BYTES as usize)];
        // SAFETY: kernel and sets are kept alive; the sets' layouts are those that the kernel was made with.
        unsafe {
            device.cmd_bind_pipeline(buffer, kernel.bind_point, kernel.pipeline.handle);
            if !sets.is_empty() {
                device.cmd_bind_descriptor_sets(buffer, kernel.bind_point, kernel.pipeline.layout, 0, &sets, &[]);
            }
            if !push.is_empty() {
                device.cmd_push_constants(buffer, kernel.pipeline.layout, vk::ShaderStageFlags::ALL, 0, push);
            }
        }
        self.commands.used.push(Box::new(kernel.clone()));
    }
}

/// So many workgroups as x and y of a dispatch that every device takes, or a few more. A shader numbers its workgroups
/// row after row.
pub fn groups(count: u64) -> [u32; 2] {
    const MOST: u64 = 65535;
    let rows = count.div_ceil(MOST).max(1);
    [count.div_ceil(rows) as u32, rows as u32]
}
