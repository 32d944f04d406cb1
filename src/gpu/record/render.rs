//! Renders of a pass: into targets, into the layers of a volume, or into attachments that fragments read back.

use crate::gpu::record::ordered_attachments::AFTER_CLEAR;
use crate::gpu::{Draw, Image, OrderedAttachments, Pass};
use ash::vk;

/// A render target.
pub struct Target<'a> {
    /// The image to draw to.
    pub image: &'a Image,
    /// The value that the target is cleared to first; `None` keeps its content. Depth uses the first component.
    pub clear: Option<[f32; 4]>,
}

impl<'a> Pass<'_, 'a> {
    /// Draws into `colors` and `depth`, each of which may be empty, over `size` texels.
    pub fn render(
        &mut self,
        size: [u32; 2],
        colors: &[Target],
        depth: Option<Target>,
        record: impl FnOnce(&mut Draw<'_, '_, 'a>),
    ) {
        self.render_area([0, 0], size, colors, depth, record);
    }

    /// Like [`Pass::render`], but over the `size` texels from `corner` on. Other texels are neither drawn nor cleared.
    pub fn render_area(
        &mut self,
        corner: [u32; 2],
        size: [u32; 2],
        colors: &[Target],
        depth: Option<Target>,
        record: impl FnOnce(&mut Draw<'_, '_, 'a>),
    ) {
        let attachment = |t: &Target| {
            vk::RenderingAttachmentInfo::default()
                .image_view(t.image.view())
                .image_layout(vk::ImageLayout::GENERAL)
                .load_op(if t.clear.is_some() { vk::AttachmentLoadOp::CLEAR } else { vk::AttachmentLoadOp::LOAD })
                .store_op(vk::AttachmentStoreOp::STORE)
        };
        let color_infos: Vec<_> = colors
            .iter()
            .map(|t| {
                let float32 = t.clear.unwrap_or_default();
                attachment(t).clear_value(vk::ClearValue { color: vk::ClearColorValue { float32 } })
            })
            .collect();
        let depth_info = depth.as_ref().map(|t| {
            let depth_stencil = vk::ClearDepthStencilValue { depth: t.clear.unwrap_or_default()[0], stencil: 0 };
            attachment(t).clear_value(vk::ClearValue { depth_stencil })
        });
        let area = area(corner, size);
        let mut info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&color_infos);
        if let Some(depth_info) = &depth_info {
            info = info.depth_attachment(depth_info);
        }
        self.commands.note_render();
        let buffer = self.commands.buffer;
        let device = self.commands.device();
        // SAFETY: the attachments are kept alive, in GENERAL; the area is within them, as callers create them of that size.
        unsafe {
            device.cmd_begin_rendering(buffer, &info);
            device.cmd_set_viewport(buffer, 0, &viewport(corner, size));
            device.cmd_set_scissor(buffer, 0, &[area]);
        }
        record(&mut Draw { pass: self });
        // SAFETY: the render was begun above.
        unsafe { device.cmd_end_rendering(buffer) };
        for target in colors.iter().chain(&depth) {
            self.commands.keep(target.image.kept());
        }
    }

    /// Draws into the layers of a volume, with pipelines created by [`crate::gpu::Kernel::layered`]. `viewports` holds
    /// the side of each viewport in texels; every viewport is a square at the upper left.
    pub fn render_layers(&mut self, volume: &Image, viewports: &[u32], record: impl FnOnce(&mut Draw<'_, '_, 'a>)) {
        let colors = [vk::RenderingAttachmentInfo::default()
            .image_view(volume.attachment_view())
            .image_layout(vk::ImageLayout::GENERAL)
            .load_op(vk::AttachmentLoadOp::LOAD)
            .store_op(vk::AttachmentStoreOp::STORE)];
        let info = vk::RenderingInfo::default()
            .render_area(area([0, 0], volume.size()))
            .layer_count(volume.depth())
            .color_attachments(&colors);
        let scissors: Vec<_> = viewports.iter().map(|side| area([0, 0], [*side, *side])).collect();
        let viewports: Vec<_> = viewports.iter().flat_map(|side| viewport([0, 0], [*side, *side])).collect();
        self.commands.note_render();
        let buffer = self.commands.buffer;
        let device = self.commands.device();
        // SAFETY: the volume is kept alive, in GENERAL; area and layers cover all of it.
        unsafe {
            device.cmd_begin_rendering(buffer, &info);
            device.cmd_set_viewport(buffer, 0, &viewports);
            device.cmd_set_scissor(buffer, 0, &scissors);
        }
        record(&mut Draw { pass: self });
        // SAFETY: the render was begun above.
        unsafe { device.cmd_end_rendering(buffer) };
        self.commands.keep(volume.kept());
    }

    /// Draws into attachments that fragments read and write back in drawing order, with pipelines created by
    /// [`crate::gpu::Kernel::ordered`]. Each attachment is cleared to `clear` first.
    pub fn render_ordered(
        &mut self,
        attachments: &OrderedAttachments,
        clear: [f32; 4],
        record: impl FnOnce(&mut Draw<'_, '_, 'a>),
    ) {
        let size = attachments.size();
        let clears = vec![vk::ClearValue { color: vk::ClearColorValue { float32: clear } }; attachments.images().len()];
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(attachments.render_pass())
            .framebuffer(attachments.framebuffer())
            .render_area(area([0, 0], size))
            .clear_values(&clears);
        let barriers = [vk::MemoryBarrier::default()
            .src_access_mask(AFTER_CLEAR.src_access_mask)
            .dst_access_mask(AFTER_CLEAR.dst_access_mask)];
        let (from, to, by_region) =
            (AFTER_CLEAR.src_stage_mask, AFTER_CLEAR.dst_stage_mask, AFTER_CLEAR.dependency_flags);
        self.commands.note_render();
        let buffer = self.commands.buffer;
        let device = self.commands.device();
        // SAFETY: the attachments are kept alive, in GENERAL; the barrier is the render pass's self-dependency.
        unsafe {
            device.cmd_begin_render_pass(buffer, &info, vk::SubpassContents::INLINE);
            device.cmd_pipeline_barrier(buffer, from, to, by_region, &barriers, &[], &[]);
            device.cmd_set_viewport(buffer, 0, &viewport([0, 0], size));
            device.cmd_set_scissor(buffer, 0, &[area([0, 0], size)]);
        }
        record(&mut Draw { pass: self });
        // SAFETY: the render pass was begun above.
        unsafe { device.cmd_end_render_pass(buffer) };
        self.commands.keep(attachments.kept());
    }
}

pub(in crate::gpu) fn area([x, y]: [u32; 2], size: [u32; 2]) -> vk::Rect2D {
    vk::Rect2D {
        offset: vk::Offset2D { x: x as i32, y: y as i32 },
        extent: vk::Extent2D { width: size[0], height: size[1] },
    }
}

pub(in crate::gpu) fn viewport(corner: [u32; 2], size: [u32; 2]) -> [vk::Viewport; 1] {
    let ([x, y], [width, height]) = (corner.map(|c| c as f32), size.map(|s| s as f32));
    [vk::Viewport { x, y, width, height, min_depth: 0.0, max_depth: 1.0 }]
}
