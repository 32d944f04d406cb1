//! Descriptor sets: lists of resources, in which a resource's index is its binding number.

use crate::Result;
use crate::gpu::device::context::Link;
use crate::gpu::device::device_owner::Device;
use crate::gpu::testing::fault;
use crate::gpu::{AccelerationStructure, Buffer, Context, Image, vk_error};
use ash::vk;
use std::sync::{Arc, Mutex, PoisonError};

/// A resource that can be bound to a shader.
#[derive(Clone)]
pub enum Resource {
    /// `buffer` in GLSL.
    Buffer(Buffer),
    /// `image2D`, `uimage2D` in GLSL.
    StorageImage(Image),
    /// `texture2D` in GLSL, read with `texelFetch`.
    Texture(Image),
    /// `sampler2D`, `sampler3D` in GLSL, with linear filtering and the border's value outside the image.
    Sampled(Image, Border),
    /// `sampler2D` in GLSL, read with `texelFetch` and `textureGather`, clamped to its edges.
    Gathered(Image),
    /// `subpassInput` in GLSL, for fragment shaders only.
    InputAttachment(Image),
    /// `accelerationStructureEXT` in GLSL.
    AccelerationStructure(AccelerationStructure),
}

/// A sampler's value outside its image, in every channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// 0.
    Zero,
    /// 1.
    One,
}

/// A descriptor set and its layout. Clones share it.
#[derive(Clone)]
pub struct Bindings(Arc<Inner>);

struct Inner {
    context: Link,
    shape: Arc<Shape>,
    /// The set for commands recorded from now on. Earlier commands keep the set that they were recorded with.
    current: Mutex<Arc<Set>>,
    name: String,
}

/// The layout shared by all sets with the same bindings.
struct Shape {
    device: Device,
    layout: vk::DescriptorSetLayout,
    kinds: Vec<vk::DescriptorType>,
    /// One sampler per binding; null if the binding needs none.
    samplers: Vec<vk::Sampler>,
}

/// An immutable descriptor set.
pub(in crate::gpu) struct Set {
    pub(in crate::gpu) handle: vk::DescriptorSet,
    pool: vk::DescriptorPool,
    resources: Vec<Resource>,
    shape: Arc<Shape>,
}

impl Drop for Shape {
    fn drop(&mut self) {
        // SAFETY: recorded commands keep a clone of a set, which keeps this alive; null handles are ignored.
        unsafe {
            self.samplers.iter().for_each(|s| self.device.destroy_sampler(*s, None));
            self.device.destroy_descriptor_set_layout(self.layout, None);
        }
    }
}

impl Drop for Set {
    fn drop(&mut self) {
        // SAFETY: recorded commands keep a clone; a null handle is ignored.
        unsafe { self.shape.device.destroy_descriptor_pool(self.pool, None) };
    }
}

impl Resource {
    pub(in crate::gpu) fn kind(&self) -> vk::DescriptorType {
        match self {
            Self::Buffer(_) => vk::DescriptorType::STORAGE_BUFFER,
            Self::StorageImage(_) => vk::DescriptorType::STORAGE_IMAGE,
            Self::Texture(_) => vk::DescriptorType::SAMPLED_IMAGE,
            Self::Sampled(..) | Self::Gathered(_) => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::InputAttachment(_) => vk::DescriptorType::INPUT_ATTACHMENT,
            Self::AccelerationStructure(_) => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
        }
    }
}

