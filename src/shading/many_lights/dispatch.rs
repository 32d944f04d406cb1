//! Two ways to look up light: each pixel queries all of its lights, or look-ups become jobs in a list that threads share evenly.

use super::{ManyLights, ManyLightsPush, Targets};
use crate::gpu::{Bindings, Buffer, Commands, Constants, Kernel, Memory};
use crate::shaders::set;
use crate::shaders::{constant, many_lights as shaders};
use crate::shading::{DitherKind, ShadowsKind, Tiled};
use crate::technique::Answer;
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};

/// Maximum bytes of jobs: Vulkan guarantees that a storage buffer of this size can be bound.
const MOST_JOBS_BYTES: u64 = 128 << 20;

/// Capacity of the list, in jobs per pixel on average over the picture. Look-ups that do not fit are done immediately, not queued.
const JOBS_A_PIXEL: u64 = 32;

/// Kernels that query one technique.
pub enum Asking {
    /// `shadows=direct`
    Direct(Kernel<ManyLightsPush>),
    /// `shadows=queued`
    Queued {
        /// Appends jobs.
        enqueue: Kernel<ManyLightsPush>,
        /// Looks up the light of each job.
        queued: Kernel<ManyLightsPush>,
    },
}

/// Twin: DITHER in glsl/shading/many_lights/dither.glsl.
fn dither(kind: DitherKind) -> u32 {
    match kind {
        DitherKind::None => 0,
        DitherKind::Ordered => 1,
        DitherKind::Noise => 2,
    }
}

impl Asking {
    pub(super) fn new(tiles: &ManyLights, answer: &Answer) -> Result<Self> {
        let constants = answer.constants.clone().set(constant::DITHER, dither(tiles.tiled.dither));
        let sets = [&tiles.frame, answer.bindings, &tiles.gbuffer];
        let Some(queue) = &tiles.queue else {
            let trace = shaders::TRACE.of(answer.folder);
            return Ok(Self::Direct(Kernel::compute(&tiles.context, trace, &sets, &constants)?));
        };
        let sets = [sets[0], sets[1], sets[2], &queue.bindings];
        Ok(Self::Queued {
            enqueue: Kernel::compute(&tiles.context, shaders::ENQUEUE.of(answer.folder), &sets, &constants)?,
            queued: Kernel::compute(&tiles.context, shaders::QUEUED.of(answer.folder), &sets, &constants)?,
        })
    }

    pub(super) fn record(&self, tiles: &ManyLights, commands: &mut Commands, push: &ManyLightsPush) {
        match (self, &tiles.queue) {
            (Self::Direct(kernel), _) => trace(tiles, commands, kernel, push),
            (Self::Queued { enqueue: append, queued: answer }, Some(queue)) => {
                enqueue(tiles, commands, append, push);
                queue.spread(commands, push);
                queue.queued(commands, answer, push);
            }
            // Unreachable: queued kernels are created only if there is a list.
            (Self::Queued { .. }, None) => {}
        }
    }
}

fn trace(tiles: &ManyLights, commands: &mut Commands, kernel: &Kernel<ManyLightsPush>, push: &ManyLightsPush) {
    commands.pass("many_lights.trace", |pass| pass.dispatch(kernel, push, tiles.blocks()));
}

fn enqueue(tiles: &ManyLights, commands: &mut Commands, kernel: &Kernel<ManyLightsPush>, push: &ManyLightsPush) {
    commands.pass("many_lights.enqueue", |pass| pass.dispatch(kernel, push, tiles.blocks()));
}

/// State of the list of jobs. Twin: Queue in glsl/shading/many_lights/queue.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct QueueData {
    /// Workgroups in x that share the jobs; together with the next two fields, the arguments of an indirect dispatch.
    pub groups_x: u32,
    /// Workgroups in y.
    pub groups_y: u32,
    /// Workgroups in z.
    pub groups_z: u32,
    /// Number of jobs in the list.
    pub jobs: u32,
    /// Number of jobs that pixels have tried to append in this frame so far.
    pub demanded: u32,
    /// Index of the first of these jobs that did not fit; [`u32::MAX`] if all fit.
    pub end: u32,
}

/// The list of jobs; a job is one pixel and one light.
pub(super) struct Queue {
    state: Buffer,
    jobs: Buffer,
    capacity: u32,
    light_bits: u32,
    bindings: Bindings,
    spread: Kernel<ManyLightsPush>,
}

impl Queue {
    /// Creates the list with `shadows=queued`, otherwise `None`. `sets` are descriptor sets 0 to 2; the list's own set is bound after them.
    pub(super) fn of(targets: &Targets, tiled: &Tiled, sets: &[&Bindings; 3]) -> Result<Option<Self>> {
        if tiled.shadows == ShadowsKind::Direct {
            return Ok(None);
        }
        let (context, lights) = (targets.context, targets.light_count.max(1));
        let [width, height] = targets.color.size();
        let light_bits = lights.next_power_of_two().trailing_zeros();
        let pixels = u64::from(width) * u64::from(height);
        if pixels << light_bits >= 1 << 32 {
            let cause = format!(
                "{width} × {height} pixels, and with {lights} lights a job has room for {}",
                1u64 << (32 - light_bits)
            );
            return Err(Error::input("shadows=queued", cause, "use shadows=direct or a smaller picture"));
        }
        let most = MOST_JOBS_BYTES.min(context.features().max_storage_buffer_range.into());
        let bytes = (4 * pixels * u64::from(lights).min(JOBS_A_PIXEL)).min(most / 4 * 4);
        let state = Buffer::with_data(
            context,
            "many_lights.queue",
            &[QueueData { groups_x: 0, groups_y: 0, groups_z: 0, jobs: 0, demanded: 0, end: u32::MAX }],
        )?;
        let jobs = Buffer::new(context, "many_lights.jobs", bytes, Memory::Device)?;
        let bindings = set::ManyLightsQueue { queue: &state, jobs: &jobs }.bind(context, "many_lights.queue")?;
        let sets = [sets[0], sets[1], sets[2], &bindings];
        let spread = Kernel::compute(context, &shaders::SPREAD, &sets, &Constants::new())?;
        Ok(Some(Self { state, jobs, capacity: (bytes / 4) as u32, light_bits, bindings, spread }))
    }

    pub(super) fn bytes(&self) -> u64 {
        self.state.bytes() + self.jobs.bytes()
    }

    /// Returns how many low bits of a job hold its light, and how many jobs fit into the list.
    pub(super) fn push(&self) -> (u32, u32) {
        (self.light_bits, self.capacity)
    }

    fn spread(&self, commands: &mut Commands, push: &ManyLightsPush) {
        commands.pass("many_lights.spread", |pass| pass.dispatch(&self.spread, push, [1, 1, 1]));
    }

    fn queued(&self, commands: &mut Commands, kernel: &Kernel<ManyLightsPush>, push: &ManyLightsPush) {
        commands.pass("many_lights.queued", |pass| pass.dispatch_indirect(kernel, push, &self.state, 0));
    }
}
