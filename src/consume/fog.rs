//! Fog before the picture, in which shadows stand as shafts. Twin: reference::truth::fog.

use super::Renderer;
use crate::Result;
use crate::gpu::{Blend, Graphics, Kernel, PassTime, Target, push_struct};
use crate::scene::Fog;
use crate::shaders::consume as shaders;
use crate::technique::Answer;

push_struct! {
    /// Twin: FogPush in glsl/consume/fog.frag.
    struct FogPush {
        extinction: f32,
        steps: u32,
    }
}

impl Renderer {
    /// Lays fog, lit by `answer`, over the picture that was drawn last; it stays on the device. Returns the pass's time, where
    /// the device has timestamps.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the driver rejects the shader or the device is lost.
    pub fn fog(&self, answer: &Answer, fog: &Fog) -> Result<Option<PassTime>> {
        let state = Graphics {
            vertex: &shaders::FULLSCREEN_VERT,
            fragment: shaders::FOG_FRAG.of(answer.folder),
            colors: &[(self.color_format, Blend::Over)],
            depth: None,
        };
        let sets = [&self.scene, answer.bindings, &self.distances];
        let kernel = Kernel::graphics(&self.context, &state, &sets, answer.constants)?;
        let push = FogPush { extinction: fog.extinction, steps: fog.steps };
        let times = self.context.submit(|commands| {
            commands.pass("consume.fog", |pass| {
                let colors = [Target { image: &self.color, clear: None }];
                pass.render(self.color.size(), &colors, None, |draw| draw.draw(&kernel, &push, 3, 1));
            });
        })?;
        Ok(times.into_iter().next())
    }
}
