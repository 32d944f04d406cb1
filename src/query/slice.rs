//! The debug view: visibility at one depth, over the view of a light's map. Source: Fife and Strugar 2013, Debug view.

use crate::Result;
use crate::gpu::{Buffer, Commands, Context, Kernel, Memory, push_struct};
use crate::scene::View;
use crate::shaders;
use crate::shaders::set;
use crate::technique::Answer;

push_struct! {
    /// Twin: SlicePush in glsl/query/slice.comp.
    struct SlicePush {
        light: u32,
        depth: f32,
        width: u32,
        height: u32,
    }
}

/// Queries one technique at one depth, over the view of a light's map.
pub struct Slice {
    answers: Buffer,
    kernel: Kernel<SlicePush>,
    push: SlicePush,
}

impl Slice {
    /// Creates a query of `light`'s visibility at `depth`, for `size` pixels over `view`. `view` belongs to one of the light's maps, and
    /// `depth` runs from 0 to 1 over its range.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(
        context: &Context,
        light: usize,
        view: &View,
        answer: &Answer,
        depth: f32,
        size: [u32; 2],
    ) -> Result<Self> {
        let [width, height] = size;
        let answers = Buffer::new(context, "slice.answers", u64::from(width) * u64::from(height) * 4, Memory::Device)?;
        let views = Buffer::with_data(context, "slice.view", &[*view])?;
        let bindings = set::Slice { view: &views, answers: &answers }.bind(context, "slice")?;
        let shader = shaders::query::SLICE.of(answer.folder);
        let kernel = Kernel::compute(context, shader, &[&bindings, answer.bindings], answer.constants)?;
        Ok(Self { answers, kernel, push: SlicePush { light: light as u32, depth, width, height } })
    }

    /// Records the query's pass.
    pub fn record(&self, commands: &mut Commands) {
        let groups = [self.push.width.div_ceil(8), self.push.height.div_ceil(8), 1];
        commands.pass("query.slice", |pass| pass.dispatch(&self.kernel, &self.push, groups));
    }

    /// Returns the results on the device, one float per pixel, rows from the top.
    pub fn buffer(&self) -> &Buffer {
        &self.answers
    }
}

/// Same as [`Slice::new`], but runs the query at once and returns the results, rows from the top.
///
/// # Errors
/// [`crate::Error::Gpu`] if memory runs out.
pub fn slice(
    context: &Context,
    light: usize,
    view: &View,
    answer: &Answer,
    depth: f32,
    size: [u32; 2],
) -> Result<Vec<f32>> {
    let slice = Slice::new(context, light, view, answer, depth, size)?;
    context.submit(|commands| slice.record(commands))?;
    slice.answers.read(size[0] as usize * size[1] as usize)
}
