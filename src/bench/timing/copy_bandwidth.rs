//! How fast a device copies memory: a lower bound for every build that writes as much.

use crate::Result;
use crate::bench::Timing;
use crate::gpu::{Buffer, Constants, Context, Kernel, Memory};
use crate::shaders;
use crate::shaders::set;

/// Bytes per copy: more than any cache holds.
const BYTES: u64 = 256 << 20;
const BYTES_ON_CPU: u64 = 64 << 20;

const COPIES: usize = 12;

/// Number of workgroups of 128 threads: four 16-byte words per thread at 256 MiB.
const GROUPS: u32 = 32768;

/// Measures how many bytes per second the device copies from one buffer to another, each byte read and written: the median of ten copies by
/// a shader or by the driver, whichever is faster. `None` if the device has no timestamps.
///
/// # Errors
/// [`crate::Error::Gpu`] if memory runs out.
pub fn copy_bytes_per_second(context: &Context) -> Result<Option<f64>> {
    let features = context.features();
    let most = u64::from(features.max_storage_buffer_range) / 16 * 16;
    let bytes = if features.is_software() { BYTES_ON_CPU } else { BYTES }.min(most);
    let from = Buffer::new(context, "copy.from", bytes, Memory::Device)?;
    let to = Buffer::new(context, "copy.to", bytes, Memory::Device)?;
    let bindings = set::Copy { from: &from, to: &to }.bind(context, "copy")?;
    let kernel: Kernel = Kernel::compute(context, &shaders::bench::COPY, &[&bindings], &Constants::new())?;
    context.submit(|commands| commands.pass("copy.fill", |pass| pass.fill(&from, 1)))?;
    let (mut by_shader, mut by_driver) = (Vec::new(), Vec::new());
    for copy in 0..COPIES {
        let passes = context.submit(|commands| {
            commands.pass("bench.copy", |pass| pass.dispatch(&kernel, &(), [GROUPS, 1, 1]));
            commands.pass("copy.driver", |pass| pass.copy(&from, &to, bytes));
        })?;
        // The first two copies are the first to touch the memory, so they are not counted.
        if let (2.., [shader, driver]) = (copy, &passes[..]) {
            by_shader.push(shader.end_ns - shader.start_ns);
            by_driver.push(driver.end_ns - driver.start_ns);
        }
    }
    let median = |samples: &[f64]| Timing::of(samples).map(|time| time.median);
    let fastest = median(&by_shader).into_iter().chain(median(&by_driver)).reduce(f64::min);
    Ok(fastest.map(|ns| bytes as f64 * 1e9 / ns))
}
