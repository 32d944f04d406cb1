//! How fast a device copies: the floor under every build that writes as much.

use super::Timing;
use crate::Result;
use crate::gpu::{Bindings, Buffer, Context, Memory, Pipeline, Resource, shader};

/// Copied at once: past any cache.
const BYTES: u64 = 256 << 20;
const BYTES_ON_CPU: u64 = 64 << 20;

const COPIES: usize = 12;

/// Workgroups: four 16-byte words a thread at 256 MiB.
const GROUPS: u32 = 16384;

/// Bytes a second that the device copies from one buffer to another: the median of ten copies, each of whose bytes is read
/// and written. None where it has no timestamps.
///
/// # Errors
/// [`crate::Error::Gpu`] where memory runs out.
pub fn copy_bytes_per_second(context: &Context) -> Result<Option<f64>> {
    let bytes = if context.features().kind == "cpu" { BYTES_ON_CPU } else { BYTES };
    let from = Buffer::new(context, "copy.from", bytes, Memory::Device)?;
    let to = Buffer::new(context, "copy.to", bytes, Memory::Device)?;
    // By a shader: on the H200 that is faster than the driver's own copy.
    let bindings = Bindings::new(context, "copy", &[Resource::Buffer(from.clone()), Resource::Buffer(to.clone())])?;
    let pipeline = Pipeline::compute(context, shader("measure/copy.comp")?, &[&bindings], &[])?;
    let mut samples = Vec::new();
    context.submit(|commands| commands.pass("copy.fill", |pass| pass.fill(&from, 1)))?;
    for copy in 0..COPIES {
        let passes = context.submit(|commands| {
            commands.pass("measure.copy", |pass| pass.dispatch(&pipeline, &[&bindings], &[], [GROUPS, 1, 1]));
        })?;
        // The first two touch the memory.
        if copy > 1 {
            samples.extend(passes.first().map(|pass| pass.end_ns - pass.start_ns));
        }
    }
    Ok(Timing::of(&samples).map(|time| bytes as f64 * 1e9 / time.median))
}
