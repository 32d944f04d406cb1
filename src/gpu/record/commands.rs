//! Recording commands: one call per pass records the barrier, the label and the two timestamps.

use crate::Result;
use crate::gpu::profile::MAX_PASSES;
use crate::gpu::profile::times::TimedPasses;
use crate::gpu::record::pending::Step;
use crate::gpu::resource::KeepAlive;
use crate::gpu::resource::kernel::PUSH_BYTES;
use crate::gpu::{Bindings, Buffer, Context, Image, Kernel, Push, ReadBack};
use ash::vk;
use std::ffi::CString;
use std::sync::atomic::Ordering;

/// Maximum number of bytes in one vkCmdUpdateBuffer.
pub const MAX_UPDATE_BYTES: usize = 65536;

/// Capacity in bytes for pass names, enough for all passes of most builds.
const NAMES_BYTES: usize = 512;

/// The owner of the command buffer being recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::gpu) enum Owner {
    /// The context, which submits the command buffer. Pending steps ([`crate::gpu::record::pending`]) run before it.
    Own,
    /// The caller. Pending steps are recorded into the caller's command buffer, before the next pass.
    Caller,
}

/// Passes being recorded, either into the caller's command buffer ([`Commands::on`]) or for the queue of a device that
/// was opened here ([`Context::submit`]).
pub struct Commands<'a> {
    pub(in crate::gpu) context: &'a Context,
    pub(in crate::gpu) buffer: vk::CommandBuffer,
    whose: Owner,
    frame: u64,
    queries: vk::QueryPool,
    /// Query pool that counts the passes' work; null unless requested.
    pub(in crate::gpu) counts: vk::QueryPool,
    passes: u32,
    timed: TimedPasses,
    /// Whether each pass is timed, rather than all passes together.
    times_passes: bool,
    /// Resources used by recorded commands, kept alive until the device is done.
    used: Vec<KeepAlive>,
    /// Copies to record after the last pass.
    read_backs: Vec<(Buffer, ReadBack)>,
}

/// The result of a recording.
pub(in crate::gpu) struct Recorded {
    pub used: Vec<KeepAlive>,
    pub passes: u32,
    pub timed: TimedPasses,
}

/// Data staged for a copy to a buffer.
pub struct Staged {
    from: Buffer,
    to: Buffer,
    /// Offset in `to`, in bytes.
    at: u64,
    bytes: u64,
}

/// A pass being recorded.
pub struct Pass<'c, 'a> {
    pub(in crate::gpu) commands: &'c mut Commands<'a>,
}

impl<'a> Commands<'a> {
    /// Starts recording into a command buffer that has been begun, and in which `queries` were reset. `used` must be
    /// empty; its capacity is reused.
    pub(in crate::gpu) fn new(
        context: &'a Context,
        buffer: vk::CommandBuffer,
        (whose, frame): (Owner, u64),
        queries: vk::QueryPool,
        used: Vec<KeepAlive>,
    ) -> Self {
        let times_passes = context.shared().times_passes.load(Ordering::Relaxed);
        let (timed, read_backs) = (TimedPasses::with_room(NAMES_BYTES), Vec::new());
        let counts = vk::QueryPool::null();
        Self { context, buffer, whose, frame, queries, counts, passes: 0, timed, times_passes, used, read_backs }
    }

    /// Returns the number of the frame being recorded: the one given to [`Commands::on`], or the submission's.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// Records a pass: waits for all earlier commands, then records the commands that `record` adds, with a label and
    /// timestamps.
    pub fn pass(&mut self, name: &str, record: impl FnOnce(&mut Pass<'_, 'a>)) {
        self.record_pending();
        self.barrier(
            vk::PipelineStageFlags2::ALL_COMMANDS,
            vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE,
        );
        let index = self.passes;
        self.passes += 1;
        if self.queries != vk::QueryPool::null() && (self.times_passes || index == 0) {
            self.timed.names.push_str(if self.times_passes { name } else { crate::gpu::profile::times::ALL_PASSES });
            self.timed.names.push('\n');
            self.timestamp(2 * index);
        }
        let label = self.begin_label(name);
        self.settle();
        self.begin_counts(index);
        record(&mut Pass { commands: self });
        self.end_counts(index);
        self.settle();
        if self.times_passes {
            self.timestamp(2 * index + 1);
        }
        if let (true, Some(labels)) = (label, self.context.device().labels()) {
            // SAFETY: the command buffer is being recorded; the label was begun above.
            unsafe { labels.cmd_end_debug_utils_label(self.buffer) };
        }
    }

