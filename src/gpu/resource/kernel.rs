//! Kernels: pipelines together with their descriptor sets and push constants.

use crate::gpu::resource::pipelines::{DrawnTo, Key, Pipeline, State};
use crate::gpu::testing::fault;
use crate::gpu::{Bindings, Constants, Context, OrderedAttachments, Push, Shader, vk_error};
use crate::{Error, Result};
use ash::vk;
use std::marker::PhantomData;
use std::sync::Arc;

/// Bytes of push constants in every kernel's layout, which every Vulkan device supports.
pub(in crate::gpu) const PUSH_BYTES: u32 = 128;

/// How colors are blended into a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Blend {
    /// No blending: new replaces old.
    None,
    /// Premultiplied over: new + (1 − new alpha) · old.
    Over,
    /// Like [`Blend::Over`], but for a single channel, 0 to 2, with its own alpha. The other channels are unchanged.
    OverChannel(u32),
    /// Premultiplied under: old + (1 − old alpha) · new.
    Under,
    /// new · old, in every channel.
    Multiply,
    /// new + old, in every channel.
    Add,
    /// The greater of new and old in color, new + old in alpha.
    MaxAndAdd,
}

/// State of a graphics kernel. It draws triangles without culling and without vertex buffers: vertex shaders fetch by
/// index.
pub struct Graphics<'a> {
    /// Vertex shader.
    pub vertex: &'a Shader,
    /// Fragment shader.
    pub fragment: &'a Shader,
    /// Color targets, in order.
    pub colors: &'a [(vk::Format, Blend)],
    /// Format of the depth buffer, which draws test against (less) and write to; `None` for no depth buffer.
    pub depth: Option<vk::Format>,
}

/// How primitives are assigned to the layers of a volume.
pub struct Layered<'a> {
    /// Turns points into triangles, and selects their layers and viewports. Without a geometry shader, the vertex
    /// shader selects them.
    pub geometry: Option<&'a Shader>,
    /// Number of viewports passed to [`crate::gpu::Pass::render_layers`].
    pub viewports: u32,
}

/// Stages between vertices and triangles. A patch has one vertex.
pub struct Tessellated<'a> {
    /// Sets how many segments a patch is divided into.
    pub control: &'a Shader,
    /// Computes the vertices of the triangles.
    pub evaluation: &'a Shader,
    /// Whether to draw only the edges of the triangles, without their interiors.
    pub lines: bool,
}

/// Primitives and targets of a kernel that draws.
#[derive(Clone, Copy)]
enum Into<'a> {
    Targets,
    Patches(&'a Tessellated<'a>),
    Ordered(&'a OrderedAttachments),
    Touched,
    Layers(&'a Layered<'a>),
}

impl Graphics<'_> {
    /// Returns the key that identifies the pipeline.
    fn key(&self, into: Into) -> State {
        let target = match into {
            Into::Targets => DrawnTo::Targets,
            Into::Patches(Tessellated { control, evaluation, lines }) => {
                DrawnTo::Patches { control: control.name, evaluation: evaluation.name, lines: *lines }
            }
            Into::Ordered(attachments) => DrawnTo::Ordered { images: attachments.images().len() },
            Into::Touched => DrawnTo::Touched,
            Into::Layers(Layered { geometry, viewports }) => {
                DrawnTo::Layers { geometry: geometry.map(|shader| shader.name), viewports: *viewports }
            }
        };
        let (vertex, fragment) = (self.vertex.name, self.fragment.name);
        State::Graphics { vertex, fragment, colors: self.colors.to_vec(), depth: self.depth, target }
    }
}

/// A compute or graphics pipeline with its sets. `P` is the type of its push constants. Clones share it.
pub struct Kernel<P = ()>(Arc<Inner>, PhantomData<fn(P)>);

impl<P> Clone for Kernel<P> {
    fn clone(&self) -> Self {
        Self(self.0.clone(), PhantomData)
    }
}

