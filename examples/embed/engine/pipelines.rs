//! A set of buffers, and the pipelines that use it. All pipelines have one layout: set 0 is the renderer's, set 1 Gobo's.

use super::device::Kept;
use super::memory::{Buffer, Target};
use super::{Gpu, Push, Result};
use ash::vk;

/// Descriptors that all stages see.
pub struct Set {
    pub layout: vk::DescriptorSetLayout,
    pub handle: vk::DescriptorSet,
}

impl Set {
    /// With these bindings of one descriptor each, not yet written.
    pub fn new(gpu: &mut Gpu, bindings: &[vk::DescriptorSetLayoutBinding]) -> Result<Self> {
        let size = |binding: &vk::DescriptorSetLayoutBinding| {
            vk::DescriptorPoolSize::default().ty(binding.descriptor_type).descriptor_count(1)
        };
        let sizes: Vec<_> = bindings.iter().map(size).collect();
        let layout = vk::DescriptorSetLayoutCreateInfo::default().bindings(bindings);
        let pool = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: each handle is kept at once, and all that the structures point to lives.
        unsafe {
            let layouts = [gpu.device.create_descriptor_set_layout(&layout, None)?];
            gpu.keep(Kept::SetLayout(layouts[0]));
            let pool = gpu.device.create_descriptor_pool(&pool, None)?;
            gpu.keep(Kept::SetPool(pool));
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            Ok(Self { layout: layouts[0], handle: gpu.device.allocate_descriptor_sets(&info)?[0] })
        }
    }

    /// A layout of storage buffers.
    pub fn of_buffers(gpu: &mut Gpu, buffers: &[&Buffer]) -> Result<Self> {
        let storage = vk::DescriptorType::STORAGE_BUFFER;
        let binding = vk::DescriptorSetLayoutBinding::default()
            .descriptor_type(storage)
            .descriptor_count(1)
            .stage_flags(vk::ShaderStageFlags::ALL);
        let bindings: Vec<_> = (0..buffers.len()).map(|i| binding.binding(i as u32)).collect();
        let set = Self::new(gpu, &bindings)?;
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

/// What all pipelines take: some sets, and a frame's numbers.
pub fn layout(gpu: &mut Gpu, sets: &[vk::DescriptorSetLayout]) -> Result<vk::PipelineLayout> {
    let push = vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::ALL).size(size_of::<Push>() as u32);
    let push = [push];
    let info = vk::PipelineLayoutCreateInfo::default().set_layouts(sets).push_constant_ranges(&push);
    // SAFETY: the sets' layouts are of this device, and the handle is kept at once.
    let layout = unsafe { gpu.device.create_pipeline_layout(&info, None) }?;
    gpu.keep(Kept::Layout(layout));
    Ok(layout)
}

/// Values of a shader's specialization constants, by their ids.
pub struct Constants {
    entries: Vec<vk::SpecializationMapEntry>,
    words: Vec<u32>,
}

impl Constants {
    pub fn new(ids_and_words: &[(u32, u32)]) -> Self {
        let entry = |(i, (id, _)): (usize, &(u32, u32))| {
            vk::SpecializationMapEntry::default().constant_id(*id).offset(4 * i as u32).size(4)
        };
        let entries = ids_and_words.iter().enumerate().map(entry).collect();
        Self { entries, words: ids_and_words.iter().map(|(_, word)| *word).collect() }
    }

    fn info(&self) -> vk::SpecializationInfo<'_> {
        vk::SpecializationInfo::default().map_entries(&self.entries).data(bytemuck::cast_slice(&self.words))
    }
}

fn stage(
    gpu: &mut Gpu,
    stage: vk::ShaderStageFlags,
    spirv: &[u32],
) -> Result<vk::PipelineShaderStageCreateInfo<'static>> {
    let info = vk::ShaderModuleCreateInfo::default().code(spirv);
    // SAFETY: the compiler wrote the words, and the handle is kept at once.
    let module = unsafe { gpu.device.create_shader_module(&info, None) }?;
    gpu.keep(Kept::Module(module));
    Ok(vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module).name(c"main"))
}

pub fn compute(
    gpu: &mut Gpu,
    layout: vk::PipelineLayout,
    spirv: &[u32],
    constants: &Constants,
) -> Result<vk::Pipeline> {
    let constants = constants.info();
    let stage = stage(gpu, vk::ShaderStageFlags::COMPUTE, spirv)?.specialization_info(&constants);
    let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout)];
    // SAFETY: the module and the layout are kept.
    let made = unsafe { gpu.device.create_compute_pipelines(vk::PipelineCache::null(), &info, None) };
    keep(gpu, made)
}

/// Triangles without vertex buffers; they draw premultiplied color, blended over.
pub fn draw(
    gpu: &mut Gpu,
    layout: vk::PipelineLayout,
    [vertex, fragment]: [&[u32]; 2],
    constants: &Constants,
) -> Result<vk::Pipeline> {
    let constants = constants.info();
    let stages = [
        stage(gpu, vk::ShaderStageFlags::VERTEX, vertex)?,
        stage(gpu, vk::ShaderStageFlags::FRAGMENT, fragment)?.specialization_info(&constants),
    ];
    let input = vk::PipelineVertexInputStateCreateInfo::default();
    let triangles = vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
    let one = vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
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
    let mut rendering = vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&[Target::FORMAT]);
    let info = [vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&input)
        .input_assembly_state(&triangles)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&one)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout)
        .push_next(&mut rendering)];
    // SAFETY: all that `info` points to lives until the call is over.
    let made = unsafe { gpu.device.create_graphics_pipelines(vk::PipelineCache::null(), &info, None) };
    keep(gpu, made)
}

/// What Vulkan answers where pipelines are wanted.
type Made = std::result::Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>;

fn keep(gpu: &mut Gpu, made: Made) -> Result<vk::Pipeline> {
    // Where the only one could not be made its handle is null.
    let pipeline = made.map_err(|(_, why)| why)?[0];
    gpu.keep(Kept::Pipeline(pipeline));
    Ok(pipeline)
}