    /// Begins a label, and returns whether it did.
    fn begin_label(&self, name: &str) -> bool {
        let (Some(labels), Ok(text)) = (self.context.device().labels(), CString::new(name)) else { return false };
        let label = vk::DebugUtilsLabelEXT::default().label_name(&text);
        // SAFETY: the command buffer is being recorded.
        unsafe { labels.cmd_begin_debug_utils_label(self.buffer, &label) };
        true
    }

    /// Records everything that follows the last pass: the end of passes that are timed together, copies to read back,
    /// and a barrier that makes all of it visible to later commands.
    pub(in crate::gpu) fn finish(&mut self) -> Recorded {
        self.record_pending();
        if !self.times_passes && self.passes > 0 {
            self.timestamp(1);
        }
        self.copy_read_backs();
        let everybody = vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE;
        match self.whose {
            Owner::Own => self.barrier(vk::PipelineStageFlags2::HOST, vk::AccessFlags2::HOST_READ),
            Owner::Caller => self.barrier(
                vk::PipelineStageFlags2::ALL_COMMANDS | vk::PipelineStageFlags2::HOST,
                everybody | vk::AccessFlags2::HOST_READ,
            ),
        }
        let (used, timed) = (std::mem::take(&mut self.used), std::mem::take(&mut self.timed));
        Recorded { used, timed, passes: self.passes }
    }

    /// Stages `data` for a pass that copies it to the start of `to`; `None` if `data` is empty.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn stage<T: bytemuck::Pod>(&self, to: &Buffer, data: &[T]) -> Result<Option<Staged>> {
        self.stage_at(to, 0, data)
    }

    /// Stages `data` for a copy to byte `at` of `to`. Data beyond the end of `to` is not copied.
    ///
    /// # Errors
    /// Same as [`Commands::stage`].
    pub fn stage_at<T: bytemuck::Pod>(&self, to: &Buffer, at: u64, data: &[T]) -> Result<Option<Staged>> {
        let bytes = size_of_val(data) as u64;
        if bytes == 0 {
            return Ok(None);
        }
        let from = Buffer::new(self.context, "staging", bytes, crate::gpu::Memory::Upload)?;
        from.write(data)?;
        Ok(Some(Staged { from, to: to.clone(), at, bytes }))
    }

    /// Copies `from` to `to`, which the host reads, after the last pass, so that no pass's time includes the copy. If
    /// several passes request it, it is copied once.
    pub fn read_back(&mut self, from: &Buffer, to: &ReadBack) {
        if !self.read_backs.iter().any(|(_, other)| other.is(to)) {
            self.read_backs.push((from.clone(), to.clone()));
        }
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
            let to = to.begin(self.frame);
            let bytes = from.bytes().min(to.bytes());
            Pass { commands: self }.copy(&from, &to, bytes);
        }
    }

    /// Records pending layouts of new images and pending writes into the caller's command buffer.
    fn record_pending(&mut self) {
        if self.whose == Owner::Caller {
            let steps = self.context.shared().pending.take();
            crate::gpu::record::pending::record(self.context.device(), self.buffer, &steps);
            self.used.extend(steps.iter().flat_map(Step::kept));
        }
    }

    /// Records that the current pass begins a render.
    pub(in crate::gpu) fn note_render(&mut self) {
        self.timed.renders(if self.times_passes { self.passes.saturating_sub(1) } else { 0 });
    }

    /// Keeps a resource of a recorded command alive.
    pub(in crate::gpu) fn keep(&mut self, thing: KeepAlive) {
        self.used.push(thing);
    }

    pub(in crate::gpu) fn device(&self) -> &'a ash::Device {
        self.context.device()
    }

    /// Makes timestamps correct on lavapipe 22.3, which writes both timestamps of a dispatch at its next flush, after
    /// the work; a barrier makes it flush. GPUs do not need this, and the barriers would cost time.
    fn settle(&self) {
        if self.queries != vk::QueryPool::null() && self.context.features().is_software() {
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
        crate::gpu::record::pending::barrier(self.context.device(), self.buffer, stage, access);
    }
}

