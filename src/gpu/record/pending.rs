//! Work that waits to be recorded: layouts of new images, and copies of data that the host has written. This work is recorded before the
//! commands that use these images and buffers.

use crate::gpu::device::device_owner::Device;
use crate::gpu::record::commands::KeepAlive;
use crate::gpu::{Buffer, Image};
use ash::vk;
use std::sync::{Mutex, PoisonError};

/// A piece of pending work.
pub(in crate::gpu) enum Step {
    /// A new image takes on the layout that it keeps.
    Layout(Image),
    /// Data that the host has written into `from` go to the start of `to`.
    Copy { from: Buffer, to: Buffer, bytes: u64 },
    /// All of a new buffer is 0.
    Zero(Buffer),
}

impl Step {
    /// The resources that it uses.
    pub fn kept(&self) -> impl Iterator<Item = KeepAlive> {
        match self {
            Self::Layout(image) => [Some(image.kept()), None],
            Self::Copy { from, to, .. } => [Some(from.kept()), Some(to.kept())],
            Self::Zero(buffer) => [Some(buffer.kept()), None],
        }
        .into_iter()
        .flatten()
    }

    /// The buffer that it writes.
    fn written(&self) -> Option<vk::Buffer> {
        match self {
            Self::Layout(_) => None,
            Self::Copy { to: buffer, .. } | Self::Zero(buffer) => Some(buffer.handle()),
        }
    }
}

/// All pending steps of a context, in the order in which they were asked for.
#[derive(Default)]
pub(in crate::gpu) struct Pending(Mutex<Vec<Step>>);

impl Pending {
    pub fn push(&self, step: Step) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(step);
    }

    /// Takes all steps out, to be recorded.
    pub fn take(&self) -> Vec<Step> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Puts back work that was taken and did not run, before later work.
    pub fn put_back(&self, mut steps: Vec<Step>) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        steps.append(&mut all);
        *all = steps;
    }
}

/// Records `steps` behind all earlier commands. Later commands need a barrier. Without steps nothing is recorded.
pub(in crate::gpu) fn record(device: &Device, buffer: vk::CommandBuffer, steps: &[Step]) {
    if steps.is_empty() {
        return;
    }
    let transfers = || barrier(device, buffer, vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::TRANSFER_WRITE);
    transfers();
    make_general(device, buffer, steps);
    let mut written = Vec::new();
    for step in steps {
        if let Some(handle) = step.written() {
            if written.contains(&handle) {
                transfers();
                written.clear();
            }
            written.push(handle);
        }
        match step {
            Step::Layout(_) => {}
            Step::Copy { from, to, bytes } => {
                let regions = [vk::BufferCopy::default().size(*bytes)];
                // SAFETY: the command buffer is being recorded, outside a render; both buffers are as large, and kept.
                unsafe { device.cmd_copy_buffer(buffer, from.handle(), to.handle(), &regions) };
            }
            Step::Zero(zeroed) => {
                // SAFETY: as above; the buffer allows copies.
                unsafe { device.cmd_fill_buffer(buffer, zeroed.handle(), 0, vk::WHOLE_SIZE, 0) };
            }
        }
    }
}

/// Brings new images into the layout they keep.
fn make_general(device: &Device, buffer: vk::CommandBuffer, steps: &[Step]) {
    let to_general = |step: &Step| {
        let Step::Layout(image) = step else { return None };
        let range = vk::ImageSubresourceRange::default().aspect_mask(image.aspect()).level_count(1).layer_count(1);
        let barrier = vk::ImageMemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
            .new_layout(vk::ImageLayout::GENERAL)
            .image(image.handle())
            .subresource_range(range);
        Some(barrier)
    };
    let barriers: Vec<_> = steps.iter().filter_map(to_general).collect();
    if !barriers.is_empty() {
        let info = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: the command buffer is being recorded, outside a render; the images are new, and kept.
        unsafe { device.cmd_pipeline_barrier2(buffer, &info) };
    }
}

/// A barrier that makes all earlier writes visible to `access` in `stage`.
pub(in crate::gpu) fn barrier(
    device: &Device,
    buffer: vk::CommandBuffer,
    stage: vk::PipelineStageFlags2,
    access: vk::AccessFlags2,
) {
    let barriers = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(stage)
        .dst_access_mask(access)];
    let info = vk::DependencyInfo::default().memory_barriers(&barriers);
    // SAFETY: the command buffer is being recorded, outside a render.
    unsafe { device.cmd_pipeline_barrier2(buffer, &info) };
}
