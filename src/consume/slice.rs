//! The debug view: visibility at one depth, over the view of a light's map. Source: Fife and Strugar 2013, Debug view.

use crate::Result;
use crate::gpu::{Buffer, Context, Kernel, Memory, push_struct};
use crate::scene::View;
use crate::shaders;
use crate::shaders::set;
use crate::technique::Answer;

push_struct! {
    /// Twin: SlicePush in glsl/consume/slice.comp.
    struct SlicePush {
        light: u32,
        depth: f32,
        width: u32,
        height: u32,
    }
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
    answer: &Answer,
    depth: f32,
    size: [u32; 2],
) -> Result<Vec<f32>> {
    let count = size[0] as usize * size[1] as usize;
    let answers = Buffer::new(context, "slice.answers", count as u64 * 4, Memory::Device)?;
    let views = Buffer::with_data(context, "slice.view", &[*view])?;
    let bindings = set::Slice { view: &views, answers: &answers }.bind(context, "slice")?;
    let shader = shaders::consume::SLICE.of(answer.folder);
    let kernel = Kernel::compute(context, shader, &[&bindings, answer.bindings], answer.constants)?;
    let push = SlicePush { light: light as u32, depth, width: size[0], height: size[1] };
    context.submit(|commands| {
        commands.pass("consume.slice", |pass| {
            pass.dispatch(&kernel, &push, [size[0].div_ceil(8), size[1].div_ceil(8), 1]);
        });
    })?;
    answers.read(count)
}