impl Drop for Commands<'_> {
    fn drop(&mut self) {
        if self.whose == Owner::Caller {
            let recorded = self.finish();
            self.context.shared().frames.keep(self.frame, self.queries, recorded);
        }
    }
}

impl<'a> Pass<'_, 'a> {
    /// Waits for all earlier commands, as between two passes. Orders draws within one pass.
    pub fn barrier(&mut self) {
        let access = vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE;
        self.commands.barrier(vk::PipelineStageFlags2::ALL_COMMANDS, access);
    }

    /// Runs a compute shader over `groups` workgroups.
    pub fn dispatch<P: Push>(&mut self, kernel: &Kernel<P>, push: &P, groups: [u32; 3]) {
        self.bind(kernel, push);
        let buffer = self.commands.buffer;
        // SAFETY: kernel and sets are bound and kept alive.
        unsafe { self.commands.device().cmd_dispatch(buffer, groups[0], groups[1], groups[2]) };
    }

    /// Runs a compute shader over the workgroups given by the VkDispatchIndirectCommand at `offset` in `groups`.
    pub fn dispatch_indirect<P: Push>(&mut self, kernel: &Kernel<P>, push: &P, groups: &Buffer, offset: u64) {
        self.bind(kernel, push);
        let buffer = self.commands.buffer;
        // SAFETY: kernel and sets are bound; the buffer is kept alive and allows indirect dispatches.
        unsafe { self.commands.device().cmd_dispatch_indirect(buffer, groups.handle(), offset) };
        self.commands.keep(groups.kept());
    }

    /// Writes as much of `data` as fits to the start of `buffer`. The data becomes part of the command buffer.
    pub fn update<T: bytemuck::Pod>(&mut self, buffer: &Buffer, data: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let bytes = &bytes[..bytes.len().min(buffer.bytes() as usize)];
        let mut offset = 0;
        for part in bytes.chunks(MAX_UPDATE_BYTES) {
            let commands = self.commands.buffer;
            // SAFETY: the buffer is kept alive, allows copies and is large enough; the data and each part are whole words.
            unsafe { self.commands.device().cmd_update_buffer(commands, buffer.handle(), offset, part) };
            offset += part.len() as u64;
        }
        self.commands.keep(buffer.kept());
    }

    /// Sets every 32-bit word of `buffer` to `value`.
    pub fn fill(&mut self, buffer: &Buffer, value: u32) {
        let commands = self.commands.buffer;
        // SAFETY: the buffer is kept alive and allows copies.
        unsafe { self.commands.device().cmd_fill_buffer(commands, buffer.handle(), 0, vk::WHOLE_SIZE, value) };
        self.commands.keep(buffer.kept());
    }

    /// Sets the 32-bit words in `bytes` bytes from byte `offset` on to `value`. Both must be multiples of 4.
    pub fn fill_part(&mut self, buffer: &Buffer, offset: u64, bytes: u64, value: u32) {
        let bytes = bytes.min(buffer.bytes().saturating_sub(offset));
        if bytes > 0 {
            let commands = self.commands.buffer;
            // SAFETY: the buffer is kept alive, allows copies and is large enough; the caller passes whole words.
            unsafe { self.commands.device().cmd_fill_buffer(commands, buffer.handle(), offset, bytes, value) };
            self.commands.keep(buffer.kept());
        }
    }

    /// Sets every texel of an image of unsigned integers to `value`.
    pub fn clear_image(&mut self, image: &Image, value: u32) {
        self.clear_color(image, vk::ClearColorValue { uint32: [value; 4] });
    }

    /// Sets every channel of every texel of an image of floats to `value`.
    pub fn clear_volume(&mut self, image: &Image, value: f32) {
        self.clear_color(image, vk::ClearColorValue { float32: [value; 4] });
    }

    fn clear_color(&mut self, image: &Image, color: vk::ClearColorValue) {
        let commands = self.commands.buffer;
        let ranges = [vk::ImageSubresourceRange::default().aspect_mask(image.aspect()).level_count(1).layer_count(1)];
        let general = vk::ImageLayout::GENERAL;
        // SAFETY: the image is kept alive, is in GENERAL, and allows copies.
        unsafe { self.commands.device().cmd_clear_color_image(commands, image.handle(), general, &color, &ranges) };
        self.commands.keep(image.kept());
    }

    /// Copies staged data.
    pub fn copy_staged(&mut self, staged: &Staged) {
        self.copy_part((&staged.from, 0), (&staged.to, staged.at), staged.bytes);
    }

    /// Copies the first `bytes` bytes of `from` to the start of `to`.
    pub fn copy(&mut self, from: &Buffer, to: &Buffer, bytes: u64) {
        self.copy_from(from, 0, to, bytes);
    }

    /// Copies `bytes` bytes from byte `offset` of `from` to the start of `to`, clamped to the size of both.
    pub(in crate::gpu) fn copy_from(&mut self, from: &Buffer, offset: u64, to: &Buffer, bytes: u64) {
        self.copy_part((from, offset), (to, 0), bytes);
    }

    /// Copies `bytes` bytes from byte `first` of `from` to byte `at` of `to`, clamped to the size of both.
    fn copy_part(&mut self, (from, first): (&Buffer, u64), (to, at): (&Buffer, u64), bytes: u64) {
        let bytes = bytes.min(from.bytes().saturating_sub(first)).min(to.bytes().saturating_sub(at));
        if bytes == 0 {
            return;
        }
        let regions = [vk::BufferCopy::default().src_offset(first).dst_offset(at).size(bytes)];
        let commands = self.commands.buffer;
        // SAFETY: both buffers are kept alive and contain the region.
        unsafe { self.commands.device().cmd_copy_buffer(commands, from.handle(), to.handle(), &regions) };
        self.commands.keep(from.kept());
        self.commands.keep(to.kept());
    }

    /// Copies all texels, row by row, to the start of `to`; copies nothing if `to` is too small.
    pub fn copy_image(&mut self, from: &Image, to: &Buffer) {
        if to.bytes() < from.bytes() {
            return;
        }
        let size = from.size();
        let regions = [vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers::default().aspect_mask(from.aspect()).layer_count(1))
            .image_extent(vk::Extent3D { width: size[0], height: size[1], depth: from.depth() })];
        let commands = self.commands.buffer;
        let general = vk::ImageLayout::GENERAL;
        // SAFETY: both are kept alive, and the buffer is large enough.
        unsafe {
            self.commands.device().cmd_copy_image_to_buffer(commands, from.handle(), general, to.handle(), &regions);
        }
        self.commands.keep(from.kept());
        self.commands.keep(to.kept());
    }

    pub(in crate::gpu) fn bind<P: Push>(&mut self, kernel: &Kernel<P>, push: &P) {
        let kernel = kernel.inner();
        let sets: Vec<_> = kernel.sets.iter().map(Bindings::current).collect();
        let handles: Vec<_> = sets.iter().map(|set| set.handle).collect();
        let buffer = self.commands.buffer;
        let device = self.commands.device();
        let push = bytemuck::bytes_of(push);
        let push = &push[..push.len().min(PUSH_BYTES as usize)];
        // SAFETY: kernel and sets are kept alive; the kernel was created with the sets' layouts.
        unsafe {
            device.cmd_bind_pipeline(buffer, kernel.bind_point, kernel.pipeline.handle);
            if !handles.is_empty() {
                device.cmd_bind_descriptor_sets(buffer, kernel.bind_point, kernel.pipeline.layout, 0, &handles, &[]);
            }
            if !push.is_empty() {
                device.cmd_push_constants(buffer, kernel.pipeline.layout, vk::ShaderStageFlags::ALL, 0, push);
            }
        }
        self.commands.used.extend(sets.into_iter().map(|set| set as KeepAlive));
        self.commands.keep(kernel.clone());
    }
}

/// Returns x and y of a dispatch of `count` workgroups, or slightly more, within the limits of every device. A shader
/// numbers its workgroups row by row.
pub fn groups(count: u64) -> [u32; 2] {
    const MOST: u64 = 65535;
    let rows = count.div_ceil(MOST).max(1);
    [count.div_ceil(rows) as u32, rows as u32]
}