pub(in crate::gpu) struct Inner {
    /// Owned by [`crate::gpu::resource::pipelines::Pipelines`], which destroys it.
    pub(in crate::gpu) pipeline: Pipeline,
    pub(in crate::gpu) bind_point: vk::PipelineBindPoint,
    /// Element i is set i of the shaders.
    pub(in crate::gpu) sets: Vec<Bindings>,
}

impl Inner {
    fn new(pipeline: Pipeline, bind_point: vk::PipelineBindPoint, sets: &[&Bindings]) -> Self {
        Self { pipeline, bind_point, sets: sets.iter().map(|b| (*b).clone()).collect() }
    }
}

/// A pipeline layout, destroyed if the pipeline cannot be created.
struct Layout<'a>(&'a Context, vk::PipelineLayout);

impl Layout<'_> {
    /// Creates the one requested pipeline, and returns it with the layout. A failed pipeline is null and is not destroyed.
    fn with(
        mut self,
        make: impl FnOnce() -> std::result::Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>,
        name: &str,
    ) -> Result<Pipeline> {
        let made = fault::creation(|| make().map_err(|(_, r)| r));
        let handle = made.and_then(|all| all.first().copied().ok_or(vk::Result::ERROR_UNKNOWN));
        let handle = handle.map_err(|r| vk_error("create pipeline", name, r))?;
        self.0.device().set_name(handle, name);
        self.0.device().executables().ask(handle, name);
        Ok(Pipeline { handle, layout: std::mem::take(&mut self.1) })
    }
}

impl Drop for Layout<'_> {
    fn drop(&mut self) {
        // SAFETY: nothing was created with it; a null handle is ignored.
        unsafe { self.0.device().destroy_pipeline_layout(self.1, None) };
    }
}

/// A shader module, needed only while the pipeline is created.
struct Module<'a>(&'a Context, vk::ShaderModule);

impl Drop for Module<'_> {
    fn drop(&mut self) {
        // SAFETY: pipelines do not need their modules after creation.
        unsafe { self.0.device().destroy_shader_module(self.1, None) };
    }
}

/// Creates the shader's module, provided that its push constants are a `P` or empty.
fn module<'a, P: Push>(context: &'a Context, shader: &Shader) -> Result<Module<'a>> {
    if !shader.push.is_empty() && shader.push != P::block() {
        return Err(Error::Gpu {
            operation: "load shader",
            name: shader.name.into(),
            cause: format!("its push constants are `{}`, and Rust has `{}`", shader.push, P::block()).into(),
            way_out: "report this as a bug".into(),
        });
    }
    let info = vk::ShaderModuleCreateInfo::default().code(shader.words());
    // SAFETY: the words are SPIR-V that the build compiled.
    fault::creation(|| unsafe { context.device().create_shader_module(&info, None) })
        .map(|m| Module(context, m))
        .map_err(|r| vk_error("load shader", shader.name, r))
}

/// Fails if the sets have more descriptors per shader stage than the device allows.
fn check_room(context: &Context, name: &str, sets: &[&Bindings]) -> Result<()> {
    let features = context.features();
    let count = |kind| sets.iter().map(|b| b.count(kind)).sum::<u32>();
    let limits = [
        ("maxBoundDescriptorSets", features.max_bound_descriptor_sets, sets.len() as u32),
        (
            "maxPerStageDescriptorStorageBuffers",
            features.max_per_stage_descriptor_storage_buffers,
            count(vk::DescriptorType::STORAGE_BUFFER),
        ),
        (
            "maxPerStageDescriptorStorageImages",
            features.max_per_stage_descriptor_storage_images,
            count(vk::DescriptorType::STORAGE_IMAGE),
        ),
    ];
    match limits.into_iter().find(|(_, has, needs)| has < needs) {
        None => Ok(()),
        Some((limit, has, needs)) => {
            let needs = format!("{limit} of at least {needs} for {name} (this device has {has})");
            Err(Error::Refused(needs.into()))
        }
    }
}

