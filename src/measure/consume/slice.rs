//! The debug view of seed 000: visibility at one depth, over the view of a light's map.

use super::built_for;
use crate::Result;
use crate::gpu::{Bindings, Buffer, Context, Memory, Pipeline, Resource};
use crate::scene::View;
use crate::technique::Visibility;
use bytemuck::{Pod, Zeroable};

/// Twin: Push in glsl/consume/slice.comp.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    light: u32,
    depth: f32,
    width: u32,
    height: u32,
}

/// Visibility of `light` at `depth` (0 to 1 in the range of `view`, one of its maps') for each of `size` pixels, rows from
/// the top.
///
/// # Errors
/// [`crate::Error::Gpu`] where memory runs out.
pub fn slice(
    context: &Context,
    light: usize,
    view: &View,
    visibility: &Visibility,
    depth: f32,
    size: [u32; 2],
) -> Result<Vec<f32>> {
    let count = size[0] as usize * size[1] as usize;
    let answers = Buffer::new(context, "slice.answers", count as u64 * 4, Memory::Device)?;
    let views = Buffer::with_data(context, "slice.view", &[*view])?;
    let bindings = Bindings::new(context, "slice", &[Resource::Buffer(views), Resource::Buffer(answers.clone())])?;
    let sets = [&bindings, visibility.bindings];
    let shader = built_for(visibility, "slice.comp")?;
    let pipeline = Pipeline::compute(context, shader, &sets, visibility.constants)?;
    let push = Push { light: light as u32, depth, width: size[0], height: size[1] };
    context.submit(|commands| {
        commands.pass("slice", |pass| {
            let groups = [size[0].div_ceil(8), size[1].div_ceil(8), 1];
            pass.dispatch(&pipeline, &sets, bytemuck::bytes_of(&push), groups);
        });
    })?;
    answers.read(count)
}
