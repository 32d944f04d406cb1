//! Owned images. They stay in the GENERAL layout for their whole life.

use crate::gpu::device::context::Link;
use crate::gpu::device::device_owner::Device;
use crate::gpu::record::pending::Step;
use crate::gpu::resource::KeepAlive;
use crate::gpu::testing::fault;
use crate::gpu::{Buffer, Context, Memory, vk_error};
use crate::{Error, Less, Result, WayOut};
use ash::vk;
use bytemuck::Pod;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::Arc;

/// How an image is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageUse {
    /// Written, read and fetched by shaders (`imageLoad`, `imageAtomic…`, `texelFetch`).
    Storage,
    /// R32_UINT: written by shaders as the bits of floats (`imageAtomic…` on `r32ui`), then fetched by shaders as floats.
    FloatBits,
    /// Drawn to, then fetched by shaders.
    Color,
    /// Drawn to and written by shaders, then fetched by them.
    StoredColor,
    /// Drawn to in [`crate::gpu::OrderedAttachments`], then fetched by shaders.
    OrderedColor,
    /// A depth buffer that shaders may fetch from.
    Depth,
    /// A 3D image: written, read and sampled by shaders.
    Volume,
    /// Like [`ImageUse::Volume`], but also drawn to layer by layer.
    DrawnVolume,
}

/// A 2D or 3D image. Clones share it; the last one frees it.
#[derive(Clone)]
pub struct Image(Arc<Inner>);

struct Inner {
    device: Device,
    context: Link,
    handle: vk::Image,
    view: vk::ImageView,
    /// For a volume that is drawn to, a view of its layers as an array of 2D images; otherwise null.
    layers: vk::ImageView,
    /// For [`ImageUse::FloatBits`], the integer view that shaders write; otherwise null.
    bits: vk::ImageView,
    allocation: Option<Allocation>,
    name: String,
    size: [u32; 3],
    texel_bytes: u32,
    aspect: vk::ImageAspectFlags,
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: recorded commands keep a clone, so the device no longer uses the image; null handles are ignored.
        unsafe {
            self.device.destroy_image_view(self.bits, None);
            self.device.destroy_image_view(self.layers, None);
            self.device.destroy_image_view(self.view, None);
            self.device.destroy_image(self.handle, None);
        }
        if let Some(allocation) = self.allocation.take() {
            self.device.free(allocation);
        }
    }
}

/// Returns the bytes per texel; `None` for an unlisted format, which no image can have.
fn texel_bytes(format: vk::Format) -> Option<u32> {
    Some(match format {
        vk::Format::R8_UNORM => 1,
        vk::Format::R16_SFLOAT | vk::Format::D16_UNORM => 2,
        vk::Format::R32_UINT | vk::Format::R32_SFLOAT | vk::Format::D32_SFLOAT | vk::Format::R8G8B8A8_UNORM => 4,
        vk::Format::R32G32_UINT | vk::Format::R32G32_SFLOAT | vk::Format::R16G16B16A16_SFLOAT => 8,
        vk::Format::R32G32B32A32_SFLOAT => 16,
        _ => return None,
    })
}

impl Image {
    /// Creates an image of `size` texels with undefined content.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the size exceeds the device's limit or memory runs out.
    pub fn new(context: &Context, name: &str, format: vk::Format, size: [u32; 2], usage: ImageUse) -> Result<Self> {
        Self::with_depth(context, name, format, [size[0], size[1], 1], usage)
    }

    /// Creates a 3D image of `size` texels with undefined content.
    ///
    /// # Errors
    /// Same as [`Image::new`]; [`Error::Gpu`] if the volume is drawn to and has more layers than a render allows.
    pub fn volume(context: &Context, name: &str, format: vk::Format, size: [u32; 3], drawn: bool) -> Result<Self> {
        let limit = context.features().max_framebuffer_layers;
        if drawn && size[2] > limit {
            return Err(Error::Gpu {
                operation: "create image",
                name: name.into(),
                cause: format!("{} layers, and this device draws to at most {limit} (maxFramebufferLayers)", size[2])
                    .into(),
                way_out: WayOut::Less(&[Less::Slices, Less::Lights]),
            });
        }
        Self::with_depth(context, name, format, size, if drawn { ImageUse::DrawnVolume } else { ImageUse::Volume })
    }

