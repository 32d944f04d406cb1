//! Work counters of passes: one pipeline statistics query per pass.

use crate::gpu::Commands;
use crate::gpu::device::device_owner::Device;
use crate::gpu::profile::MAX_PASSES;
use crate::gpu::testing::fault;
use ash::prelude::VkResult;
use ash::vk;

/// A pass's work, as counted by the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(serde::Serialize, serde::Deserialize))]
pub struct PassCounts {
    /// Number of vertices that the draws consumed.
    pub vertices: u64,
    /// Number of triangles, lines, points or patches that the draws consumed.
    pub primitives: u64,
    /// Number of fragment shader invocations. Devices may count more than the fragments drawn: whole quads or tiles.
    pub fragments: u64,
    /// Number of compute shader invocations: the threads of all workgroups.
    pub threads: u64,
}

impl PassCounts {
    /// Converts the results of a query, which come in the order of Vulkan's flag bits.
    fn of([vertices, primitives, fragments, threads]: [u64; 4]) -> Self {
        Self { vertices, primitives, fragments, threads }
    }

    /// Returns the sum of both counts.
    pub fn plus(self, other: Self) -> Self {
        Self {
            vertices: self.vertices + other.vertices,
            primitives: self.primitives + other.primitives,
            fragments: self.fragments + other.fragments,
            threads: self.threads + other.threads,
        }
    }
}

/// Creates a pool with one query per pass.
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

/// Reads the counts of the first `passes` passes, which must have finished.
pub(in crate::gpu) fn read(device: &Device, pool: vk::QueryPool, passes: usize) -> VkResult<Vec<PassCounts>> {
    let mut counts = vec![[0u64; 4]; passes];
    let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
    // SAFETY: all of these queries were recorded, and each has four results.
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
            // SAFETY: the query was begun before this pass, and the pass's renders have ended.
            unsafe { self.device().cmd_end_query(self.buffer, self.counts, pass) };
        }
    }
}
