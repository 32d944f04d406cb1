//! Descriptor sets: a list of resources, binding number = place in the list.

use super::{AccelerationStructure, Buffer, Context, Image, fault, vk_error};
use crate::Result;
use ash::vk;
use std::sync::{Arc, Mutex, PoisonError};

/// Something a shader can be given.
#[derive(Clone)]
pub enum Resource {
    /// `buffer` in GLSL.
    Buffer(Buffer),
    /// `image2D`, `uimage2D` in GLSL.
    StorageImage(Image),
    /// `texture2D` in GLSL, read with `texelFetch`.
    Texture(Image),
    /// `sampler2D`, `sampler3D` in GLSL, linear, with what lies outside.
    Sampled(Image, Border),
    /// `sampler2D` in GLSL, read with `texelFetch` and `textureGather`, at whose edges it goes on as it ends.
    Gathered(Image),
    /// `subpassInput` in GLSL, for fragment shaders alone.
    InputAttachment(Image),
    /// `accelerationStructureEXT` in GLSL.
    AccelerationStructure(AccelerationStructure),
}

/// What a sampler finds outside its image, in every channel.
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
    context: Context,
    layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    samplers: Vec<vk::Sampler>,
    /// Kept alive as long as a recorded command may use the set.
    resources: Mutex<Vec<Resource>>,
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: recorded commands keep a clone; null handles are ignored.
        unsafe {
            self.context.device().destroy_descriptor_pool(self.pool, None);
            self.samplers.iter().for_each(|s| self.context.device().destroy_sampler(*s, None));
            self.context.device().destroy_descriptor_set_layout(self.layout, None);
        }
    }
}

