//! The passes of a picture: meshes, what stands behind them, casters.

use super::Renderer;
use super::kernels::{Casters, Kernels, Meshes, SpacingPush};
use crate::Result;
use crate::gpu::{Commands, Kernel, Pass, Requirement, Target};
use crate::scene::{Picture, SKY};
use crate::shaders::consume as shaders;
use crate::technique::Answer;
use std::ops::Range;
use super::{Lighting, Shading};

impl Renderer {
    /// Draws the picture and, over each caster, the sides of the triangles that it is made of; what is nearer hides them.
    ///
    /// # Errors
    /// [`Error::Refused`] where the device lacks tessellation or lines, else as [`Renderer::picture`].
    pub fn wireframe(&self, answer: &Answer, shading: Shading, spacing: f32) -> Result<Picture> {
        self.context.features().require(&[Requirement::Tessellation, Requirement::Lines])?;
        let kernels = self.kernels(answer, shading, Lighting::Vertex { spacing })?;
        let filled = self.tessellated(answer, &shaders::VERTEX_LIT_FRAG, false)?;
        let lines = self.tessellated(answer, &shaders::WIREFRAME_FRAG, true)?;
        self.frame(&kernels, |commands| {
            commands.pass("consume.wireframe", |pass| {
                let both = (0..self.caster_count).flat_map(|i| [(&filled, i..i + 1), (&lines, i..i + 1)]);
                self.patches(pass, &SpacingPush { spacing }, both);
            });
        })?;
        self.read()
    }

    pub(super) fn meshes(&self, commands: &mut Commands, kernels: &Kernels) -> Result<()> {
        match &kernels.meshes {
            Meshes::Forward(forward) => self.forward(commands, forward),
            Meshes::Deferred { gbuffer, deferred } => {
                gbuffer.record(commands, self);
                self.deferred(commands, deferred);
            }
            Meshes::Tiled { gbuffer, tiles, asking } => {
                let push = tiles.begin(&self.camera)?;
                gbuffer.record(commands, self);
                tiles.record(commands, asking, &push);
            }
            Meshes::Interleaved { gbuffer, interleaved } => {
                gbuffer.record(commands, self);
                interleaved.record(commands, &self.camera);
            }
            Meshes::Reservoir { gbuffer, reservoirs } => {
                reservoirs.begin()?;
                gbuffer.record(commands, self);
                reservoirs.record(commands, &self.camera);
            }
        }
        self.backdrop(commands);
        Ok(())
    }

    pub(super) fn casters(&self, commands: &mut Commands, kernels: &Kernels) {
        match &kernels.casters {
            Casters::Fragment(kernel) => self.caster(commands, kernel),
            Casters::Vertex(kernel, push) => self.vertex_lit(commands, kernel, push),
            Casters::Sliced(sliced) => sliced.record(commands, self),
        }
    }

    pub(super) fn forward(&self, commands: &mut Commands, kernel: &Kernel) {
        commands.pass("consume.forward", |pass| {
            let colors = [
                Target { image: &self.color, clear: self.sky() },
                Target { image: &self.distance, clear: Some([self.camera.far; 4]) },
            ];
            let depth = Target { image: &self.depth, clear: Some([1.0; 4]) };
            pass.render(self.color.size(), &colors, Some(depth), |draw| {
                draw.draw(kernel, &(), self.triangle_vertices, 1);
            });
        });
    }

    pub(super) fn deferred(&self, commands: &mut Commands, kernel: &Kernel) {
        commands.pass("consume.deferred", |pass| {
            let colors = [Target { image: &self.color, clear: self.sky() }];
            pass.render(self.color.size(), &colors, None, |draw| draw.draw(kernel, &(), 3, 1));
        });
    }

    pub(super) fn caster(&self, commands: &mut Commands, kernel: &Kernel) {
        commands.pass("consume.caster", |pass| {
            let colors = [Target { image: &self.color, clear: None }];
            pass.render(self.color.size(), &colors, None, |draw| draw.draw(kernel, &(), 6 * self.caster_count, 1));
        });
    }

    pub(super) fn vertex_lit(&self, commands: &mut Commands, kernel: &Kernel<SpacingPush>, push: &SpacingPush) {
        commands.pass("consume.vertex_lit", |pass| self.patches(pass, push, [(kernel, 0..self.caster_count)]));
    }

    /// Draws casters as patches, with each kernel those of a range from far to near.
    pub(super) fn patches<'k>(
        &self,
        pass: &mut Pass,
        push: &SpacingPush,
        draws: impl IntoIterator<Item = (&'k Kernel<SpacingPush>, Range<u32>)>,
    ) {
        let colors = [Target { image: &self.color, clear: None }];
        pass.render(self.color.size(), &colors, None, |draw| {
            for (kernel, casters) in draws {
                draw.draw_patches(kernel, push, casters);
            }
        });
    }

    pub(super) fn sky(&self) -> Option<[f32; 4]> {
        Some([SKY[0], SKY[1], SKY[2], 1.0])
    }
}
