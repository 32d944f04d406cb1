//! Number of steps that look-ups take, pixel by pixel, to show where look-ups cost most.

use super::Renderer;
use crate::gpu::{Blend, Commands, Format, Graphics, Image, ImageUse, Kernel, Target};
use crate::shaders::{FOLDERS, shading as shaders};
use crate::technique::Answer;
use crate::{Error, Result};

/// Value of pixels that see no mesh.
const NONE: f32 = -1.0;

/// Counts the steps of one technique's look-ups in pictures of one [`Renderer`].
pub struct StepsKernel {
    kernel: Kernel,
    counts: Image,
}

impl StepsKernel {
    /// Returns the steps as floats, below 0 where there is no mesh.
    pub fn image(&self) -> &Image {
        &self.counts
    }

    /// Converts a float of the image to a count; `None` where there is no mesh.
    pub fn count(float: f32) -> Option<u32> {
        (float >= 0.0).then_some(float as u32)
    }
}

impl Renderer {
    /// Returns, for the surface that each pixel sees, the number of steps that the look-ups of all lights take together, with rows from the
    /// top; `None` if the pixel sees no mesh. Each technique defines what it counts as a step.
    ///
    /// # Errors
    /// Same as [`Renderer::steps_kernel`]; [`Error::Refused`] on an adopted device, since this call submits and reads back.
    pub fn steps(&self, answer: &Answer) -> Result<Vec<Option<u32>>> {
        self.context.require_queue()?;
        let kernel = self.steps_kernel(answer)?;
        self.context.submit(|commands| self.record_steps(commands, &kernel))?;
        Ok(kernel.counts.read::<f32>()?.into_iter().map(StepsKernel::count).collect())
    }

    /// Creates the kernel that counts the steps of the look-ups of `answer`.
    ///
    /// # Errors
    /// [`Error::Input`] if the technique does not count steps, [`Error::Refused`] if meshes may have alpha, [`Error::Gpu`] if memory runs
    /// out.
    pub fn steps_kernel(&self, answer: &Answer) -> Result<StepsKernel> {
        if !answer.folder.counts_steps {
            let counting = FOLDERS.iter().filter(|f| f.counts_steps).map(|f| f.name.replace('_', "-"));
            let way_out = format!("name one that does: {}", counting.collect::<Vec<_>>().join(", "));
            let cause = "it does not count the steps of its look-ups";
            return Err(Error::input(answer.folder.name.replace('_', "-"), cause, way_out));
        }
        if self.scene.has_alpha {
            return Err(Error::Refused("meshes without alpha: steps are counted where a mesh is drawn whole".into()));
        }
        let state = Graphics {
            vertex: &shaders::SURFACE_VERT,
            fragment: shaders::STEPS_FRAG.of(answer.folder),
            colors: &[(Format::R32_SFLOAT, Blend::None)],
            depth: Some(Format::D32_SFLOAT),
        };
        let (format, size) = (Format::R32_SFLOAT, self.targets.color.size());
        Ok(StepsKernel {
            kernel: Kernel::graphics(&self.context, &state, &[&self.scene.set, answer.bindings], answer.constants)?,
            counts: Image::new(&self.context, "picture.steps", format, size, ImageUse::Color)?,
        })
    }

    /// Records the pass that counts the steps.
    pub fn record_steps(&self, commands: &mut Commands, kernel: &StepsKernel) {
        commands.pass("shading.steps", |pass| {
            let colors = [Target { image: &kernel.counts, clear: Some([NONE; 4]) }];
            let depth = Target { image: &self.targets.depth, clear: Some([1.0; 4]) };
            pass.render(self.targets.color.size(), &colors, Some(depth), |draw| {
                draw.draw(&kernel.kernel, &(), self.scene.triangle_vertices, 1);
            });
        });
    }
}
