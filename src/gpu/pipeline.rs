//! Compute and graphics pipelines.

use super::{Bindings, Context, OrderedAttachments, Shader, vk_error};
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
    /// new · old, in every channel.
    Multiply,
    /// new + old, in every channel.
    Add,
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

/// How primitives reach the layers of a volume.
pub struct Layered<'a> {
    /// Makes triangles of points and chooses their layers and viewports; without one the vertex shader chooses them for
    /// its triangles.
    pub geometry: Option<&'a Shader>,
    /// How many viewports [`super::Pass::render_layers`] is given.
    pub viewports: u32,
}

/// Stages between vertices and triangles. A patch is one vertex.
pub struct Tessellated<'a> {
    /// Says into how many parts a patch is cut.
    pub control: &'a Shader,
    /// Makes the triangles' corners.
    pub evaluation: &'a Shader,
    /// Draw the triangles' sides, and not what is inside.
    pub lines: bool,
}

/// What a pipeline draws, and to what.
#[derive(Clone, Copy)]
enum Into<'a> {
    Targets,
    Patches(&'a Tessellated<'a>),
    Ordered(&'a OrderedAttachments),
    Layers(&'a Layered<'a>),
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
        Self::drawing(context, state, Into::Targets, sets, constants)
    }

    /// A graphics pipeline for [`super::Pass::render`] that tessellates; sets and constants for all its stages.
    ///
    /// # Errors
    /// As [`Pipeline::compute`].
    pub fn tessellated(
        context: &Context,
        state: &Graphics,
        tessellated: &Tessellated,
        sets: &[&Bindings],
        constants: &[u32],
    ) -> Result<Self> {
        Self::drawing(context, state, Into::Patches(tessellated), sets, constants)
    }

    /// A graphics pipeline for [`super::Pass::render_layers`]; sets and constants for all its stages.
    ///
    /// # Errors
    /// As [`Pipeline::compute`].
    pub fn layered(
        context: &Context,
        state: &Graphics,
        layered: &Layered,
        sets: &[&Bindings],
        constants: &[u32],
    ) -> Result<Self> {
        Self::drawing(context, state, Into::Layers(layered), sets, constants)
    }

    /// A graphics pipeline for [`super::Pass::render_ordered`] into `attachments`, which are what its fragment shader reads
    /// and writes: it runs for one fragment of a texel at a time, in drawing order. Sets and constants as above.
    ///
    /// # Errors
    /// As [`Pipeline::compute`].
    pub fn ordered(
        context: &Context,
        [vertex, fragment]: [&Shader; 2],
        attachments: &OrderedAttachments,
        sets: &[&Bindings],
        constants: &[u32],
    ) -> Result<Self> {
        let colors = vec![(OrderedAttachments::FORMAT, Blend::None); attachments.images().len()];
        let state = Graphics { vertex, fragment, colors: &colors, depth: false };
        Self::drawing(context, &state, Into::Ordered(attachments), sets, constants)
    }

    fn drawing(context: &Context, state: &Graphics, into: Into, sets: &[&Bindings], constants: &[u32]) -> Result<Self> {
        let name = state.fragment.name;
        let mut inner = layout(context, name, sets, vk::PipelineBindPoint::GRAPHICS)?;
        let mut modules = vec![
            (vk::ShaderStageFlags::VERTEX, module(context, state.vertex)?),
            (vk::ShaderStageFlags::FRAGMENT, module(context, state.fragment)?),
        ];
        let (mut topology, mut viewports) = (vk::PrimitiveTopology::TRIANGLE_LIST, 1);
        if let Into::Layers(layered) = into {
            viewports = layered.viewports;
            if let Some(geometry) = layered.geometry {
                modules.push((vk::ShaderStageFlags::GEOMETRY, module(context, geometry)?));
                topology = vk::PrimitiveTopology::POINT_LIST;
            }
        }
        let mut mode = vk::PolygonMode::FILL;
        if let Into::Patches(tessellated) = into {
            modules.push((vk::ShaderStageFlags::TESSELLATION_CONTROL, module(context, tessellated.control)?));
            modules.push((vk::ShaderStageFlags::TESSELLATION_EVALUATION, module(context, tessellated.evaluation)?));
            topology = vk::PrimitiveTopology::PATCH_LIST;
            mode = if tessellated.lines { vk::PolygonMode::LINE } else { mode };
        }
        let map = entries(constants);
        let specialization = vk::SpecializationInfo::default().map_entries(&map).data(bytemuck::cast_slice(constants));
        let stage = |(stage, module): &(vk::ShaderStageFlags, Module)| {
            vk::PipelineShaderStageCreateInfo::default()
                .stage(*stage)
                .module(module.1)
                .name(c"main")
                .specialization_info(&specialization)
        };
        let stages: Vec<_> = modules.iter().map(stage).collect();
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(topology);
        // Looked at for patches alone.
        let tessellation = vk::PipelineTessellationStateCreateInfo::default().patch_control_points(1);
        let viewport =
            vk::PipelineViewportStateCreateInfo::default().viewport_count(viewports).scissor_count(viewports);
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(mode)
            .cull_mode(vk::CullModeFlags::NONE)
            .line_width(1.0);
        let multisample =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(state.depth)
            .depth_write_enable(state.depth)
            .depth_compare_op(vk::CompareOp::LESS);
        let blends: Vec<_> = state.colors.iter().map(|(_, blend)| attachment(*blend)).collect();
        let mut blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
        let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let formats: Vec<_> = state.colors.iter().map(|(format, _)| *format).collect();
        let mut rendering = vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&formats);
        if state.depth {
            rendering = rendering.depth_attachment_format(vk::Format::D32_SFLOAT);
        }
        if matches!(into, Into::Ordered(_)) {
            blend = blend.flags(vk::PipelineColorBlendStateCreateFlags::RASTERIZATION_ORDER_ATTACHMENT_ACCESS_EXT);
        }
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .tessellation_state(&tessellation)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&multisample)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(inner.layout);
        let info = [match into {
            Into::Ordered(attachments) => info.render_pass(attachments.render_pass()),
            Into::Targets | Into::Patches(_) | Into::Layers(_) => info.push_next(&mut rendering),
        }];
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
    let (new, old) = match blend {
        Blend::None => return base,
        Blend::Over => (vk::BlendFactor::ONE, vk::BlendFactor::ONE_MINUS_SRC_ALPHA),
        Blend::Multiply => (vk::BlendFactor::ZERO, vk::BlendFactor::SRC_COLOR),
        Blend::Add => (vk::BlendFactor::ONE, vk::BlendFactor::ONE),
    };
    // The alpha of a colour factor is the alpha factor.
    base.blend_enable(true)
        .src_color_blend_factor(new)
        .dst_color_blend_factor(old)
        .color_blend_op(vk::BlendOp::ADD)
        .src_alpha_blend_factor(new)
        .dst_alpha_blend_factor(old)
        .alpha_blend_op(vk::BlendOp::ADD)
}
