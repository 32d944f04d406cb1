//! The passes of a picture: meshes, the sky behind them, casters.

use super::kernels::{Casters, Kernels, Meshes, SpacingPush};
use super::{Renderer, Shading};
use crate::Result;
use crate::gpu::{Commands, Kernel, Pass, Target};
use crate::scene::{Picture, SKY};
use crate::technique::Answer;
use std::ops::Range;

/// Maximum number of casters whose triangles are outlined.
const OUTLINED: u32 = 60;

impl Renderer {
    /// Draws the picture and, on top of some casters, the outlines of their triangles; nearer objects hide the outlines. At most 60
    /// casters, evenly spread, are outlined, so that lines do not hide each other.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] if the device lacks tessellation or lines, otherwise the same as [`Renderer::picture`].
    pub fn wireframe(&self, answer: &Answer, shading: Shading, spacing: f32) -> Result<Picture> {
        self.draw(&self.wireframe_kernels(answer, shading, spacing)?)?;
        self.read()
    }

    pub(super) fn meshes(&self, commands: &mut Commands, kernels: &Kernels) -> Result<()> {
        match &kernels.meshes {
            Meshes::Forward(forward) => self.forward(commands, forward),
            Meshes::Shaded(shade) => shade.record(commands, self),
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
        self.sort(commands, kernels);
        match &kernels.casters {
            Casters::Painted(painter) => painter.record(commands, self, &(0..u32::MAX)),
            Casters::Fragment(channels) => self.caster(commands, channels, kernels, &(0..u32::MAX)),
            Casters::Vertex(channels, push) => self.vertex_lit(commands, channels, push, kernels),
            Casters::Outlined { filled, lines, push } => self.outlined(commands, [filled, lines], push, kernels),
            Casters::HalfAngleDraw(sliced) => sliced.record(commands, self),
            Casters::PaintedSlices(slices) => slices.record(commands, self),
        }
    }

    /// Sorts the casters into the order in which they are drawn.
    pub(super) fn sort(&self, commands: &mut Commands, kernels: &Kernels) {
        // A technique that paints casters sorts them itself.
        if !matches!(kernels.casters, Casters::HalfAngleDraw(_) | Casters::PaintedSlices(_)) {
            self.blending.record(commands, &self.camera);
        }
    }

    pub(super) fn forward(&self, commands: &mut Commands, kernel: &Kernel) {
        commands.pass("shading.forward", |pass| {
            let colors = [
                Target { image: &self.targets.color, clear: self.sky() },
                Target { image: &self.targets.distance, clear: Some([self.camera.far; 4]) },
            ];
            let depth = Target { image: &self.targets.depth, clear: Some([1.0; 4]) };
            pass.render(self.targets.color.size(), &colors, Some(depth), |draw| {
                draw.draw(kernel, &(), self.scene.triangle_vertices, 1);
            });
        });
    }

    pub(super) fn deferred(&self, commands: &mut Commands, kernel: &Kernel) {
        commands.pass("shading.deferred", |pass| {
            let colors = [Target { image: &self.targets.color, clear: self.sky() }];
            pass.render(self.targets.color.size(), &colors, None, |draw| draw.draw(kernel, &(), 3, 1));
        });
    }

    /// Draws the casters at positions `part` of the blending order, and the volumes between them.
    pub(super) fn caster(&self, commands: &mut Commands, channels: &[Kernel], kernels: &Kernels, part: &Range<u32>) {
        commands.pass("shading.caster", |pass| {
            let colors = [Target { image: &self.targets.color, clear: None }];
            pass.render(self.targets.color.size(), &colors, None, |draw| {
                for (channel, kernel) in channels.iter().enumerate() {
                    self.draw_blended(draw, part, kernels.volumes.as_ref(), channel, |draw, places| {
                        draw.draw_part(kernel, &(), 6 * places.start..6 * places.end);
                    });
                }
            });
        });
    }

    fn vertex_lit(
        &self,
        commands: &mut Commands,
        channels: &[Kernel<SpacingPush>],
        push: &SpacingPush,
        kernels: &Kernels,
    ) {
        commands.pass("shading.vertex_lit", |pass| {
            self.patches(pass, push, kernels, channels.len(), |channel, places| vec![(&channels[channel], places)]);
        });
    }

    fn outlined(
        &self,
        commands: &mut Commands,
        [filled, lines]: [&[Kernel<SpacingPush>]; 2],
        push: &SpacingPush,
        kernels: &Kernels,
    ) {
        let step = self.blending.casters.div_ceil(OUTLINED).max(1);
        let outlined = |i: u32| i % step == step / 2;
        let both = |channel: usize, places: Range<u32>| {
            let kernels = |i| [Some(&filled[channel]), outlined(i).then_some(&lines[channel])];
            places.flat_map(|i| kernels(i).into_iter().flatten().map(move |kernel| (kernel, i..i + 1))).collect()
        };
        commands.pass("shading.wireframe", |pass| self.patches(pass, push, kernels, filled.len(), both));
    }

    /// Draws casters as patches, and volumes between them, once per channel. `draws` returns the kernels for a channel and a range of
    /// positions in the blending order.
    fn patches<'k>(
        &self,
        pass: &mut Pass,
        push: &SpacingPush,
        kernels: &Kernels,
        channels: usize,
        draws: impl Fn(usize, Range<u32>) -> Vec<(&'k Kernel<SpacingPush>, Range<u32>)>,
    ) {
        let colors = [Target { image: &self.targets.color, clear: None }];
        pass.render(self.targets.color.size(), &colors, None, |draw| {
            for channel in 0..channels {
                self.draw_blended(draw, &(0..u32::MAX), kernels.volumes.as_ref(), channel, |draw, places| {
                    for (kernel, casters) in draws(channel, places) {
                        draw.draw_patches(kernel, push, casters);
                    }
                });
            }
        });
    }

    pub(super) fn sky(&self) -> Option<[f32; 4]> {
        Some([SKY[0], SKY[1], SKY[2], 1.0])
    }
}
