//! Acceleration structures over triangles and boxes, for ray queries.

use crate::gpu::device::device_owner::Device;
use crate::gpu::resource::KeepAlive;
use crate::gpu::testing::fault;
use crate::gpu::{Buffer, Context, Memory, Pass, vk_error};
use crate::{Error, Result};
use ash::{khr, vk};
use std::sync::Arc;

/// Alignment of scratch memory, in bytes: the largest minAccelerationStructureScratchOffsetAlignment that Vulkan allows.
const SCRATCH_ALIGNMENT: u64 = 256;

/// Size of a box in bytes: its minimum and maximum corners.
pub const BOX_BYTES: u64 = 24;

/// A structure over triangles or boxes, or over an instance of another one. Clones share it; the last one frees it.
#[derive(Clone)]
pub struct AccelerationStructure(Arc<Inner>);

struct Inner {
    device: Device,
    handle: vk::AccelerationStructureKHR,
    storage: Buffer,
    scratch: Buffer,
    over: Over,
}

/// The geometry that a structure is built from.
enum Over {
    Triangles { corners: Buffer, indices: Buffer, count: u32 },
    Boxes { boxes: Buffer, count: u32 },
    Instance { instance: Buffer, bottom: AccelerationStructure },
}

impl Drop for Inner {
    fn drop(&mut self) {
        if let Some(device) = self.device.acceleration() {
            // SAFETY: recorded commands and sets keep a clone, so the device no longer uses it; null handles are ignored.
            unsafe { device.destroy_acceleration_structure(self.handle, None) };
        }
    }
}

impl Over {
    fn level(&self) -> vk::AccelerationStructureTypeKHR {
        match self {
            Self::Triangles { .. } | Self::Boxes { .. } => vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL,
            Self::Instance { .. } => vk::AccelerationStructureTypeKHR::TOP_LEVEL,
        }
    }

    /// Returns the number of triangles, boxes or instances.
    fn count(&self) -> u32 {
        match self {
            Self::Triangles { count, .. } | Self::Boxes { count, .. } => *count,
            Self::Instance { .. } => 1,
        }
    }

    fn geometry(&self) -> vk::AccelerationStructureGeometryKHR<'static> {
        let geometry = vk::AccelerationStructureGeometryKHR::default();
        let at = |buffer: &Buffer| vk::DeviceOrHostAddressConstKHR { device_address: buffer.address() };
        match self {
            Self::Triangles { corners, indices, count } => {
                let triangles = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
                    .vertex_format(vk::Format::R32G32B32_SFLOAT)
                    .vertex_data(at(corners))
                    .vertex_stride(12)
                    .max_vertex((corners.bytes() / 12).min(4 * u64::from(*count)).saturating_sub(1) as u32)
                    .index_type(vk::IndexType::UINT32)
                    .index_data(at(indices));
                let geometry = geometry.geometry_type(vk::GeometryTypeKHR::TRIANGLES);
                geometry.geometry(vk::AccelerationStructureGeometryDataKHR { triangles })
            }
            Self::Boxes { boxes, .. } => {
                let aabbs = vk::AccelerationStructureGeometryAabbsDataKHR::default().data(at(boxes)).stride(BOX_BYTES);
                // A look-up adds up every box that its ray hits, so each must be reported only once.
                let geometry = geometry.flags(vk::GeometryFlagsKHR::NO_DUPLICATE_ANY_HIT_INVOCATION);
                let geometry = geometry.geometry_type(vk::GeometryTypeKHR::AABBS);
                geometry.geometry(vk::AccelerationStructureGeometryDataKHR { aabbs })
            }
            Self::Instance { instance, .. } => {
                let instances = vk::AccelerationStructureGeometryInstancesDataKHR::default().data(at(instance));
                let geometry = geometry.geometry_type(vk::GeometryTypeKHR::INSTANCES);
                geometry.geometry(vk::AccelerationStructureGeometryDataKHR { instances })
            }
        }
    }
}

/// Returns the info for building `geometries` into a structure optimized for tracing.
fn build_info<'a>(
    over: &Over,
    geometries: &'a [vk::AccelerationStructureGeometryKHR<'a>],
) -> vk::AccelerationStructureBuildGeometryInfoKHR<'a> {
    vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(over.level())
        .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(geometries)
}

impl AccelerationStructure {
    /// Creates a structure over `count` triangles. `corners` holds tightly packed positions of three floats each;
    /// `indices` holds three indices per triangle. Every build reads both.
    ///
    /// # Errors
    /// [`Error::Refused`] if the device has no ray queries, [`Error::Gpu`] if memory runs out.
    pub fn bottom(context: &Context, name: &str, corners: &Buffer, indices: &Buffer, count: u32) -> Result<Self> {
        Self::new(context, name, Over::Triangles { corners: corners.clone(), indices: indices.clone(), count })
    }

