//! When passes ran: two timestamps per pass.

use crate::gpu::device::device_owner::Device;
use crate::gpu::profile::counts;
use crate::gpu::testing::fault;
use crate::gpu::{Features, PassCounts};
use ash::prelude::VkResult;
use ash::vk;
use std::sync::OnceLock;

/// Passes in one submission that are timed, at most: two timestamps each.
pub(in crate::gpu) const MAX_PASSES: u32 = 512;

/// The name of all passes of a submission that are timed together.
pub(in crate::gpu) const ALL_PASSES: &str = "all passes";

/// When a pass ran.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// The pass's label.
    pub name: String,
    /// Device time since the first pass of the submission began, or of the first of several submissions, nanoseconds.
    pub start_ns: f64,
    /// Likewise.
    pub end_ns: f64,
    /// Whether it drew anything: it began a render. Where passes are timed together, whether any of them did.
    pub raster: bool,
    /// The device's clock at its beginning, ticks ([`crate::gpu::Calibration`]).
    pub began: u64,
    /// Its counts, where they were asked for ([`crate::gpu::Context::count_passes`]).
    pub counts: Option<PassCounts>,
}

/// The timed passes of a recording.
#[derive(Default)]
pub(in crate::gpu) struct TimedPasses {
    /// Their names, one per line.
    pub names: String,
    /// A bit per pass: whether it began a render.
    renders: [u64; MAX_PASSES as usize / 64],
}

impl TimedPasses {
    /// No pass, and room for this many bytes of names.
    pub fn with_room(bytes: usize) -> Self {
        Self { names: String::with_capacity(bytes), ..Self::default() }
    }

    /// Notes that a pass begins a render.
    pub fn renders(&mut self, pass: u32) {
        if let Some(word) = self.renders.get_mut(pass as usize / 64) {
            *word |= 1 << (pass % 64);
        }
    }

    fn is_raster(&self, pass: usize) -> bool {
        self.renders.get(pass / 64).is_some_and(|word| word >> (pass % 64) & 1 == 1)
    }
}

/// Puts the passes of a submission behind those before it, as if the device had gone on without a break.
pub fn follow(passes: &mut Vec<PassTime>, next: Vec<PassTime>) {
    let end_ns = passes.last().map_or(0.0, |pass| pass.end_ns);
    let moved = |pass: PassTime| PassTime { start_ns: pass.start_ns + end_ns, end_ns: pass.end_ns + end_ns, ..pass };
    passes.extend(next.into_iter().map(moved));
}

/// The timestamps of a recording; a null handle where the queue has none.
pub(in crate::gpu) struct Queries {
    device: Device,
    pub handle: vk::QueryPool,
    /// The queries that count passes' work, once asked for.
    counts: OnceLock<vk::QueryPool>,
}

impl Drop for Queries {
    fn drop(&mut self) {
        let counts = self.counts.get().copied().unwrap_or_default();
        // SAFETY: their recorder knows that it is over; null handles are ignored.
        unsafe {
            self.device.destroy_query_pool(self.handle, None);
            self.device.destroy_query_pool(counts, None);
        }
    }
}

impl Queries {
    pub fn new(device: &Device) -> VkResult<Self> {
        let mut queries = Self { device: device.clone(), handle: vk::QueryPool::null(), counts: OnceLock::new() };
        if device.features().timestamp_valid_bits > 0 {
            let info =
                vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2 * MAX_PASSES);
            // SAFETY: the info is complete and the queue has timestamps.
            queries.handle = fault::creation(|| unsafe { device.create_query_pool(&info, None) })?;
        }
        Ok(queries)
    }

    pub fn reset(&self, buffer: vk::CommandBuffer) {
        if self.handle != vk::QueryPool::null() {
            // SAFETY: the command buffer is being recorded, outside a render; nothing that runs uses the pool.
            unsafe { self.device.cmd_reset_query_pool(buffer, self.handle, 0, 2 * MAX_PASSES) };
        }
    }

    /// The queries that count passes' work, reset in `buffer`; null on a device that cannot count.
    pub fn counts(&self, buffer: vk::CommandBuffer) -> VkResult<vk::QueryPool> {
        if !self.device.features().pipeline_statistics_query || self.handle == vk::QueryPool::null() {
            return Ok(vk::QueryPool::null());
        }
        let pool = match self.counts.get() {
            Some(pool) => *pool,
            // Only the recording that holds these queries comes here, so nothing else makes the pool meanwhile.
            None => {
                let pool = counts::pool(&self.device)?;
                *self.counts.get_or_init(|| pool)
            }
        };
        // SAFETY: the command buffer is being recorded, outside a render; nothing that runs uses the pool.
        unsafe { self.device.cmd_reset_query_pool(buffer, pool, 0, MAX_PASSES) };
        Ok(pool)
    }

    /// The times of passes that are over. With `counts`, their counts too.
    pub fn read(
        &self,
        passes: &TimedPasses,
        counts: vk::QueryPool,
        flags: vk::QueryResultFlags,
    ) -> VkResult<Vec<PassTime>> {
        let names: Vec<_> = passes.names.lines().take(MAX_PASSES as usize).collect();
        if names.is_empty() || self.handle == vk::QueryPool::null() {
            return Ok(Vec::new());
        }
        let mut ticks = vec![0u64; 2 * names.len()];
        let flags = vk::QueryResultFlags::TYPE_64 | flags;
        // SAFETY: all of these queries were recorded.
        unsafe { self.device.get_query_pool_results(self.handle, 0, &mut ticks, flags) }?;
        let mut times = times(self.device.features(), &names, &ticks);
        times.iter_mut().enumerate().for_each(|(pass, time)| time.raster = passes.is_raster(pass));
        if counts != vk::QueryPool::null() {
            let counts = counts::read(&self.device, counts, names.len())?;
            times.iter_mut().zip(counts).for_each(|(time, counts)| time.counts = Some(counts));
        }
        Ok(times)
    }
}

/// Times from ticks, two per name.
fn times(features: &Features, names: &[&str], ticks: &[u64]) -> Vec<PassTime> {
    let mask = u64::MAX >> (64 - features.timestamp_valid_bits.clamp(1, 64));
    let first = ticks.first().copied().unwrap_or_default();
    // Differences modulo the valid bits: a counter may wrap within a submission.
    let ns = |tick: u64| (tick.wrapping_sub(first) & mask) as f64 * f64::from(features.timestamp_period_ns);
    let time = |(name, t): (&&str, &[u64])| PassTime {
        name: (*name).into(),
        start_ns: ns(t[0]),
        end_ns: ns(t[1]),
        raster: false,
        began: t[0],
        counts: None,
    };
    names.iter().zip(ticks.chunks_exact(2)).map(time).collect()
}