fn layout<'a>(context: &'a Context, name: &str, sets: &[&Bindings]) -> Result<Layout<'a>> {
    check_room(context, name, sets)?;
    let layouts: Vec<_> = sets.iter().map(|b| b.layout()).collect();
    let push = [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::ALL).size(PUSH_BYTES)];
    let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts).push_constant_ranges(&push);
    // SAFETY: the set layouts are alive.
    let layout = fault::creation(|| unsafe { context.device().create_pipeline_layout(&info, None) });
    layout.map(|layout| Layout(context, layout)).map_err(|r| vk_error("create pipeline layout", name, r))
}

/// Maps each constant to its four bytes: value i is at byte 4 · i.
fn entries(ids: &[u32]) -> Vec<vk::SpecializationMapEntry> {
    let entry = |(i, id): (u32, &u32)| vk::SpecializationMapEntry::default().constant_id(*id).offset(i * 4).size(4);
    (0u32..).zip(ids).map(entry).collect()
}

impl<P: Push> Kernel<P> {
    /// Creates a kernel that runs a compute shader. Set i is `sets[i]`.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the driver rejects the shader, or if its push constants are not a `P`; [`Error::Refused`] if
    /// the device allows fewer buffers, images or sets per stage.
    pub fn compute(context: &Context, shader: &Shader, sets: &[&Bindings], constants: &Constants) -> Result<Self> {
        Self::computing(context, shader, sets, constants, vk::PipelineShaderStageCreateFlags::empty())
    }

    /// Like [`Kernel::compute`], for a shader whose subgroups must be full. The device must be able to guarantee that
    /// ([`crate::gpu::Features::lacks_full_subgroups`]).
    ///
    /// # Errors
    /// Same as [`Kernel::compute`].
    pub fn full_subgroups(
        context: &Context,
        shader: &Shader,
        sets: &[&Bindings],
        constants: &Constants,
    ) -> Result<Self> {
        let flags = vk::PipelineShaderStageCreateFlags::REQUIRE_FULL_SUBGROUPS;
        Self::computing(context, shader, sets, constants, flags)
    }