impl Shape {
    fn new(context: &Context, name: &str, resources: &[Resource]) -> Result<Self> {
        let device = context.device();
        let fail = |r| vk_error("create bindings", name, r);
        let mut shape = Self {
            device: device.clone(),
            layout: vk::DescriptorSetLayout::null(),
            kinds: resources.iter().map(Resource::kind).collect(),
            samplers: Vec::new(),
        };
        let stages = |r: &Resource| match r {
            Resource::InputAttachment(_) => vk::ShaderStageFlags::FRAGMENT,
            _ => vk::ShaderStageFlags::ALL,
        };
        let slots: Vec<_> = (0u32..)
            .zip(resources)
            .map(|(binding, r)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(binding)
                    .descriptor_type(r.kind())
                    .descriptor_count(1)
                    .stage_flags(stages(r))
            })
            .collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&slots);
        // SAFETY: `info` is complete.
        shape.layout = fault::creation(|| unsafe { device.create_descriptor_set_layout(&info, None) }).map_err(fail)?;
        for resource in resources {
            let sampling = match resource {
                Resource::Sampled(_, border) => sampler_info(*border),
                // No linear filter: not every format allows one, and gathers do not filter.
                Resource::Gathered(_) => vk::SamplerCreateInfo::default()
                    .address_mode_u(vk::SamplerAddressMode::CLAMP_TO_EDGE)
                    .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE),
                _ => {
                    shape.samplers.push(vk::Sampler::null());
                    continue;
                }
            };
            // SAFETY: the info is complete and names no extension.
            let sampler = fault::creation(|| unsafe { device.create_sampler(&sampling, None) }).map_err(fail)?;
            shape.samplers.push(sampler);
        }
        Ok(shape)
    }
}

impl Set {
    fn new(shape: &Arc<Shape>, name: &str, resources: Vec<Resource>) -> Result<Self> {
        let device = &shape.device;
        let fail = |r| vk_error("create bindings", name, r);
        let size = |kind: &vk::DescriptorType| vk::DescriptorPoolSize::default().ty(*kind).descriptor_count(1);
        let sizes: Vec<_> = shape.kinds.iter().map(size).collect();
        let mut set = Self {
            handle: vk::DescriptorSet::null(),
            pool: vk::DescriptorPool::null(),
            resources,
            shape: shape.clone(),
        };
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: `info` is complete.
        set.pool = fault::creation(|| unsafe { device.create_descriptor_pool(&info, None) }).map_err(fail)?;
        let layouts = [shape.layout];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(set.pool).set_layouts(&layouts);
        // SAFETY: the pool was created for exactly this set.
        let sets = fault::creation(|| unsafe { device.allocate_descriptor_sets(&info) }).map_err(fail)?;
        set.handle = sets.first().copied().unwrap_or_default();
        // SAFETY: the set is not in use yet, and keeps the resources written into it alive.
        unsafe { write(shape, &set.resources, set.handle, 0) };
        device.set_name(set.handle, name);
        Ok(set)
    }
}

/// Writes `resources` into a set, starting at binding `first`.
///
/// # Safety
/// The set must have matching bindings and must not be in use; its user must keep the resources alive.
unsafe fn write(shape: &Shape, resources: &[Resource], set: vk::DescriptorSet, first: u32) {
    let device = &shape.device;
    for ((binding, resource), sampler) in (first..).zip(resources).zip(&shape.samplers) {
        let write =
            vk::WriteDescriptorSet::default().dst_set(set).dst_binding(binding).descriptor_type(resource.kind());
        let seen = |view| {
            let info = vk::DescriptorImageInfo::default().image_view(view).image_layout(vk::ImageLayout::GENERAL);
            [info.sampler(*sampler)]
        };
        match resource {
            Resource::Buffer(b) => {
                let info = [vk::DescriptorBufferInfo::default().buffer(b.handle()).range(vk::WHOLE_SIZE)];
                // SAFETY: guaranteed by the caller.
                unsafe { device.update_descriptor_sets(&[write.buffer_info(&info)], &[]) };
            }
            Resource::AccelerationStructure(a) => {
                let handles = [a.handle()];
                let mut info =
                    vk::WriteDescriptorSetAccelerationStructureKHR::default().acceleration_structures(&handles);
                // SAFETY: guaranteed by the caller.
                unsafe { device.update_descriptor_sets(&[write.descriptor_count(1).push_next(&mut info)], &[]) };
            }
            Resource::StorageImage(i) => {
                let info = seen(i.storage_view());
                // SAFETY: guaranteed by the caller.
                unsafe { device.update_descriptor_sets(&[write.image_info(&info)], &[]) };
            }
            Resource::Texture(i) | Resource::InputAttachment(i) | Resource::Sampled(i, _) | Resource::Gathered(i) => {
                let info = seen(i.view());
                // SAFETY: guaranteed by the caller; the sampler lives as long as the shape.
                unsafe { device.update_descriptor_sets(&[write.image_info(&info)], &[]) };
            }
        }
    }
}

