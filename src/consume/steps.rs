//! How many steps look-ups take, pixel by pixel: what a look-up costs, and where.

use super::Renderer;
use crate::gpu::{Blend, Format, Graphics, Image, ImageUse, Kernel, Target};
use crate::shaders::{FOLDERS, consume as shaders};
use crate::technique::Answer;
use crate::{Error, Result};

/// Where nothing is.
const NONE: f32 = -1.0;

impl Renderer {
    /// How many steps the look-ups of all lights take together at what each pixel shows of the meshes, rows from the top; none
    /// where it shows nothing of them. A step is what the technique counts as one.
    ///
    /// # Errors
    /// [`Error::Input`] where the technique counts none, [`Error::Gpu`] where memory runs out, [`Error::Refused`] on an adopted
    /// device: it is read at once.
    pub fn steps(&self, answer: &Answer) -> Result<Vec<Option<u32>>> {
        if !answer.folder.counts_steps {
            let counting = FOLDERS.iter().filter(|f| f.counts_steps).map(|f| f.name.replace('_', "-"));
            let way_out = format!("name one that does: {}", counting.collect::<Vec<_>>().join(", "));
            let cause = "it does not count the steps of its look-ups";
            return Err(Error::input(answer.folder.name.replace('_', "-"), cause, way_out));
        }
        self.context.require_queue()?;
        let size = self.color.size();
        let steps = Image::new(&self.context, "picture.steps", Format::R32_SFLOAT, size, ImageUse::Color)?;
        let state = Graphics {
            vertex: &shaders::SURFACE_VERT,
            fragment: shaders::STEPS_FRAG.of(answer.folder),
            colors: &[(Format::R32_SFLOAT, Blend::None)],
            depth: Some(Format::D32_SFLOAT),
        };
        let kernel: Kernel =
            Kernel::graphics(&self.context, &state, &[&self.scene, answer.bindings], answer.constants)?;
        self.context.submit(|commands| {
            commands.pass("consume.steps", |pass| {
                let colors = [Target { image: &steps, clear: Some([NONE; 4]) }];
                let depth = Target { image: &self.depth, clear: Some([1.0; 4]) };
                pass.render(size, &colors, Some(depth), |draw| draw.draw(&kernel, &(), self.triangle_vertices, 1));
            });
        })?;
        Ok(steps.read::<f32>()?.into_iter().map(|count| (count >= 0.0).then_some(count as u32)).collect())
    }
}