impl Resource {
    pub(super) fn kind(&self) -> vk::DescriptorType {
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

impl Bindings {
    /// A set in which `resources[i]` is binding i, visible to every stage that may have it.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the driver runs out of memory.
    pub fn new(context: &Context, name: &str, resources: &[Resource]) -> Result<Self> {
        let device = context.device();
        let fail = |r| vk_error("create bindings", name, r);
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
        let sizes: Vec<_> =
            resources.iter().map(|r| vk::DescriptorPoolSize::default().ty(r.kind()).descriptor_count(1)).collect();
        let mut inner = Inner {
            context: context.clone(),
            layout: vk::DescriptorSetLayout::null(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            samplers: Vec::new(),
            resources: Mutex::new(resources.to_vec()),
        };
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&slots);
        // SAFETY: `info` is complete.
        inner.layout = fault::creation(|| unsafe { device.create_descriptor_set_layout(&info, None) }).map_err(fail)?;
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: as above.
        inner.pool = fault::creation(|| unsafe { device.create_descriptor_pool(&info, None) }).map_err(fail)?;
        let layouts = [inner.layout];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(inner.pool).set_layouts(&layouts);
        // SAFETY: the pool was made for exactly this set.
        let sets = fault::creation(|| unsafe { device.allocate_descriptor_sets(&info) }).map_err(fail)?;
        inner.set = sets.first().copied().unwrap_or_default();
        for (binding, resource) in (0u32..).zip(resources) {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(inner.set)
                .dst_binding(binding)
                .descriptor_type(resource.kind());
            let seen =
                |view| [vk::DescriptorImageInfo::default().image_view(view).image_layout(vk::ImageLayout::GENERAL)];
            let image = |i: &Image| seen(i.view());
            match resource {
                Resource::Buffer(b) => {
                    let info = [vk::DescriptorBufferInfo::default().buffer(b.handle()).range(vk::WHOLE_SIZE)];
                    // SAFETY: the set is not in use yet, and the buffer lives as long as the set.
                    unsafe { device.update_descriptor_sets(&[write.buffer_info(&info)], &[]) };
                }
                Resource::AccelerationStructure(a) => {
                    let handles = [a.handle()];
                    let mut info =
                        vk::WriteDescriptorSetAccelerationStructureKHR::default().acceleration_structures(&handles);
                    // SAFETY: as above.
                    unsafe { device.update_descriptor_sets(&[write.descriptor_count(1).push_next(&mut info)], &[]) };
                }
                Resource::Sampled(i, _) | Resource::Gathered(i) => {
                    // Not every format may be filtered; what is gathered is not.
                    let sampling = match resource {
                        Resource::Sampled(_, border) => sampler_info(*border),
                        _ => vk::SamplerCreateInfo::default()
                            .address_mode_u(vk::SamplerAddressMode::CLAMP_TO_EDGE)
                            .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE),
                    };
                    // SAFETY: the info is complete and names no extension.
                    let sampler =
                        fault::creation(|| unsafe { device.create_sampler(&sampling, None) }).map_err(fail)?;
                    inner.samplers.push(sampler);
                    let info = image(i).map(|i| i.sampler(sampler));
                    // SAFETY: as above; the sampler lives as long as the set.
                    unsafe { device.update_descriptor_sets(&[write.image_info(&info)], &[]) };
                }
                Resource::StorageImage(i) => {
                    let info = seen(i.storage_view());
                    // SAFETY: as above.
                    unsafe { device.update_descriptor_sets(&[write.image_info(&info)], &[]) };
                }
                Resource::Texture(i) | Resource::InputAttachment(i) => {
                    let info = image(i);
                    // SAFETY: as above.
                    unsafe { device.update_descriptor_sets(&[write.image_info(&info)], &[]) };
                }
            }
        }
        context.set_name(inner.set, name);
        Ok(Self(Arc::new(inner)))
    }

    /// Puts another buffer where binding `binding` has one; every kernel that was made with the set reads it from now on.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] while this thread records commands, which may use the set.
    pub fn replace(&self, binding: usize, buffer: &Buffer) -> Result<()> {
        self.0.context.shared().recorders.while_idle(&format!("binding {binding}"), || {
            let mut resources = self.0.resources.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(resource @ Resource::Buffer(_)) = resources.get_mut(binding) {
                let info = [vk::DescriptorBufferInfo::default().buffer(buffer.handle()).range(vk::WHOLE_SIZE)];
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(self.0.set)
                    .dst_binding(binding as u32)
                    .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                    .buffer_info(&info);
                // SAFETY: nothing is recorded and nothing runs, and the buffer lives as long as the set names it.
                unsafe { self.0.context.device().update_descriptor_sets(&[write], &[]) };
                *resource = Resource::Buffer(buffer.clone());
            }
        })
    }

    /// Its descriptors of a kind.
    pub(super) fn count(&self, kind: vk::DescriptorType) -> u32 {
        self.kinds().into_iter().filter(|k| *k == kind).count() as u32
    }

    /// The kind of each binding.
    pub(super) fn kinds(&self) -> Vec<vk::DescriptorType> {
        self.0.resources.lock().unwrap_or_else(PoisonError::into_inner).iter().map(Resource::kind).collect()
    }

    /// Its resources as they are now, each with its sampler: null for one that has none.
    pub(super) fn parts(&self) -> Vec<(Resource, vk::Sampler)> {
        let mut samplers = self.0.samplers.iter().copied();
        let mut sampler = |resource: &Resource| match resource {
            Resource::Sampled(..) | Resource::Gathered(_) => samplers.next().unwrap_or_default(),
            _ => vk::Sampler::null(),
        };
        let resources = self.0.resources.lock().unwrap_or_else(PoisonError::into_inner);
        resources.iter().map(|resource| (resource.clone(), sampler(resource))).collect()
    }

    pub(super) fn device(&self) -> &ash::Device {
        self.0.context.device()
    }

    pub(super) fn layout(&self) -> vk::DescriptorSetLayout {
        self.0.layout
    }

    /// The descriptor set as it is now, for commands of the caller's own: a build that grows may put another in its place.
    pub fn set(&self) -> vk::DescriptorSet {
        self.0.set
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