    fn computing(
        context: &Context,
        shader: &Shader,
        sets: &[&Bindings],
        constants: &Constants,
        flags: vk::PipelineShaderStageCreateFlags,
    ) -> Result<Self> {
        let constants = constants.ids_and_words();
        let key = Key::new(State::Compute { shader: shader.name, flags }, P::block(), &constants, sets);
        let make = || {
            let layout = layout(context, shader.name, sets)?;
            let module = module::<P>(context, shader)?;
            let map = entries(&constants.0);
            let data = bytemuck::cast_slice(&constants.1);
            let specialization = vk::SpecializationInfo::default().map_entries(&map).data(data);
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .flags(flags)
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module.1)
                .name(c"main")
                .specialization_info(&specialization);
            let flags = context.device().executables().flags();
            let info = [vk::ComputePipelineCreateInfo::default().flags(flags).stage(stage).layout(layout.1)];
            // SAFETY: everything `info` points to is alive.
            let make = || unsafe { context.device().create_compute_pipelines(vk::PipelineCache::null(), &info, None) };
            layout.with(make, shader.name)
        };
        let pipeline = context.device().pipelines().get(key, make)?;
        Ok(Self(Arc::new(Inner::new(pipeline, vk::PipelineBindPoint::COMPUTE, sets)), PhantomData))
    }

    /// Creates a kernel that draws into the targets of [`crate::gpu::Pass::render`]. Sets and constants are as for [`Kernel::compute`], and
    /// apply to both stages.
    ///
    /// # Errors
    /// Same as [`Kernel::compute`].
    pub fn graphics(context: &Context, state: &Graphics, sets: &[&Bindings], constants: &Constants) -> Result<Self> {
        Self::drawing(context, state, Into::Targets, sets, constants)
    }

    /// Like [`Kernel::graphics`], with tessellation stages. Sets and constants apply to all stages.
    ///
    /// # Errors
    /// Same as [`Kernel::compute`].
    pub fn tessellated(
        context: &Context,
        state: &Graphics,
        tessellated: &Tessellated,
        sets: &[&Bindings],
        constants: &Constants,
    ) -> Result<Self> {
        Self::drawing(context, state, Into::Patches(tessellated), sets, constants)
    }

    /// Creates a kernel that draws in [`crate::gpu::Pass::render_layers`]. Sets and constants apply to all stages.
    ///
    /// # Errors
    /// Same as [`Kernel::compute`].
    pub fn layered(
        context: &Context,
        state: &Graphics,
        layered: &Layered,
        sets: &[&Bindings],
        constants: &Constants,
    ) -> Result<Self> {
        Self::drawing(context, state, Into::Layers(layered), sets, constants)
    }

    /// Creates a kernel for [`crate::gpu::Pass::render_ordered`] that draws into `attachments`. The fragment shader reads and writes them;
    /// per texel, it runs for one fragment at a time, in drawing order. Sets and constants are as for [`Kernel::graphics`].
    ///
    /// # Errors
    /// Same as [`Kernel::compute`].
    pub fn ordered(
        context: &Context,
        [vertex, fragment]: [&Shader; 2],
        attachments: &OrderedAttachments,
        sets: &[&Bindings],
        constants: &Constants,
    ) -> Result<Self> {
        let colors = vec![(OrderedAttachments::FORMAT, Blend::None); attachments.images().len()];
        let state = Graphics { vertex, fragment, colors: &colors, depth: None };
        Self::drawing(context, &state, Into::Ordered(attachments), sets, constants)
    }

    /// Like [`Kernel::graphics`], but a triangle covers every texel that it touches. The device must support
    /// [`crate::gpu::Features::conservative_rasterization`].
    ///
    /// # Errors
    /// Same as [`Kernel::compute`].
    pub fn touching(context: &Context, state: &Graphics, sets: &[&Bindings], constants: &Constants) -> Result<Self> {
        Self::drawing(context, state, Into::Touched, sets, constants)
    }

    fn drawing(
        context: &Context,
        state: &Graphics,
        into: Into,
        sets: &[&Bindings],
        constants: &Constants,
    ) -> Result<Self> {
        let constants = constants.ids_and_words();
        let key = Key::new(state.key(into), P::block(), &constants, sets);
        let pipeline = context.device().pipelines().get(key, || Self::draws(context, state, into, sets, &constants))?;
        Ok(Self(Arc::new(Inner::new(pipeline, vk::PipelineBindPoint::GRAPHICS, sets)), PhantomData))
    }

    fn draws(
        context: &Context,
        state: &Graphics,
        into: Into,
        sets: &[&Bindings],
        (ids, words): &(Vec<u32>, Vec<u32>),
    ) -> Result<Pipeline> {
        let name = state.fragment.name;
        let layout = layout(context, name, sets)?;
        let mut modules = vec![
            (vk::ShaderStageFlags::VERTEX, module::<P>(context, state.vertex)?),
            (vk::ShaderStageFlags::FRAGMENT, module::<P>(context, state.fragment)?),
        ];
        let (mut topology, mut viewports) = (vk::PrimitiveTopology::TRIANGLE_LIST, 1);
        if let Into::Layers(layered) = into {
            viewports = layered.viewports;
            if let Some(geometry) = layered.geometry {
                modules.push((vk::ShaderStageFlags::GEOMETRY, module::<P>(context, geometry)?));
                topology = vk::PrimitiveTopology::POINT_LIST;
            }
        }
        let mut mode = vk::PolygonMode::FILL;
        if let Into::Patches(tessellated) = into {
            modules.push((vk::ShaderStageFlags::TESSELLATION_CONTROL, module::<P>(context, tessellated.control)?));
            modules
                .push((vk::ShaderStageFlags::TESSELLATION_EVALUATION, module::<P>(context, tessellated.evaluation)?));
            topology = vk::PrimitiveTopology::PATCH_LIST;
            mode = if tessellated.lines { vk::PolygonMode::LINE } else { mode };
        }
        let map = entries(ids);
        let specialization = vk::SpecializationInfo::default().map_entries(&map).data(bytemuck::cast_slice(words));
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
        // Vulkan reads this for patches only.
        let tessellation = vk::PipelineTessellationStateCreateInfo::default().patch_control_points(1);
        let viewport =
            vk::PipelineViewportStateCreateInfo::default().viewport_count(viewports).scissor_count(viewports);
        let mut raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(mode)
            .cull_mode(vk::CullModeFlags::NONE)
            .line_width(1.0);
        let mut touched = vk::PipelineRasterizationConservativeStateCreateInfoEXT::default()
            .conservative_rasterization_mode(vk::ConservativeRasterizationModeEXT::OVERESTIMATE);
        if matches!(into, Into::Touched) {
            raster = raster.push_next(&mut touched);
        }
        let multisample =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(state.depth.is_some())
            .depth_write_enable(state.depth.is_some())
            .depth_compare_op(vk::CompareOp::LESS);
        let blends: Vec<_> = state.colors.iter().map(|(_, blend)| attachment(*blend)).collect();
        let mut blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
        let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let formats: Vec<_> = state.colors.iter().map(|(format, _)| *format).collect();
        let mut rendering = vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&formats);
        if let Some(format) = state.depth {
            rendering = rendering.depth_attachment_format(format);
        }
        if matches!(into, Into::Ordered(_)) {
            blend = blend.flags(vk::PipelineColorBlendStateCreateFlags::RASTERIZATION_ORDER_ATTACHMENT_ACCESS_EXT);
        }
        let info = vk::GraphicsPipelineCreateInfo::default()
            .flags(context.device().executables().flags())
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
            .layout(layout.1);
        let info = [match into {
            Into::Ordered(attachments) => info.render_pass(attachments.render_pass()),
            Into::Targets | Into::Patches(_) | Into::Touched | Into::Layers(_) => info.push_next(&mut rendering),
        }];
        // SAFETY: everything `info` points to is alive.
        let make = || unsafe { context.device().create_graphics_pipelines(vk::PipelineCache::null(), &info, None) };
        layout.with(make, name)
    }

    /// Returns the resources that a pass binds and keeps alive.
    pub(in crate::gpu) fn inner(&self) -> &Arc<Inner> {
        &self.0
    }
}

