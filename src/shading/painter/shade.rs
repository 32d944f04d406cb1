//! Meshes shaded by a compute pass, with one thread per pixel, from the triangle that the pixel sees.

use super::Canvas;
use crate::Result;
use crate::gpu::{Bindings, Commands, Kernel, push_struct};
use crate::maps::SeenTriangles;
use crate::scene::SKY;
use crate::shaders::{painter as shaders, set};
use crate::shading::{Renderer, lock};
use crate::technique::Answer;
use std::sync::{Arc, Mutex};

push_struct! {
    /// Twin: ShadePush in glsl/shading/painter/shade.comp.
    struct ShadePush {
        sky: [f32; 3],
        is_smooth: u32,
    }
}

/// Finds and shades the meshes, lit by one technique.
pub(in crate::shading) struct Shade {
    canvas: Arc<Canvas>,
    seen: Arc<Mutex<SeenTriangles>>,
    kernel: Kernel<ShadePush>,
    is_smooth: bool,
}

impl Shade {
    pub(in crate::shading) fn new(renderer: &Renderer, answer: &Answer) -> Result<Self> {
        let (canvas, seen) = (renderer.canvas()?, renderer.seen_triangles()?);
        let corners = renderer.display.as_ref().and_then(|shown| shown.normals.as_ref());
        let pixels = lock(&seen).pixels.clone();
        let set = set::PainterShaded {
            seen: &pixels,
            corners: corners.unwrap_or(&pixels),
            colors: &canvas.colors,
            distances: &renderer.targets.distance,
        };
        let set: Bindings = set.bind(&renderer.context, "painter.shaded")?;
        let sets = [&renderer.scene.set, answer.bindings, &set];
        let shader = shaders::SHADE.of(answer.folder);
        let kernel = Kernel::compute(&renderer.context, shader, &sets, answer.constants)?;
        Ok(Self { is_smooth: corners.is_some(), canvas, seen, kernel })
    }

    pub(in crate::shading) fn record(&self, commands: &mut Commands, renderer: &Renderer) {
        lock(&self.seen).record(commands, renderer.scene.triangle_vertices / 3);
        let push = ShadePush { sky: SKY, is_smooth: self.is_smooth.into() };
        commands.pass("painter.shade", |pass| pass.dispatch(&self.kernel, &push, self.canvas.groups()));
        self.canvas.end(commands);
    }
}