    /// Creates a structure over `count` tightly packed boxes, each a minimum and a maximum corner. A box whose first
    /// number is NaN is inactive. Every build reads the boxes.
    ///
    /// # Errors
    /// Same as [`AccelerationStructure::bottom`].
    pub fn boxes(context: &Context, name: &str, boxes: &Buffer, count: u32) -> Result<Self> {
        Self::new(context, name, Over::Boxes { boxes: boxes.clone(), count })
    }

    /// Creates a structure over one instance of `bottom`, without a transform.
    ///
    /// # Errors
    /// Same as [`AccelerationStructure::bottom`].
    pub fn top(context: &Context, name: &str, bottom: &Self) -> Result<Self> {
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(bottom.handle());
        // SAFETY: the structure exists, and the new one keeps it alive.
        let address = unsafe { loader(context)?.get_acceleration_structure_device_address(&info) };
        // VkAccelerationStructureInstanceKHR: three rows of the identity matrix; index 0, mask 0xff; offset 0, no
        // culling of triangles; the address, low half first.
        let (one, sides) = (1f32.to_bits(), vk::GeometryInstanceFlagsKHR::TRIANGLE_FACING_CULL_DISABLE.as_raw());
        let words = [
            [one, 0, 0, 0],
            [0, one, 0, 0],
            [0, 0, one, 0],
            [0xff << 24, sides << 24, address as u32, (address >> 32) as u32],
        ];
        let instance = Buffer::with_data(context, name, &words)?;
        Self::new(context, name, Over::Instance { instance, bottom: bottom.clone() })
    }

    fn new(context: &Context, name: &str, over: Over) -> Result<Self> {
        let loader = loader(context)?;
        let geometries = [over.geometry()];
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        let on_device = vk::AccelerationStructureBuildTypeKHR::DEVICE;
        // SAFETY: `over` keeps the buffers that the geometry points to; there is one count per geometry.
        unsafe {
            let info = build_info(&over, &geometries);
            loader.get_acceleration_structure_build_sizes(on_device, &info, &[over.count()], &mut sizes);
        }
        let address = vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        let held = address | vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR;
        let bytes = sizes.acceleration_structure_size.max(SCRATCH_ALIGNMENT);
        let storage = Buffer::with_usage(context, name, bytes, Memory::Device, held)?;
        let used = address | vk::BufferUsageFlags::STORAGE_BUFFER;
        let bytes = sizes.build_scratch_size + SCRATCH_ALIGNMENT;
        let scratch = Buffer::with_usage(context, "scratch", bytes, Memory::Device, used)?;
        let info = vk::AccelerationStructureCreateInfoKHR::default()
            .buffer(storage.handle())
            .size(storage.bytes())
            .ty(over.level());
        // SAFETY: the buffer was created for this structure, is large enough, and is kept beside it.
        let handle = fault::creation(|| unsafe { loader.create_acceleration_structure(&info, None) })
            .map_err(|r| vk_error("create acceleration structure", name, r))?;
        context.device().set_name(handle, name);
        Ok(Self(Arc::new(Inner { device: context.device().clone(), handle, storage, scratch, over })))
    }

    /// Returns the size in bytes of the structure itself, which ray queries read.
    pub fn bytes(&self) -> u64 {
        self.0.storage.bytes()
    }

    /// Returns the bytes of scratch memory that a build needs in addition to its inputs.
    pub fn scratch_bytes(&self) -> u64 {
        self.0.scratch.bytes()
    }

    pub(in crate::gpu) fn kept(&self) -> KeepAlive {
        self.0.clone()
    }

    pub(in crate::gpu) fn handle(&self) -> vk::AccelerationStructureKHR {
        self.0.handle
    }
}

/// Returns the functions of the extension.
fn loader(context: &Context) -> Result<&khr::acceleration_structure::Device> {
    context.device().acceleration().ok_or_else(|| Error::Refused("rayQuery".into()))
}

impl Pass<'_, '_> {
    /// Builds a structure from the current content of its buffers. A structure over an instance must be built after the
    /// instance's own structure.
    pub fn build(&mut self, structure: &AccelerationStructure) {
        let inner = &structure.0;
        let Some(loader) = inner.device.acceleration() else { return };
        let geometries = [inner.over.geometry()];
        let scratch = inner.scratch.address().next_multiple_of(SCRATCH_ALIGNMENT);
        let info = build_info(&inner.over, &geometries)
            .dst_acceleration_structure(inner.handle)
            .scratch_data(vk::DeviceOrHostAddressKHR { device_address: scratch });
        let range = [vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(inner.over.count())];
        // SAFETY: the structure and its buffers are kept alive; their sizes were queried for the same geometry.
        unsafe { loader.cmd_build_acceleration_structures(self.commands.buffer, &[info], &[&range]) };
        if let Over::Instance { bottom, .. } = &inner.over {
            self.commands.keep(bottom.kept());
        }
        self.commands.keep(structure.kept());
    }
}
