//! Color attachments that a fragment shader reads and writes back, one fragment per texel at a time, in drawing order
//! (VK_EXT_rasterization_order_attachment_access). The shader reads them as input attachments, which dynamic rendering does not support, so
//! this file uses a render pass.

use crate::Result;
use crate::gpu::device::device_owner::Device;
use crate::gpu::resource::KeepAlive;
use crate::gpu::testing::fault;
use crate::gpu::{Bindings, Context, Format, Image, ImageUse, Resource, vk_error};
use ash::vk;
use std::sync::Arc;

/// Images of four 32-bit floats per texel, with the render pass that draws into all of them. Clones share both.
#[derive(Clone)]
pub struct OrderedAttachments(Arc<Inner>);

struct Inner {
    device: Device,
    render_pass: vk::RenderPass,
    framebuffer: vk::Framebuffer,
    images: Vec<Image>,
    size: [u32; 2],
    inputs: Bindings,
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: recorded commands keep a clone, so the device no longer uses them; null handles are ignored.
        unsafe {
            self.device.destroy_framebuffer(self.framebuffer, None);
            self.device.destroy_render_pass(self.render_pass, None);
        }
    }
}

/// Orders the initial clear before the first fragment's read. After that, the pipeline orders the fragments.
pub(in crate::gpu) const AFTER_CLEAR: vk::SubpassDependency = vk::SubpassDependency {
    src_subpass: 0,
    dst_subpass: 0,
    src_stage_mask: vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT,
    dst_stage_mask: vk::PipelineStageFlags::FRAGMENT_SHADER,
    src_access_mask: vk::AccessFlags::COLOR_ATTACHMENT_WRITE,
    dst_access_mask: vk::AccessFlags::INPUT_ATTACHMENT_READ,
    dependency_flags: vk::DependencyFlags::BY_REGION,
};

impl OrderedAttachments {
    /// The format of every attachment.
    pub const FORMAT: Format = Format::R32G32B32A32_SFLOAT;

    /// Creates `count` attachments of `size` texels. The device must meet [`crate::gpu::Requirement::RasterOrder`], and its limits must
    /// allow that many attachments ([`crate::gpu::Features::attachment_limit`]).
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the size exceeds the device's limit or memory runs out.
    pub fn new(context: &Context, name: &str, size: [u32; 2], count: u32) -> Result<Self> {
        let image = |_| Image::new(context, name, Self::FORMAT, size, ImageUse::OrderedColor);
        let images = (0..count).map(image).collect::<Result<Vec<_>>>()?;
        let resources: Vec<_> = images.iter().cloned().map(Resource::InputAttachment).collect();
        let mut inner = Inner {
            device: context.device().clone(),
            render_pass: vk::RenderPass::null(),
            framebuffer: vk::Framebuffer::null(),
            inputs: Bindings::new(context, name, &resources)?,
            images,
            size,
        };
        let attachment = vk::AttachmentDescription::default()
            .format(Self::FORMAT)
            .samples(vk::SampleCountFlags::TYPE_1)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)
            .initial_layout(vk::ImageLayout::GENERAL)
            .final_layout(vk::ImageLayout::GENERAL);
        let attachments = vec![attachment; count as usize];
        let references: Vec<_> = (0..count)
            .map(|i| vk::AttachmentReference::default().attachment(i).layout(vk::ImageLayout::GENERAL))
            .collect();
        let subpasses = [vk::SubpassDescription::default()
            .flags(vk::SubpassDescriptionFlags::RASTERIZATION_ORDER_ATTACHMENT_COLOR_ACCESS_EXT)
            .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
            .input_attachments(&references)
            .color_attachments(&references)];
        let dependencies = [AFTER_CLEAR];
        let info = vk::RenderPassCreateInfo::default()
            .attachments(&attachments)
            .subpasses(&subpasses)
            .dependencies(&dependencies);
        let device = context.device();
        // SAFETY: everything that `info` points to is alive.
        inner.render_pass = fault::creation(|| unsafe { device.create_render_pass(&info, None) })
            .map_err(|r| vk_error("create render pass", name, r))?;
        let views: Vec<_> = inner.images.iter().map(Image::view).collect();
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(inner.render_pass)
            .attachments(&views)
            .width(size[0])
            .height(size[1])
            .layers(1);
        // SAFETY: the views match the render pass and live as long as the framebuffer.
        inner.framebuffer = fault::creation(|| unsafe { device.create_framebuffer(&info, None) })
            .map_err(|r| vk_error("create framebuffer", name, r))?;
        device.set_name(inner.render_pass, name);
        device.set_name(inner.framebuffer, name);
        Ok(Self(Arc::new(inner)))
    }

    /// Returns the attachments, for reading afterwards.
    pub fn images(&self) -> &[Image] {
        &self.0.images
    }

    /// Returns width and height, in texels.
    pub fn size(&self) -> [u32; 2] {
        self.0.size
    }

    /// Returns the set in which attachment i is binding i: the fragment shader's input attachments (`subpassInput`).
    pub fn inputs(&self) -> &Bindings {
        &self.0.inputs
    }

    pub(in crate::gpu) fn kept(&self) -> KeepAlive {
        self.0.clone()
    }

    pub(in crate::gpu) fn render_pass(&self) -> vk::RenderPass {
        self.0.render_pass
    }

    pub(in crate::gpu) fn framebuffer(&self) -> vk::Framebuffer {
        self.0.framebuffer
    }
}
