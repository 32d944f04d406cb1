//! The picture of the smoke by Gobo's compute passes, in place of the renderer's own drawing: for devices whose rasterizer is slow.

use super::{Result, camera};
use gobo::gpu::{Commands, Context, Image};
use gobo::scene::View;
use gobo::shading::{Kernels, Lighting, PainterKind, Renderer, Shading};
use gobo::technique::Technique;
use gobo::world::World;

/// Where the picture ends, along the camera's axis.
const RANGE: [f64; 2] = [0.1, 200.0];

pub struct SmokePainter {
    renderer: Renderer,
    kernels: Kernels,
    view: View,
}

impl SmokePainter {
    /// For pictures of `size` pixels of the world's casters, lit by the technique.
    pub fn new(context: &Context, world: &World, technique: &dyn Technique, size: [u32; 2]) -> Result<Self> {
        let view = View::perspective(&camera(), RANGE, size);
        let mut renderer = Renderer::new(context, world, &view)?;
        renderer.paint_by(Some(PainterKind::Compute));
        let kernels = renderer.kernels(&technique.answer(), Shading::Forward, Lighting::Fragment)?;
        Ok(Self { renderer, kernels, view })
    }

    /// Records the picture of the world as it is now.
    pub fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.renderer.look(world, &self.view)?;
        Ok(self.renderer.record(commands, &self.kernels)?)
    }

    /// Takes what the frame `frame`, which is over, says. Returns whether its picture lacked casters, for which there is room by now.
    pub fn settle(&self, frame: u64) -> Result<bool> {
        Ok(!self.renderer.settle(&self.kernels, frame)?)
    }

    /// The picture: floats, premultiplied, in `VK_IMAGE_LAYOUT_GENERAL`.
    pub fn image(&self) -> &Image {
        self.renderer.image()
    }
}
