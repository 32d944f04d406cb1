//! Pipelines, whose shaders are compiled when the renderer opens. Shaders that query shadows include the file of Gobo's technique as
//! gobo.glsl. All pipelines share one layout: set 0 is the renderer's, set 1 Gobo's.

use super::memory::Target;
use super::{Gpu, Push, Result};
use ash::vk;
use gobo::technique::Answer;
use shaderc::{CompileOptions, Compiler, EnvVersion, ResolvedInclude, ShaderKind, TargetEnv};

/// A shader's name, text and stage.
pub type Shader = (&'static str, &'static str, ShaderKind);

pub const MOVE: Shader = ("move.comp", include_str!("../shaders/move.comp"), ShaderKind::Compute);
pub const SORT: Shader = ("sort.comp", include_str!("../shaders/sort.comp"), ShaderKind::Compute);
pub const GROUND_VERT: Shader = ("ground.vert", include_str!("../shaders/ground.vert"), ShaderKind::Vertex);
pub const GROUND_FRAG: Shader = ("ground.frag", include_str!("../shaders/ground.frag"), ShaderKind::Fragment);
pub const SMOKE_VERT: Shader = ("smoke.vert", include_str!("../shaders/smoke.vert"), ShaderKind::Vertex);
pub const SMOKE_FRAG: Shader = ("smoke.frag", include_str!("../shaders/smoke.frag"), ShaderKind::Fragment);

/// Creates pipelines that share one layout and use one technique.
pub struct Pipelines<'a> {
    gpu: &'a mut Gpu,
    pub layout: vk::PipelineLayout,
    compiler: Compiler,
    answer: Answer<'a>,
    /// Values of the technique's constants, with ids from 0 on.
    entries: Vec<vk::SpecializationMapEntry>,
    values: Vec<u8>,
}

