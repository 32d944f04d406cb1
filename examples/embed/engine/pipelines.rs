//! A set of buffers, and the pipelines that use it. All pipelines have one layout: set 0 is the renderer's, set 1 Gobo's.

use super::memory::{Buffer, Target};
use super::{Gpu, Push, Result};
use ash::vk;
use std::rc::Rc;

/// Storage buffers that all stages see, at bindings 0 and on.
pub struct Set {
    gpu: Rc<Gpu>,
    pub layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    pub handle: vk::DescriptorSet,
}

impl Set {
    pub fn new(gpu: &Rc<Gpu>, buffers: &[&Buffer]) -> Result<Self> {
        let (layout, pool) = (vk::DescriptorSetLayout::null(), vk::DescriptorPool::null());
        let mut set = Self { gpu: gpu.clone(), layout, pool, handle: vk::DescriptorSet::null() };
        let (storage, count) = (vk::DescriptorType::STORAGE_BUFFER, buffers.len() as u32);
        let binding = vk::DescriptorSetLayoutBinding::default()
            .descriptor_type(storage)
            .descriptor_count(1)
            .stage_flags(vk::ShaderStageFlags::ALL);
        let bindings: Vec<_> = (0..count).map(|i| binding.binding(i)).collect();
        let layout = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        let sizes = [vk::DescriptorPoolSize { ty: storage, descriptor_count: count }];
        let pool = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: each handle goes into its owner at once, and all that the structures point to lives.
        unsafe {
            set.layout = gpu.device.create_descriptor_set_layout(&layout, None)?;
            set.pool = gpu.device.create_descriptor_pool(&pool, None)?;
            let layouts = [set.layout];
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(set.pool).set_layouts(&layouts);
            set.handle = gpu.device.allocate_descriptor_sets(&info)?[0];
        }
        for (i, buffer) in buffers.iter().enumerate() {
            let buffers = [vk::DescriptorBufferInfo::default().buffer(buffer.handle).range(vk::WHOLE_SIZE)];
            let write = vk::WriteDescriptorSet::default().dst_set(set.handle).dst_binding(i as u32);
            let write = write.descriptor_type(storage).buffer_info(&buffers);
            // SAFETY: no commands use the set yet, and the buffers live as long.
            unsafe { gpu.device.update_descriptor_sets(&[write], &[]) };
        }
        Ok(set)
    }
}

impl Drop for Set {
    fn drop(&mut self) {
        // SAFETY: the device is idle; the pool frees its set.
        unsafe {
            self.gpu.device.destroy_descriptor_pool(self.pool, None);
            self.gpu.device.destroy_descriptor_set_layout(self.layout, None);
        }
    }
}

/// What all pipelines take: some sets, and a frame's numbers.
pub struct Layout {
    gpu: Rc<Gpu>,
    pub handle: vk::PipelineLayout,
}

impl Layout {
    pub fn new(gpu: &Rc<Gpu>, sets: &[vk::DescriptorSetLayout]) -> Result<Self> {
        let push =
            [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::ALL).size(size_of::<Push>() as u32)];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(sets).push_constant_ranges(&push);
        // SAFETY: the sets' layouts are of this device.
        let handle = unsafe { gpu.device.create_pipeline_layout(&info, None) }?;
        Ok(Self { gpu: gpu.clone(), handle })
    }
}

impl Drop for Layout {
    fn drop(&mut self) {
        // SAFETY: the device is idle.
        unsafe { self.gpu.device.destroy_pipeline_layout(self.handle, None) };
    }
}

pub struct Pipeline {
    gpu: Rc<Gpu>,
    pub handle: vk::Pipeline,
}

impl Pipeline {
    pub fn compute(gpu: &Rc<Gpu>, layout: &Layout, spirv: &[u8]) -> Result<Self> {
        let module = Module::new(gpu, spirv)?;
        let info = vk::ComputePipelineCreateInfo::default()
            .stage(module.stage(vk::ShaderStageFlags::COMPUTE))
            .layout(layout.handle);
        // SAFETY: the module and the layout live until the call is over.
        let made = unsafe { gpu.device.create_compute_pipelines(vk::PipelineCache::null(), &[info], None) };
        Self::own(gpu, made)
    }

    /// Triangles without vertex buffers; what they draw is premultiplied by how much it hides of what is behind it.
    pub fn draw(gpu: &Rc<Gpu>, layout: &Layout, vertex: &[u8], fragment: &[u8]) -> Result<Self> {
        let (vertex, fragment) = (Module::new(gpu, vertex)?, Module::new(gpu, fragment)?);
        let stages = [vertex.stage(vk::ShaderStageFlags::VERTEX), fragment.stage(vk::ShaderStageFlags::FRAGMENT)];
        let input = vk::PipelineVertexInputStateCreateInfo::default();
        let assembly =
            vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
        let samples =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let over = [vk::PipelineColorBlendAttachmentState::default()
            .blend_enable(true)
            .src_color_blend_factor(vk::BlendFactor::ONE)
            .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .src_alpha_blend_factor(vk::BlendFactor::ONE)
            .dst_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .color_write_mask(vk::ColorComponentFlags::RGBA)];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&over);
        let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let formats = [Target::FORMAT];
        let mut rendering = vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&formats);
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(layout.handle)
            .push_next(&mut rendering);
        // SAFETY: all that `info` points to lives until the call is over.
        let made = unsafe { gpu.device.create_graphics_pipelines(vk::PipelineCache::null(), &[info], None) };
        Self::own(gpu, made)
    }

    fn own(
        gpu: &Rc<Gpu>,
        made: std::result::Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>,
    ) -> Result<Self> {
        // Where the only one could not be made its handle is null.
        Ok(Self { gpu: gpu.clone(), handle: made.map_err(|(_, why)| why)?[0] })
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        // SAFETY: the device is idle.
        unsafe { self.gpu.device.destroy_pipeline(self.handle, None) };
    }
}

/// A shader, until the pipeline is made.
struct Module<'a> {
    gpu: &'a Gpu,
    handle: vk::ShaderModule,
}

impl<'a> Module<'a> {
    fn new(gpu: &'a Gpu, spirv: &[u8]) -> Result<Self> {
        let words = ash::util::read_spv(&mut std::io::Cursor::new(spirv))?;
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the compiler wrote the words.
        Ok(Self { gpu, handle: unsafe { gpu.device.create_shader_module(&info, None) }? })
    }

    fn stage(&self, stage: vk::ShaderStageFlags) -> vk::PipelineShaderStageCreateInfo<'static> {
        vk::PipelineShaderStageCreateInfo::default().stage(stage).module(self.handle).name(c"main")
    }
}

impl Drop for Module<'_> {
    fn drop(&mut self) {
        // SAFETY: pipelines do not need their modules once they are made.
        unsafe { self.gpu.device.destroy_shader_module(self.handle, None) };
    }
}
