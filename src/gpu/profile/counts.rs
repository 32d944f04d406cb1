//! Counts of a pass's work: one query of pipeline statistics per pass.

use crate::gpu::Commands;
use crate::gpu::device::device_owner::Device;
use crate::gpu::profile::times::MAX_PASSES;
use crate::gpu::testing::fault;
use ash::prelude::VkResult;
use ash::vk;

/// A pass's work, as the device counted it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(serde::Serialize, serde::Deserialize))]
pub struct PassCounts {
    /// Vertices that draws took.
    pub vertices: u64,
    /// Triangles, lines, points or patches that draws took.
    pub primitives: u64,
    /// How often fragment shaders ran. Devices may count more than the fragments that are drawn: those of whole quads or tiles.
    pub fragments: u64,
    /// How often compute shaders ran: the threads of all workgroups.
    pub threads: u64,
}

impl PassCounts {
    /// Counts from a query's numbers, which are in the order of Vulkan's flag bits.
    fn of([vertices, primitives, fragments, threads]: [u64; 4]) -> Self {
        Self { vertices, primitives, fragments, threads }
    }

    /// The sum of both.
    pub fn plus(self, other: Self) -> Self {
        Self {
            vertices: self.vertices + other.vertices,
            primitives: self.primitives + other.primitives,
            fragments: self.fragments + other.fragments,
            threads: self.threads + other.threads,
        }
    }
}

/// A pool of queries, one per pass.
pub(in crate::gpu) fn pool(device: &Device) -> VkResult<vk::QueryPool> {
    let counted = vk::QueryPipelineStatisticFlags::INPUT_ASSEMBLY_VERTICES
        | vk::QueryPipelineStatisticFlags::INPUT_ASSEMBLY_PRIMITIVES
        | vk::QueryPipelineStatisticFlags::FRAGMENT_SHADER_INVOCATIONS
        | vk::QueryPipelineStatisticFlags::COMPUTE_SHADER_INVOCATIONS;
    let info = vk::QueryPoolCreateInfo::default()
        .query_type(vk::QueryType::PIPELINE_STATISTICS)
        .query_count(MAX_PASSES)
        .pipeline_statistics(counted);
    // SAFETY: the info is complete, and the device was opened with pipelineStatisticsQuery.
    fault::creation(|| unsafe { device.create_query_pool(&info, None) })
}

/// Counts of the first `passes` passes, which are over.
pub(in crate::gpu) fn read(device: &Device, pool: vk::QueryPool, passes: usize) -> VkResult<Vec<PassCounts>> {
    let mut counts = vec![[0u64; 4]; passes];
    let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
    // SAFETY: all of these queries were recorded, and have four numbers each.
    unsafe { device.get_query_pool_results(pool, 0, &mut counts, flags) }?;
    Ok(counts.into_iter().map(PassCounts::of).collect())
}

impl Commands<'_> {
    pub(in crate::gpu) fn begin_counts(&self, pass: u32) {
        if self.counts != vk::QueryPool::null() && pass < MAX_PASSES {
            let flags = vk::QueryControlFlags::empty();
            // SAFETY: the command buffer is being recorded, outside a render; the query was reset at its start.
            unsafe { self.device().cmd_begin_query(self.buffer, self.counts, pass, flags) };
        }
    }

    pub(in crate::gpu) fn end_counts(&self, pass: u32) {
        if self.counts != vk::QueryPool::null() && pass < MAX_PASSES {
            // SAFETY: it was begun before this pass, and renders of the pass are over.
            unsafe { self.device().cmd_end_query(self.buffer, self.counts, pass) };
        }
    }
}