fn attachment(blend: Blend) -> vk::PipelineColorBlendAttachmentState {
    let written = match blend {
        // R, G and B are bits 0 to 2.
        Blend::OverChannel(channel) => vk::ColorComponentFlags::from_raw(1 << channel.min(2)),
        _ => vk::ColorComponentFlags::RGBA,
    };
    let base = vk::PipelineColorBlendAttachmentState::default().color_write_mask(written);
    let (new, old) = match blend {
        Blend::None => return base,
        Blend::Over | Blend::OverChannel(_) => (vk::BlendFactor::ONE, vk::BlendFactor::ONE_MINUS_SRC_ALPHA),
        Blend::Under => (vk::BlendFactor::ONE_MINUS_DST_ALPHA, vk::BlendFactor::ONE),
        Blend::Multiply => (vk::BlendFactor::ZERO, vk::BlendFactor::SRC_COLOR),
        Blend::Add | Blend::MaxAndAdd => (vk::BlendFactor::ONE, vk::BlendFactor::ONE),
    };
    let color_op = if blend == Blend::MaxAndAdd { vk::BlendOp::MAX } else { vk::BlendOp::ADD };
    // When blending alpha, Vulkan uses the alpha component of a color factor.
    base.blend_enable(true)
        .src_color_blend_factor(new)
        .dst_color_blend_factor(old)
        .color_blend_op(color_op)
        .src_alpha_blend_factor(new)
        .dst_alpha_blend_factor(old)
        .alpha_blend_op(vk::BlendOp::ADD)
}