impl<'a> Pipelines<'a> {
    pub fn new(gpu: &'a mut Gpu, sets: &[vk::DescriptorSetLayout], answer: Answer<'a>) -> Result<Self> {
        let push = vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::ALL);
        let push = [push.size(size_of::<Push>() as u32)];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(sets).push_constant_ranges(&push);
        // SAFETY: the set layouts belong to this device, and the handle is passed to `keep` at once.
        let layout = unsafe {
            let layout = gpu.device.create_pipeline_layout(&info, None)?;
            gpu.keep(move |device| device.destroy_pipeline_layout(layout, None));
            layout
        };
        let (ids, values): (Vec<u32>, Vec<u32>) = answer.specialization(0).into_iter().unzip();
        let entry = vk::SpecializationMapEntry::default().size(4);
        let entries = ids.iter().enumerate().map(|(i, id)| entry.constant_id(*id).offset(4 * i as u32)).collect();
        let values = bytemuck::pod_collect_to_vec(&values);
        Ok(Self { gpu, layout, compiler: Compiler::new()?, answer, entries, values })
    }

    /// Compiles a shader. The technique's file always has set 1 to itself, with constant ids from 0 on.
    fn module(&mut self, (name, text, kind): Shader) -> Result<vk::ShaderModule> {
        let (gobo, mut options) = (self.answer.file(), CompileOptions::new()?);
        options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
        options.set_warnings_as_errors();
        options.set_include_callback(|name, _, _, _| {
            let content = match name {
                "gobo.glsl" => gobo.text,
                "scene.glsl" => include_str!("../shaders/scene.glsl"),
                "shadow.glsl" => include_str!("../shaders/shadow.glsl"),
                _ => return Err(format!("no file {name}")),
            };
            Ok(ResolvedInclude { resolved_name: name.into(), content: content.into() })
        });
        let technique = gobo.technique.replace('-', "_");
        for (name, value) in [("SET", "1"), ("BINDING", "0"), ("CONSTANT", "0")] {
            options.add_macro_definition(&format!("GOBO_{}_{name}", technique.to_uppercase()), Some(value));
        }
        for name in ["visibility", "receiver"] {
            options.add_macro_definition(&format!("gobo_{name}"), Some(&format!("gobo_{technique}_{name}")));
        }
        let spirv = self.compiler.compile_into_spirv(text, kind, name, "main", Some(&options))?;
        let info = vk::ShaderModuleCreateInfo::default().code(spirv.as_binary());
        // SAFETY: the compiler wrote the words, and the handle is passed to `keep` at once.
        unsafe {
            let module = self.gpu.device.create_shader_module(&info, None)?;
            self.gpu.keep(move |device| device.destroy_shader_module(module, None));
            Ok(module)
        }
    }

    pub fn compute(&mut self, shader: Shader) -> Result<vk::Pipeline> {
        let module = self.module(shader)?;
        let constants = vk::SpecializationInfo::default().map_entries(&self.entries).data(&self.values);
        let stage = vk::PipelineShaderStageCreateInfo::default().stage(vk::ShaderStageFlags::COMPUTE).name(c"main");
        let stage = stage.module(module).specialization_info(&constants);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(self.layout)];
        // SAFETY: everything that `info` points to outlives the call, and the pipeline is kept.
        unsafe {
            let pipelines = self.gpu.device.create_compute_pipelines(vk::PipelineCache::null(), &info, None);
            let pipeline = pipelines.map_err(|(_, why)| why)?[0];
            self.gpu.keep(move |device| device.destroy_pipeline(pipeline, None));
            Ok(pipeline)
        }
    }

    /// Creates a pipeline that draws triangles without vertex buffers and blends premultiplied color over the target.
    pub fn graphics(&mut self, vertex: Shader, fragment: Shader) -> Result<vk::Pipeline> {
        let (vertex, fragment) = (self.module(vertex)?, self.module(fragment)?);
        let constants = vk::SpecializationInfo::default().map_entries(&self.entries).data(&self.values);
        let stage = vk::PipelineShaderStageCreateInfo::default().name(c"main").specialization_info(&constants);
        let fragment = stage.stage(vk::ShaderStageFlags::FRAGMENT).module(fragment);
        let stages = [stage.stage(vk::ShaderStageFlags::VERTEX).module(vertex), fragment];
        let input = vk::PipelineVertexInputStateCreateInfo::default();
        let (list, one) = (vk::PrimitiveTopology::TRIANGLE_LIST, vk::SampleCountFlags::TYPE_1);
        let triangles = vk::PipelineInputAssemblyStateCreateInfo::default().topology(list);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
        let samples = vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(one);
        let (all, rest) = (vk::BlendFactor::ONE, vk::BlendFactor::ONE_MINUS_SRC_ALPHA);
        let over = vk::PipelineColorBlendAttachmentState::default().blend_enable(true);
        let over = over.src_color_blend_factor(all).dst_color_blend_factor(rest);
        let over = over.src_alpha_blend_factor(all).dst_alpha_blend_factor(rest);
        let over = [over.color_write_mask(vk::ColorComponentFlags::RGBA)];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&over);
        let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let mut rendering = vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&[Target::FORMAT]);
        let info = vk::GraphicsPipelineCreateInfo::default().stages(&stages).vertex_input_state(&input);
        let info = info.input_assembly_state(&triangles).viewport_state(&viewport).rasterization_state(&raster);
        let info = info.multisample_state(&samples).color_blend_state(&blend).dynamic_state(&dynamic);
        let info = [info.layout(self.layout).push_next(&mut rendering)];
        // SAFETY: everything that `info` points to outlives the call, and the pipeline is kept.
        unsafe {
            let pipelines = self.gpu.device.create_graphics_pipelines(vk::PipelineCache::null(), &info, None);
            let pipeline = pipelines.map_err(|(_, why)| why)?[0];
            self.gpu.keep(move |device| device.destroy_pipeline(pipeline, None));
            Ok(pipeline)
        }
    }
}
