//! The pass that reads the alpha of triangles from the caller's buffers. It writes what [`super::alpha::words`] returns.

use super::alpha;
use super::source::{AlphaAt, Corners, NOWHERE, held, words};
use crate::gpu::{Buffer, Commands, Context, groups, push_struct};
use crate::scene::AlphaMode;
use crate::shaders::{set, world as shaders};
use crate::world::gather::{Kernels, THREADS};
use crate::{Error, Result};

push_struct! {
    /// Twin: AlphaPush in glsl/world/gather_alpha.comp.
    pub(super) struct AlphaPush {
        slots: u32,
        most: u32,
        start: u32,
        stride: u32,
        vertices: u32,
        indices_at: u32,
        uv: u32,
        factor: u32,
        factor_is: f32,
        cutoff: f32,
        texels_at: u32,
        texel_words: u32,
        size: u32,
    }
}

/// The kernels of the pass.
pub(super) struct GatherAlpha(Kernels<AlphaPush>);

fn error(cause: String) -> Error {
    Error::input("alpha of triangles", cause, "give what the buffer holds, or make the world with a larger capacity")
}

impl GatherAlpha {
    pub(super) fn new() -> Self {
        Self(Kernels::new(&shaders::GATHER_ALPHA))
    }

    /// Records the pass for `capacity` triangles, whose textures have room for `room` texels.
    pub(super) fn record(
        &mut self,
        context: &Context,
        commands: &mut Commands,
        (triangles, capacity, room): (&Buffer, u32, u32),
        corners: &Corners,
        at: &AlphaAt,
    ) -> Result<()> {
        let what = "alpha of triangles";
        if let AlphaMode::Cut(cutoff) = at.mode
            && !(cutoff > 0.0 && cutoff <= 1.0)
        {
            return Err(error(format!("a cutoff of {cutoff}, and it is above 0 and at most 1")));
        }
        let (factor, factor_is) = at.factor.pushed(what)?;
        let uv_end = at.texture.as_ref().map_or(0, |texture| texture.uv.saturating_add(8));
        let vertices = held(&corners.vertices, corners.offset, corners.stride, 12.max(at.factor.end()).max(uv_end));
        let (indices, indices_at, most) = match &corners.indices {
            Some((buffer, offset)) => (buffer, words(what, *offset)?, held(buffer, *offset, 12, 12)),
            None => (&corners.vertices, NOWHERE, vertices / 3),
        };
        let push = AlphaPush {
            slots: capacity,
            most,
            start: words(what, corners.offset)?,
            stride: words(what, corners.stride.into())?,
            vertices,
            indices_at,
            uv: 0,
            factor,
            factor_is,
            cutoff: alpha::cutoff(at.mode),
            texels_at: 0,
            texel_words: 0,
            size: 0,
        };
        let (push, texels) = match &at.texture {
            None => (push, &corners.vertices),
            Some(texture) => {
                let texel_words = texture.words(room).map_err(error)?;
                let push = AlphaPush {
                    uv: words(what, texture.uv.into())?,
                    texels_at: words(what, texture.offset)?,
                    texel_words,
                    size: alpha::packed_size(texture.size, texture.wrap),
                    ..push
                };
                (push, &texture.texels)
            }
        };
        let (theirs, bound) = (&corners.vertices, [&corners.vertices, indices, texels]);
        let set = set::GatherAlpha { theirs, indices, texels, triangles };
        let kernel = self.0.of(context, &bound, || set.bind(context, "world.gather"))?;
        let [x, y] = groups(u64::from(capacity.div_ceil(THREADS).max(1)));
        commands.pass("world.gather", |pass| pass.dispatch(&kernel, &push, [x, y, 1]));
        Ok(())
    }
}
