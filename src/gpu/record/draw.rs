//! Draws within a render that is being recorded.

use crate::gpu::record::commands::Pass;
use crate::gpu::record::render::{area, viewport};
use crate::gpu::{Buffer, Kernel, Push};
use std::ops::Range;

/// Draws being recorded.
pub struct Draw<'d, 'c, 'a> {
    pub(in crate::gpu) pass: &'d mut Pass<'c, 'a>,
}

impl Draw<'_, '_, '_> {
    /// Restricts subsequent draws to the `size` texels from row `first_row` on: one of several maps stacked in one target.
    pub fn rows(&mut self, first_row: u32, size: [u32; 2]) {
        self.area([0, first_row], size);
    }

    /// Restricts subsequent draws to the `size` texels from `corner` on.
    pub fn area(&mut self, corner: [u32; 2], size: [u32; 2]) {
        let buffer = self.pass.commands.buffer;
        let device = self.pass.commands.device();
        // SAFETY: a render has begun; viewport and scissor are dynamic state in every kernel.
        unsafe {
            device.cmd_set_viewport(buffer, 0, &viewport(corner, size));
            device.cmd_set_scissor(buffer, 0, &[area(corner, size)]);
        }
    }

    /// Draws with the VkDrawIndirectCommand at `offset` in `draws`, three vertices per triangle.
    pub fn draw_indirect<P: Push>(&mut self, kernel: &Kernel<P>, push: &P, draws: &Buffer, offset: u64) {
        self.pass.bind(kernel, push);
        let buffer = self.pass.commands.buffer;
        // SAFETY: a render has begun, kernel and sets are bound; the buffer is kept alive and allows indirect draws.
        unsafe { self.pass.commands.device().cmd_draw_indirect(buffer, draws.handle(), offset, 1, 16) };
        self.pass.commands.keep(draws.kept());
    }

    /// Draws patches with a kernel created by [`Kernel::tessellated`], with at most 64 segments per side.
    pub fn draw_patches<P: Push>(&mut self, kernel: &Kernel<P>, push: &P, patches: Range<u32>) {
        self.pass.bind(kernel, push);
        let buffer = self.pass.commands.buffer;
        // lavapipe numbers a draw's tessellated vertices with 16 bits. A patch has up to 65² vertices, so 15 patches fit.
        let software = self.pass.commands.context.features().is_software();
        let most = if software { 15 } else { patches.len().max(1) };
        for first in patches.clone().step_by(most) {
            let count = (patches.end - first).min(most as u32);
            // SAFETY: a render has begun, kernel and sets are bound.
            unsafe { self.pass.commands.device().cmd_draw(buffer, count, 1, first, 0) };
        }
    }

    /// Draws the vertices of this range, three per triangle.
    pub fn draw_part<P: Push>(&mut self, kernel: &Kernel<P>, push: &P, vertices: Range<u32>) {
        self.pass.bind(kernel, push);
        let buffer = self.pass.commands.buffer;
        let count = vertices.end.saturating_sub(vertices.start);
        // SAFETY: a render has begun, kernel and sets are bound.
        unsafe { self.pass.commands.device().cmd_draw(buffer, count, 1, vertices.start, 0) };
    }

    /// Draws `vertices` vertices `instances` times: three per triangle, or one per point for a kernel with a geometry
    /// shader.
    pub fn draw<P: Push>(&mut self, kernel: &Kernel<P>, push: &P, vertices: u32, instances: u32) {
        self.pass.bind(kernel, push);
        let buffer = self.pass.commands.buffer;
        // SAFETY: a render has begun, kernel and sets are bound.
        unsafe { self.pass.commands.device().cmd_draw(buffer, vertices, instances, 0, 0) };
    }
}