impl Bindings {
    /// Creates a set in which `resources[i]` is binding i, visible to every shader stage that may use it.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the driver runs out of memory.
    pub fn new(context: &Context, name: &str, resources: &[Resource]) -> Result<Self> {
        let shape = Arc::new(Shape::new(context, name, resources)?);
        let set = Arc::new(Set::new(&shape, name, resources.to_vec())?);
        Ok(Self(Arc::new(Inner { context: context.link(), shape, current: Mutex::new(set), name: name.into() })))
    }

    /// Replaces the buffer at binding `binding`. Every kernel created with this set reads the new buffer in commands
    /// recorded from now on.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the driver runs out of memory.
    pub fn replace(&self, binding: usize, buffer: &Buffer) -> Result<()> {
        let mut current = self.0.current.lock().unwrap_or_else(PoisonError::into_inner);
        let mut resources = current.resources.clone();
        if let Some(resource @ Resource::Buffer(_)) = resources.get_mut(binding) {
            *resource = Resource::Buffer(buffer.clone());
            let old = std::mem::replace(&mut *current, Arc::new(Set::new(&self.0.shape, &self.0.name, resources)?));
            // Running frames may still read, through other sets, resources that only the old set kept alive.
            if let Some(context) = self.0.context.context() {
                context.shared().frames.retire(old);
            }
        }
        Ok(())
    }

    /// Returns the number of descriptors of a kind.
    pub(in crate::gpu) fn count(&self, kind: vk::DescriptorType) -> u32 {
        self.kinds().iter().filter(|k| **k == kind).count() as u32
    }

    /// Returns the kind of each binding.
    pub(in crate::gpu) fn kinds(&self) -> &[vk::DescriptorType] {
        &self.0.shape.kinds
    }

    /// Writes the current resources into the caller's set: binding 0 goes to `first_binding`, and so on. Samplers are
    /// written with their images.
    ///
    /// # Safety
    /// `set` must belong to this device and have bindings of these kinds from `first_binding` on; no pending command may use them; and
    /// these bindings, which keep the resources alive, must outlive the commands that do.
    pub unsafe fn write_into(&self, set: vk::DescriptorSet, first_binding: u32) {
        // SAFETY: guaranteed by the caller.
        unsafe { write(&self.0.shape, &self.current().resources, set, first_binding) }
    }

    pub(in crate::gpu) fn layout(&self) -> vk::DescriptorSetLayout {
        self.0.shape.layout
    }

    /// Returns the current set.
    pub(in crate::gpu) fn current(&self) -> Arc<Set> {
        self.0.current.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Returns the current descriptor set, for the caller's own commands. A build that grows a buffer may replace the set.
    pub fn set(&self) -> vk::DescriptorSet {
        self.current().handle
    }
}

fn sampler_info(border: Border) -> vk::SamplerCreateInfo<'static> {
    let outside = vk::SamplerAddressMode::CLAMP_TO_BORDER;
    vk::SamplerCreateInfo::default()
        .mag_filter(vk::Filter::LINEAR)
        .min_filter(vk::Filter::LINEAR)
        .address_mode_u(outside)
        .address_mode_v(outside)
        .address_mode_w(outside)
        .border_color(match border {
            Border::Zero => vk::BorderColor::FLOAT_TRANSPARENT_BLACK,
            Border::One => vk::BorderColor::FLOAT_OPAQUE_WHITE,
        })
}
