//! The debug view of seed 000: visibility at one depth, over the light's view.

use super::built_for;
use crate::Result;
use crate::gpu::{Bindings, Buffer, Context, Memory, Pipeline, Resource};
use crate::technique::{LightData, Visibility};
use bytemuck::{Pod, Zeroable};

/// Twin: Push in glsl/consume/slice.comp.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    depth: f32,
    width: u32,
    height: u32,
}

/// Visibility at `depth` (0 to 1 in the light's range) for each of `size` pixels, rows from the top.
///
/// # Errors
/// [`crate::Error::Gpu`] where memory runs out.
pub fn slice(
    context: &Context,
    light: &LightData,
    visibility: &Visibility,
    depth: f32,
    size: [u32; 2],
) -> Result<Vec<f32>> {
    let count = size[0] as usize * size[1] as usize;
    let answers = Buffer::new(context, "slice.answers", count as u64 * 4, Memory::Device)?;
    let lights = Buffer::with_data(context, "slice.lights", &[*light])?;
    let bindings = Bindings::new(context, "slice", &[Resource::Buffer(lights), Resource::Buffer(answers.clone())])?;
    let sets = [&bindings, visibility.bindings];
    let shader = built_for(visibility, "slice.comp")?;
    let pipeline = Pipeline::compute(context, shader, &sets, visibility.constants)?;
    let push = Push { depth, width: size[0], height: size[1] };
    context.submit(|commands| {
        commands.pass("slice", |pass| {
            let groups = [size[0].div_ceil(8), size[1].div_ceil(8), 1];
            pass.dispatch(&pipeline, &sets, bytemuck::bytes_of(&push), groups);
        });
    })?;
    answers.read(count)
}
