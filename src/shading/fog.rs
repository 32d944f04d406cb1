//! Fog laid over the picture, in which shadows show as shafts. Twin: reference::truth::fog.

use super::painter::Canvas;
use super::{PainterKind, Renderer};
use crate::Result;
use crate::gpu::{Blend, Commands, Graphics, Kernel, PassTime, Target, push_struct};
use crate::query::colored;
use crate::scene::Fog;
use crate::shaders::shading as shaders;
use crate::technique::Answer;
use std::sync::Arc;

push_struct! {
    /// Twin: FogPush in glsl/shading/fog.glsl.
    struct FogPush {
        extinction: f32,
        steps: u32,
    }
}

/// Lays fog over pictures of one [`Renderer`], lit by one technique.
pub struct FogKernel {
    kernel: Kernel<FogPush>,
    /// The canvas that a compute pass paints into; `None` if the rasterizer draws.
    canvas: Option<Arc<Canvas>>,
}

impl Renderer {
    /// Lays fog, lit by `answer`, over the last picture drawn, which stays on the device. Returns the pass's time, if the device has
    /// timestamps.
    ///
    /// # Errors
    /// Same as [`Renderer::fog_kernel`]; [`crate::Error::Gpu`] if the device is lost.
    pub fn fog(&self, answer: &Answer, fog: &Fog) -> Result<Option<PassTime>> {
        let kernel = self.fog_kernel(answer)?;
        let times = self.context.submit(|commands| self.record_fog(commands, &kernel, fog))?;
        Ok(times.into_iter().next())
    }

    /// Creates the kernel that lays fog, lit by `answer`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the driver rejects the shader.
    pub fn fog_kernel(&self, answer: &Answer) -> Result<FogKernel> {
        let constants = colored(answer.constants, self.kinds.extinction_ratio);
        if self.painter_kind == PainterKind::Compute {
            let canvas = self.canvas()?;
            let sets = [&self.scene.set, answer.bindings, &canvas.bindings];
            let kernel = Kernel::compute(&self.context, shaders::FOG.of(answer.folder), &sets, &constants)?;
            return Ok(FogKernel { kernel, canvas: Some(canvas) });
        }
        let state = Graphics {
            vertex: &shaders::FULLSCREEN_VERT,
            fragment: shaders::FOG_FRAG.of(answer.folder),
            colors: &[(self.targets.format, Blend::Over)],
            depth: None,
        };
        let sets = [&self.scene.set, answer.bindings, &self.targets.distances];
        Ok(FogKernel { kernel: Kernel::graphics(&self.context, &state, &sets, &constants)?, canvas: None })
    }

    /// Records the pass that lays fog over the last picture recorded.
    pub fn record_fog(&self, commands: &mut Commands, kernel: &FogKernel, fog: &Fog) {
        let push = FogPush { extinction: fog.extinction, steps: fog.steps };
        if let Some(canvas) = &kernel.canvas {
            canvas.begin(commands);
            commands.pass("shading.fog", |pass| pass.dispatch(&kernel.kernel, &push, canvas.groups()));
            canvas.end(commands);
            return;
        }
        commands.pass("shading.fog", |pass| {
            let colors = [Target { image: &self.targets.color, clear: None }];
            pass.render(self.targets.color.size(), &colors, None, |draw| draw.draw(&kernel.kernel, &push, 3, 1));
        });
    }
}
