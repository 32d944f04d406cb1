//! Start and end times of passes: two timestamps per pass.

use crate::gpu::device::device_owner::Device;
use crate::gpu::profile::{MAX_PASSES, counts};
use crate::gpu::testing::fault;
use crate::gpu::{Features, PassCounts};
use ash::prelude::VkResult;
use ash::vk;
use std::sync::OnceLock;

/// Name of the single entry when all passes of a submission are timed together.
pub(in crate::gpu) const ALL_PASSES: &str = "all passes";

/// Start and end of a pass.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// The pass's label.
    pub name: String,
    /// Start in device time, in nanoseconds since the first pass of the submission, or of the first of several submissions.
    pub start_ns: f64,
    /// End, on the same scale.
    pub end_ns: f64,
    /// Whether the pass drew anything: it began a render. If passes are timed together, whether any of them did.
    pub raster: bool,
    /// The device's clock at the start of the pass, in ticks ([`crate::gpu::Calibration`]).
    pub began: u64,
    /// The pass's counts, if requested ([`crate::gpu::Context::count_passes`]).
    pub counts: Option<PassCounts>,
}

/// The timed passes of a recording.
#[derive(Default)]
pub(in crate::gpu) struct TimedPasses {
    /// Names of the passes, one per line.
    pub names: String,
    /// One bit per pass: whether it began a render.
    renders: [u64; MAX_PASSES as usize / 64],
}

impl TimedPasses {
    /// Creates an empty list with a capacity of `bytes` bytes for names.
    pub fn with_room(bytes: usize) -> Self {
        Self { names: String::with_capacity(bytes), ..Self::default() }
    }

    /// Records that this pass begins a render.
    pub fn renders(&mut self, pass: u32) {
        if let Some(word) = self.renders.get_mut(pass as usize / 64) {
            *word |= 1 << (pass % 64);
        }
    }

    fn is_raster(&self, pass: usize) -> bool {
        self.renders.get(pass / 64).is_some_and(|word| word >> (pass % 64) & 1 == 1)
    }
}

/// Appends the passes of a submission, shifted in time as if the device had continued without a break.
pub fn follow(passes: &mut Vec<PassTime>, next: Vec<PassTime>) {
    let end_ns = passes.last().map_or(0.0, |pass| pass.end_ns);
    let moved = |pass: PassTime| PassTime { start_ns: pass.start_ns + end_ns, end_ns: pass.end_ns + end_ns, ..pass };
    passes.extend(next.into_iter().map(moved));
}

/// Timestamp queries of a recording; the handle is null if the queue has no timestamps.
pub(in crate::gpu) struct Queries {
    device: Device,
    pub handle: vk::QueryPool,
    /// The queries that count the passes' work, created when first requested.
    counts: OnceLock<vk::QueryPool>,
}

impl Drop for Queries {
    fn drop(&mut self) {
        let counts = self.counts.get().copied().unwrap_or_default();
        // SAFETY: the owner drops this only after the recorded commands have finished; null handles are ignored.
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
            // SAFETY: the command buffer is being recorded, outside a render; no running work uses the pool.
            unsafe { self.device.cmd_reset_query_pool(buffer, self.handle, 0, 2 * MAX_PASSES) };
        }
    }

    /// Returns the queries that count the passes' work, reset in `buffer`; null if the device cannot count.
    pub fn counts(&self, buffer: vk::CommandBuffer) -> VkResult<vk::QueryPool> {
        if !self.device.features().pipeline_statistics_query || self.handle == vk::QueryPool::null() {
            return Ok(vk::QueryPool::null());
        }
        let pool = match self.counts.get() {
            Some(pool) => *pool,
            // Only the recording that holds these queries gets here, so nothing else creates the pool meanwhile.
            None => {
                let pool = counts::pool(&self.device)?;
                *self.counts.get_or_init(|| pool)
            }
        };
        // SAFETY: the command buffer is being recorded, outside a render; no running work uses the pool.
        unsafe { self.device.cmd_reset_query_pool(buffer, pool, 0, MAX_PASSES) };
        Ok(pool)
    }

    /// Reads the times of finished passes, and their counts if `counts` is not null.
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

/// Converts ticks to times, two ticks per name.
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
