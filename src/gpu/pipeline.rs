//! Compute and graphics pipelines.

use super::{Bindings, Context, Shader, vk_error};
use crate::Result;
use ash::vk;
use std::sync::Arc;

/// Bytes of push constants that every pipeline takes; Vulkan guarantees them everywhere.
pub(super) const PUSH_BYTES: u32 = 128;

/// How a colour target combines with what is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// Replace.
    None,
    /// Premultiplied over: new + (1 − new alpha) · old.
    Over,
}

/// A graphics pipeline's state. Triangles, no culling, no vertex buffers: vertex shaders fetch by index.
pub struct Graphics<'a> {
    /// Vertex shader.
    pub vertex: &'a Shader,
    /// Fragment shader.
    pub fragment: &'a Shader,
    /// Colour targets in order.
    pub colors: &'a [(vk::Format, Blend)],
    /// Write and test depth (D32, less) or not.
    pub depth: bool,
}

/// A pipeline. Clones share it.
#[derive(Clone)]
pub struct Pipeline(Arc<Inner>);

struct Inner {
    context: Context,
    handle: vk::Pipeline,
    layout: vk::PipelineLayout,
    bind_point: vk::PipelineBindPoint,
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: recorded commands keep a clone; null handles are ignored.
        unsafe {
            self.context.device().destroy_pipeline(self.handle, None);
            self.context.device().destroy_pipeline_layout(self.layout, None);
        }
    }
}

/// A shader module, needed only while the pipeline is made.
struct Module<'a>(&'a Context, vk::ShaderModule);

impl Drop for Module<'_> {
    fn drop(&mut self) {
        // SAFETY: pipelines do not need their modules once they are made.
        unsafe { self.0.device().destroy_shader_module(self.1, None) };
    }
}

fn module<'a>(context: &'a Context, shader: &Shader) -> Result<Module<'a>> {
    let info = vk::ShaderModuleCreateInfo::default().code(shader.words);
    // SAFETY: the words are SPIR-V that the build compiled.
    unsafe { context.device().create_shader_module(&info, None) }
        .map(|m| Module(context, m))
        .map_err(|r| vk_error("load shader", shader.name, r))
}

fn layout(context: &Context, name: &str, sets: &[&Bindings], bind_point: vk::PipelineBindPoint) -> Result<Inner> {
    let sets: Vec<_> = sets.iter().map(|b| b.layout()).collect();
    let push = [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::ALL).size(PUSH_BYTES)];
    let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets).push_constant_ranges(&push);
    // SAFETY: the set layouts are alive.
    let layout = unsafe { context.device().create_pipeline_layout(&info, None) }
        .map_err(|r| vk_error("create pipeline layout", name, r))?;
    Ok(Inner { context: context.clone(), handle: vk::Pipeline::null(), layout, bind_point })
}

/// Specialization constants 0, 1, … with four bytes each.
fn entries(constants: &[u32]) -> Vec<vk::SpecializationMapEntry> {
    (0u32..)
        .zip(constants)
        .map(|(i, _)| vk::SpecializationMapEntry::default().constant_id(i).offset(i * 4).size(4))
        .collect()
}

impl Pipeline {
    /// A compute pipeline. Set i is `sets[i]`; `constants[i]` is specialization constant i.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the driver rejects the shader.
    pub fn compute(context: &Context, shader: &Shader, sets: &[&Bindings], constants: &[u32]) -> Result<Self> {
        let mut inner = layout(context, shader.name, sets, vk::PipelineBindPoint::COMPUTE)?;
        let module = module(context, shader)?;
        let map = entries(constants);
        let specialization = vk::SpecializationInfo::default().map_entries(&map).data(bytemuck::cast_slice(constants));
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.1)
            .name(c"main")
            .specialization_info(&specialization);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(inner.layout)];
        // SAFETY: everything `info` points to is alive.
        let made = unsafe { context.device().create_compute_pipelines(vk::PipelineCache::null(), &info, None) };
        inner.handle = first(made).map_err(|r| vk_error("create pipeline", shader.name, r))?;
        context.set_name(inner.handle, shader.name);
        Ok(Self(Arc::new(inner)))
    }

    /// A graphics pipeline; sets and constants as for [`Pipeline::compute`], for both stages.
    ///
    /// # Errors
    /// As [`Pipeline::compute`].
    pub fn graphics(context: &Context, state: &Graphics, sets: &[&Bindings], constants: &[u32]) -> Result<Self> {
        let name = state.fragment.name;
        let mut inner = layout(context, name, sets, vk::PipelineBindPoint::GRAPHICS)?;
        let modules = [
            (vk::ShaderStageFlags::VERTEX, module(context, state.vertex)?),
            (vk::ShaderStageFlags::FRAGMENT, module(context, state.fragment)?),
        ];
        let map = entries(constants);
        let specialization = vk::SpecializationInfo::default().map_entries(&map).data(bytemuck::cast_slice(constants));
        let stages = modules.each_ref().map(|(stage, module)| {
            vk::PipelineShaderStageCreateInfo::default()
                .stage(*stage)
                .module(module.1)
                .name(c"main")
                .specialization_info(&specialization)
        });
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
        let assembly =
            vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(vk::CullModeFlags::NONE)
            .line_width(1.0);
        let multisample =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(state.depth)
            .depth_write_enable(state.depth)
            .depth_compare_op(vk::CompareOp::LESS);
        let blends: Vec<_> = state.colors.iter().map(|(_, blend)| attachment(*blend)).collect();
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
        let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let formats: Vec<_> = state.colors.iter().map(|(format, _)| *format).collect();
        let mut rendering = vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&formats);
        if state.depth {
            rendering = rendering.depth_attachment_format(vk::Format::D32_SFLOAT);
        }
        let info = [vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&multisample)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(inner.layout)
            .push_next(&mut rendering)];
        // SAFETY: everything `info` points to is alive.
        let made = unsafe { context.device().create_graphics_pipelines(vk::PipelineCache::null(), &info, None) };
        inner.handle = first(made).map_err(|r| vk_error("create pipeline", name, r))?;
        context.set_name(inner.handle, name);
        Ok(Self(Arc::new(inner)))
    }

    pub(super) fn handle(&self) -> vk::Pipeline {
        self.0.handle
    }

    pub(super) fn layout(&self) -> vk::PipelineLayout {
        self.0.layout
    }

    pub(super) fn bind_point(&self) -> vk::PipelineBindPoint {
        self.0.bind_point
    }
}

/// One pipeline is asked for at a time; a failed one is null and needs no destroying.
fn first(
    made: std::result::Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>,
) -> std::result::Result<vk::Pipeline, vk::Result> {
    made.map_err(|(_, r)| r)?.first().copied().ok_or(vk::Result::ERROR_UNKNOWN)
}

fn attachment(blend: Blend) -> vk::PipelineColorBlendAttachmentState {
    let base = vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA);
    match blend {
        Blend::None => base,
        Blend::Over => base
            .blend_enable(true)
            .src_color_blend_factor(vk::BlendFactor::ONE)
            .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .color_blend_op(vk::BlendOp::ADD)
            .src_alpha_blend_factor(vk::BlendFactor::ONE)
            .dst_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .alpha_blend_op(vk::BlendOp::ADD),
    }
}
