//! Draws of a render that is being recorded.

use super::commands::Pass;
use super::{Bindings, Buffer, Pipeline};
use std::ops::Range;

/// Draws being recorded.
pub struct Draw<'d, 'c, 'a> {
    pub(super) pass: &'d mut Pass<'c, 'a>,
}

impl Draw<'_, '_, '_> {
    /// Draws what the VkDrawIndirectCommand at `offset` of `draws` says, three vertices a triangle.
    pub fn draw_indirect(&mut self, pipeline: &Pipeline, sets: &[&Bindings], push: &[u8], draws: &Buffer, offset: u64) {
        self.pass.bind(pipeline, sets, push);
        let buffer = self.pass.commands.buffer;
        // SAFETY: a render is begun, pipeline and sets are bound; the buffer is kept alive and allows indirect draws.
        unsafe { self.pass.commands.device().cmd_draw_indirect(buffer, draws.handle(), offset, 1, 16) };
        self.pass.commands.used.push(Box::new(draws.clone()));
    }

    /// Draws patches with a pipeline of [`Pipeline::tessellated`], cut into 64 parts a side at most.
    pub fn draw_patches(&mut self, pipeline: &Pipeline, sets: &[&Bindings], push: &[u8], patches: Range<u32>) {
        self.pass.bind(pipeline, sets, push);
        let buffer = self.pass.commands.buffer;
        // lavapipe numbers the vertices that a draw's patches are cut into with 16 bits: 65² of a patch, 15 patches.
        let cpu = self.pass.commands.context.features().kind == "cpu";
        let most = if cpu { 15 } else { patches.len().max(1) };
        for first in patches.clone().step_by(most) {
            let count = (patches.end - first).min(most as u32);
            // SAFETY: a render is begun, pipeline and sets are bound.
            unsafe { self.pass.commands.device().cmd_draw(buffer, count, 1, first, 0) };
        }
    }

    /// Draws `vertices` vertices, three a triangle, or one a point for a pipeline with a geometry shader.
    pub fn draw(&mut self, pipeline: &Pipeline, sets: &[&Bindings], push: &[u8], vertices: u32) {
        self.pass.bind(pipeline, sets, push);
        let buffer = self.pass.commands.buffer;
        // SAFETY: a render is begun, pipeline and sets are bound.
        unsafe { self.pass.commands.device().cmd_draw(buffer, vertices, 1, 0, 0) };
    }
}