    fn with_depth(context: &Context, name: &str, format: vk::Format, size: [u32; 3], usage: ImageUse) -> Result<Self> {
        let Some(texel_bytes) = texel_bytes(format) else {
            return Err(Error::Gpu {
                operation: "create image",
                name: name.into(),
                cause: format!("how many bytes a texel of {format:?} has is not known here").into(),
                way_out: "report this as a bug".into(),
            });
        };
        let is_volume = matches!(usage, ImageUse::Volume | ImageUse::DrawnVolume);
        let features = context.features();
        let (name_of_limit, limit) = match is_volume {
            true => ("maxImageDimension3D", features.max_image_dimension_3d),
            false => ("maxImageDimension2D", features.max_image_dimension_2d),
        };
        if size.iter().any(|s| *s == 0 || *s > limit) {
            let [width, height, depth] = size;
            let texels =
                if is_volume { format!("{width} × {height} × {depth}") } else { format!("{width} × {height}") };
            return Err(Error::Gpu {
                operation: "create image",
                name: name.into(),
                cause: format!("{texels} texels, and this device takes 1 to {limit} per side ({name_of_limit})").into(),
                way_out: if is_volume {
                    WayOut::Less(&[Less::Map, Less::Slices, Less::Lights])
                } else {
                    "use a size in that range".into()
                },
            });
        }
        let copies = vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
        let (flags, aspect) = match usage {
            ImageUse::Storage | ImageUse::FloatBits => {
                (vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::SAMPLED, vk::ImageAspectFlags::COLOR)
            }
            ImageUse::Color => {
                (vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED, vk::ImageAspectFlags::COLOR)
            }
            ImageUse::StoredColor => (
                vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::SAMPLED,
                vk::ImageAspectFlags::COLOR,
            ),
            ImageUse::OrderedColor => (
                vk::ImageUsageFlags::COLOR_ATTACHMENT
                    | vk::ImageUsageFlags::INPUT_ATTACHMENT
                    | vk::ImageUsageFlags::SAMPLED,
                vk::ImageAspectFlags::COLOR,
            ),
            ImageUse::Depth => (
                vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED,
                vk::ImageAspectFlags::DEPTH,
            ),
            ImageUse::Volume => {
                (vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::SAMPLED, vk::ImageAspectFlags::COLOR)
            }
            ImageUse::DrawnVolume => (
                vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::SAMPLED,
                vk::ImageAspectFlags::COLOR,
            ),
        };
        let (image_type, view_type) = if is_volume {
            (vk::ImageType::TYPE_3D, vk::ImageViewType::TYPE_3D)
        } else {
            (vk::ImageType::TYPE_2D, vk::ImageViewType::TYPE_2D)
        };
        let drawn_volume = usage == ImageUse::DrawnVolume;
        let create = match usage {
            ImageUse::DrawnVolume => vk::ImageCreateFlags::TYPE_2D_ARRAY_COMPATIBLE,
            ImageUse::FloatBits => vk::ImageCreateFlags::MUTABLE_FORMAT,
            _ => vk::ImageCreateFlags::empty(),
        };
        let info = vk::ImageCreateInfo::default()
            .flags(create)
            .image_type(image_type)
            .format(format)
            .extent(vk::Extent3D { width: size[0], height: size[1], depth: size[2] })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(flags | copies);
        let device = context.device();
        // SAFETY: `info` is complete and within the limits checked above.
        let handle = fault::creation(|| unsafe { device.create_image(&info, None) })
            .map_err(|r| vk_error("create image", name, r))?;
        let mut inner = Inner {
            device: device.clone(),
            context: context.link(),
            handle,
            view: vk::ImageView::null(),
            layers: vk::ImageView::null(),
            bits: vk::ImageView::null(),
            allocation: None,
            name: name.into(),
            size,
            texel_bytes,
            aspect,
        };
        // SAFETY: the image was just created.
        let requirements = unsafe { device.get_image_memory_requirements(handle) };
        let allocation = device.allocate(&AllocationCreateDesc {
            name,
            requirements,
            location: MemoryLocation::GpuOnly,
            linear: false,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        })?;
        // SAFETY: the allocator returned memory and offset for this image's requirements; the image is bound once.
        let bound = unsafe { device.bind_image_memory(handle, allocation.memory(), allocation.offset()) };
        inner.allocation = Some(allocation);
        bound.map_err(|r| vk_error("bind image", name, r))?;
        let range = vk::ImageSubresourceRange::default().aspect_mask(aspect).level_count(1).layer_count(1);
        let fetched = if usage == ImageUse::FloatBits { vk::Format::R32_SFLOAT } else { format };
        let info = vk::ImageViewCreateInfo::default()
            .image(handle)
            .view_type(view_type)
            .format(fetched)
            .subresource_range(range);
        // SAFETY: the image is bound, and the view has its format or, for bits of floats, another format of the same size.
        inner.view = fault::creation(|| unsafe { device.create_image_view(&info, None) })
            .map_err(|r| vk_error("create view of", name, r))?;
        if drawn_volume {
            let range = range.layer_count(size[2]);
            let info = info.view_type(vk::ImageViewType::TYPE_2D_ARRAY).subresource_range(range);
            // SAFETY: the image is bound, is three-dimensional, and was created to be viewed as an array of 2D images.
            inner.layers = fault::creation(|| unsafe { device.create_image_view(&info, None) })
                .map_err(|r| vk_error("create view of", name, r))?;
        }
        if usage == ImageUse::FloatBits {
            // SAFETY: the image is bound and the view matches it.
            inner.bits = fault::creation(|| unsafe { device.create_image_view(&info.format(format), None) })
                .map_err(|r| vk_error("create view of", name, r))?;
        }
        device.set_name(handle, name);
        let image = Self(Arc::new(inner));
        context.shared().pending.push(Step::Layout(image.clone()));
        Ok(image)
    }

