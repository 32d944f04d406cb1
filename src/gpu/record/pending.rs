//! Work waiting to be recorded: layout transitions of new images, and copies of data that the host has written. It is recorded before the
//! commands that use these images and buffers.

use crate::gpu::device::device_owner::Device;
use crate::gpu::resource::KeepAlive;
use crate::gpu::{Buffer, Image};
use ash::vk;
use std::sync::{Mutex, PoisonError};

/// A piece of pending work.
pub(in crate::gpu) enum Step {
    /// Transition of a new image to the layout that it keeps.
    Layout(Image),
    /// Copy of data that the host wrote to `from`, to the start of `to`.
    Copy { from: Buffer, to: Buffer, bytes: u64 },
    /// Zero fill of a new buffer.
    Zero(Buffer),
}

impl Step {
    /// Returns the resources that the step uses.
    pub fn kept(&self) -> impl Iterator<Item = KeepAlive> {
        match self {
            Self::Layout(image) => [Some(image.kept()), None],
            Self::Copy { from, to, .. } => [Some(from.kept()), Some(to.kept())],
            Self::Zero(buffer) => [Some(buffer.kept()), None],
        }
        .into_iter()
        .flatten()
    }

    /// Returns the buffer that the step writes.
    fn written(&self) -> Option<vk::Buffer> {
        match self {
            Self::Layout(_) => None,
            Self::Copy { to: buffer, .. } | Self::Zero(buffer) => Some(buffer.handle()),
        }
    }
}

/// All pending steps of a context, in the order in which they were requested.
#[derive(Default)]
pub(in crate::gpu) struct Pending(Mutex<Vec<Step>>);

impl Pending {
    pub fn push(&self, step: Step) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(step);
    }

    /// Removes all steps and returns them for recording.
    pub fn take(&self) -> Vec<Step> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Puts back steps that were taken but did not run, ahead of later ones.
    pub fn put_back(&self, mut steps: Vec<Step>) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        steps.append(&mut all);
        *all = steps;
    }
}

/// Records `steps` after all earlier commands. Later commands need a barrier. Without steps, nothing is recorded.
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
                // SAFETY: the command buffer is being recorded, outside a render; both buffers are large enough and
                // kept alive.
                unsafe { device.cmd_copy_buffer(buffer, from.handle(), to.handle(), &regions) };
            }
            Step::Zero(zeroed) => {
                // SAFETY: as above; the buffer allows copies.
                unsafe { device.cmd_fill_buffer(buffer, zeroed.handle(), 0, vk::WHOLE_SIZE, 0) };
            }
        }
    }
}

/// Transitions new images to the layout that they keep.
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
        // SAFETY: the command buffer is being recorded, outside a render; the images are new, and kept alive.
        unsafe { device.cmd_pipeline_barrier2(buffer, &info) };
    }
}

/// Records a barrier that makes all earlier writes visible to `access` in `stage`.
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