    /// Reads all texels, row by row, and layer by layer for a volume. Waits for a copy.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out or `T` does not have the size of a texel, [`Error::Refused`] on an adopted device.
    pub fn read<T: Pod>(&self) -> Result<Vec<T>> {
        let texels = self.0.size.iter().map(|s| *s as usize).product();
        let error = |cause| {
            let (name, way_out) = (self.0.name.clone(), "report this as a bug".into());
            Error::Gpu { operation: "read image", name, cause, way_out }
        };
        if size_of::<T>() != self.0.texel_bytes as usize {
            return Err(error(format!("a texel has {} bytes, not {}", self.0.texel_bytes, size_of::<T>()).into()));
        }
        let context = self.0.context.context().ok_or_else(|| error("its context is gone".into()))?;
        // Fails before anything is created for the copy.
        context.queue()?;
        let staging = Buffer::new(&context, "readback", self.bytes(), Memory::Readback)?;
        context.submit(|commands| commands.pass("readback", |pass| pass.copy_image(self, &staging)))?;
        staging.read(texels)
    }

    /// Returns width and height, in texels.
    pub fn size(&self) -> [u32; 2] {
        [self.0.size[0], self.0.size[1]]
    }

    /// Returns the number of layers of a volume; 1 for a 2D image.
    pub fn depth(&self) -> u32 {
        self.0.size[2]
    }

    /// Returns the size in bytes, without padding.
    pub fn bytes(&self) -> u64 {
        self.0.size.iter().map(|s| u64::from(*s)).product::<u64>() * u64::from(self.0.texel_bytes)
    }

    /// Returns the Vulkan handle, valid while a clone of the image lives. The image is in VK_IMAGE_LAYOUT_GENERAL.
    pub fn handle(&self) -> vk::Image {
        self.0.handle
    }

    pub(in crate::gpu) fn kept(&self) -> KeepAlive {
        self.0.clone()
    }

    /// Returns a view of the whole image, for shaders that read it.
    pub fn view(&self) -> vk::ImageView {
        self.0.view
    }

    /// Returns the view that renders draw to.
    pub(in crate::gpu) fn attachment_view(&self) -> vk::ImageView {
        if self.0.layers == vk::ImageView::null() { self.0.view } else { self.0.layers }
    }

    /// Returns the view that shaders write.
    pub(in crate::gpu) fn storage_view(&self) -> vk::ImageView {
        if self.0.bits == vk::ImageView::null() { self.0.view } else { self.0.bits }
    }

    pub(in crate::gpu) fn aspect(&self) -> vk::ImageAspectFlags {
        self.0.aspect
    }
}
