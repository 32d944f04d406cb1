//! Owned buffers.

use crate::gpu::device::context::Link;
use crate::gpu::device::device_owner::Device;
use crate::gpu::record::pending::Step;
use crate::gpu::resource::KeepAlive;
use crate::gpu::testing::fault;
use crate::gpu::{Commands, Context, vk_error};
use crate::{Error, Less, Result, WayOut};
use ash::vk;
use bytemuck::Pod;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::{Arc, Mutex, PoisonError};

/// Alignment of every buffer, in bytes, so that each begins at a GPU cache line. Some drivers require only 16 bytes; a texel's curve may
/// then straddle two cache lines, and the pass avsm.insert took 7 % longer on the H200.
const ALIGNMENT: u64 = 256;

/// Where a buffer lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// On the device; read and written through a staging copy.
    Device,
    /// Visible to the host, which writes it.
    Upload,
    /// Visible to the host, which reads it.
    Readback,
}

/// A buffer of bytes: storage, copies and indirect arguments. Clones share it; the last one frees it.
#[derive(Clone)]
pub struct Buffer(Arc<Inner>);

struct Inner {
    device: Device,
    context: Link,
    handle: vk::Buffer,
    /// `None` if the buffer is the caller's.
    allocation: Mutex<Option<Allocation>>,
    name: String,
    bytes: u64,
    memory: Memory,
    /// Whether the caller created the buffer and destroys it.
    is_theirs: bool,
}

impl Drop for Inner {
    fn drop(&mut self) {
        if self.is_theirs {
            return;
        }
        // SAFETY: recorded commands keep a clone, so the device no longer uses the buffer.
        unsafe { self.device.destroy_buffer(self.handle, None) };
        if let Some(allocation) = self.allocation.get_mut().unwrap_or_else(PoisonError::into_inner).take() {
            self.device.free(allocation);
        }
    }
}

impl Buffer {
    /// Creates a buffer of `bytes` bytes (at least 4, so that an empty scene needs no special case) with undefined content.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device has too little memory or `bytes` exceeds its largest storage buffer.
    pub fn new(context: &Context, name: &str, bytes: u64, memory: Memory) -> Result<Self> {
        let bytes = bytes.max(4).next_multiple_of(4);
        let limit = u64::from(context.features().max_storage_buffer_range);
        if bytes > limit {
            return Err(Error::Gpu {
                operation: "create buffer",
                name: name.into(),
                cause: format!("{bytes} bytes, and this device binds at most {limit} (maxStorageBufferRange)").into(),
                way_out: WayOut::Less(&[Less::Map, Less::Casters, Less::OtherDevice]),
            });
        }
        let mut usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST
            | vk::BufferUsageFlags::INDIRECT_BUFFER;
        if context.features().ray_query {
            usage |= vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR
                | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        }
        Self::with_usage(context, name, bytes, memory, usage)
    }

    /// Creates a buffer of any usage, not only storage.
    pub(in crate::gpu) fn with_usage(
        context: &Context,
        name: &str,
        bytes: u64,
        memory: Memory,
        usage: vk::BufferUsageFlags,
    ) -> Result<Self> {
        let device = context.device();
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        // SAFETY: `info` is complete.
        let handle = fault::creation(|| unsafe { device.create_buffer(&info, None) })
            .map_err(|r| vk_error("create buffer", name, r))?;
        let inner = Inner {
            device: device.clone(),
            context: context.link(),
            handle,
            allocation: Mutex::new(None),
            name: name.into(),
            bytes,
            memory,
            is_theirs: false,
        };
        // SAFETY: the buffer was just created.
        let mut requirements = unsafe { device.get_buffer_memory_requirements(handle) };
        requirements.alignment = requirements.alignment.max(ALIGNMENT);
        let allocation = device.allocate(&AllocationCreateDesc {
            name,
            requirements,
            location: match memory {
                Memory::Device => MemoryLocation::GpuOnly,
                Memory::Upload => MemoryLocation::CpuToGpu,
                Memory::Readback => MemoryLocation::GpuToCpu,
            },
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        })?;
        // SAFETY: the allocator returned memory and offset for this buffer's requirements.
        let (memory_handle, offset) = (unsafe { allocation.memory() }, allocation.offset());
        *inner.allocation.lock().unwrap_or_else(PoisonError::into_inner) = Some(allocation);
        // SAFETY: as above; the buffer is bound once.
        unsafe { device.bind_buffer_memory(handle, memory_handle, offset) }
            .map_err(|r| vk_error("bind buffer", name, r))?;
        device.set_name(handle, name);
        Ok(Self(Arc::new(inner)))
    }

    /// Wraps the caller's buffer of `bytes` bytes in device memory. Dropping the last clone leaves the caller's buffer
    /// untouched.
    ///
    /// # Errors
    /// [`Error::Gpu`] if `bytes` exceeds the device's largest storage buffer.
    ///
    /// # Safety
    /// The buffer must belong to the context's device, have at least `bytes` bytes, and stay valid until all frames that use it have
    /// finished and everything created with it is gone. It must have been created with the usage it needs: as a storage buffer at least,
    /// and for copies from and to it if it is read or written.
    pub unsafe fn adopt(context: &Context, name: &str, handle: vk::Buffer, bytes: u64) -> Result<Self> {
        let buffer = Self(Arc::new(Inner {
            device: context.device().clone(),
            context: context.link(),
            handle,
            allocation: Mutex::new(None),
            name: name.into(),
            bytes,
            memory: Memory::Device,
            is_theirs: true,
        }));
        let limit = u64::from(context.features().max_storage_buffer_range);
        if bytes <= limit {
            return Ok(buffer);
        }
        Err(buffer.error("adopt", format!("{bytes} bytes, and this device binds at most {limit}")))
    }

    /// Creates a device buffer of `bytes` bytes, all 0.
    ///
    /// # Errors
    /// Same as [`Buffer::new`].
    pub fn zeroed(context: &Context, name: &str, bytes: u64) -> Result<Self> {
        let buffer = Self::new(context, name, bytes, Memory::Device)?;
        context.shared().pending.push(Step::Zero(buffer.clone()));
        Ok(buffer)
    }

    /// Creates a device buffer that holds `data`.
    ///
    /// # Errors
    /// Same as [`Buffer::new`].
    pub fn with_data<T: Pod>(context: &Context, name: &str, data: &[T]) -> Result<Self> {
        let buffer = Self::new(context, name, size_of_val(data) as u64, Memory::Device)?;
        buffer.write(data)?;
        Ok(buffer)
    }

    /// Returns whether both are clones of the same buffer.
    pub fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// Writes `data` to the start of the buffer. For a buffer in device memory, a copy is recorded later: on an adopted device, into the
    /// caller's command buffer before the next pass; on a device that was opened here, it runs before the next submission.
    ///
    /// # Errors
    /// [`Error::Gpu`] if `data` is larger than the buffer or memory runs out.
    pub fn write<T: Pod>(&self, data: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        if bytes.len() as u64 > self.0.bytes {
            return Err(self.error("write", format!("{} bytes into {}", bytes.len(), self.0.bytes)));
        }
        if bytes.is_empty() {
            return Ok(());
        }
        if self.0.memory == Memory::Device {
            let context = self.context()?;
            let from = Self::new(&context, "staging", bytes.len() as u64, Memory::Upload)?;
            from.write(bytes)?;
            let step = Step::Copy { from, to: self.clone(), bytes: bytes.len() as u64 };
            context.shared().pending.push(step);
            return Ok(());
        }
        let mut allocation = self.0.allocation.lock().unwrap_or_else(PoisonError::into_inner);
        match allocation.as_mut().and_then(Allocation::mapped_slice_mut) {
            Some(mapped) => {
                mapped[..bytes.len()].copy_from_slice(bytes);
                Ok(())
            }
            None => Err(self.error("map", "its memory is not visible to the host".into())),
        }
    }

    /// Reads the first `count` elements. For a device buffer, this waits for a copy.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the buffer is smaller than that or the copy fails, [`Error::Refused`] for a device buffer on
    /// an adopted device.
    pub fn read<T: Pod>(&self, count: usize) -> Result<Vec<T>> {
        self.read_from(0, count)
    }

    /// Reads `count` elements, starting at element `first`.
    ///
    /// # Errors
    /// Same as [`Buffer::read`].
    pub fn read_from<T: Pod>(&self, first: usize, count: usize) -> Result<Vec<T>> {
        let (offset, bytes) = ((first * size_of::<T>()) as u64, (count * size_of::<T>()) as u64);
        if offset + bytes > self.0.bytes {
            return Err(self.error("read", format!("{bytes} bytes from byte {offset} of {}", self.0.bytes)));
        }
        if count == 0 {
            return Ok(Vec::new());
        }
        if self.0.memory == Memory::Device {
            let context = self.context()?;
            // Fails before anything is created for the copy.
            context.queue()?;
            let staging = Self::new(&context, "readback", bytes, Memory::Readback)?;
            let copy = |commands: &mut Commands| {
                commands.pass("readback", |pass| pass.copy_from(self, offset, &staging, bytes))
            };
            context.submit(copy)?;
            return staging.read(count);
        }
        let allocation = self.0.allocation.lock().unwrap_or_else(PoisonError::into_inner);
        match allocation.as_ref().and_then(Allocation::mapped_slice) {
            Some(mapped) => Ok(bytemuck::pod_collect_to_vec(&mapped[offset as usize..(offset + bytes) as usize])),
            None => Err(self.error("map", "its memory is not visible to the host".into())),
        }
    }

    /// Returns the size in bytes.
    pub fn bytes(&self) -> u64 {
        self.0.bytes
    }

    /// Returns the buffer's address for shaders and builds, on a device with ray queries.
    pub(in crate::gpu) fn address(&self) -> vk::DeviceAddress {
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.0.handle);
        // SAFETY: the buffer is bound, and was created with SHADER_DEVICE_ADDRESS if the device has ray queries.
        unsafe { self.0.device.get_buffer_device_address(&info) }
    }

    /// Returns the Vulkan handle, valid while a clone of the buffer lives.
    pub fn handle(&self) -> vk::Buffer {
        self.0.handle
    }

    pub(in crate::gpu) fn kept(&self) -> KeepAlive {
        self.0.clone()
    }

    fn context(&self) -> Result<Context> {
        self.0.context.context().ok_or_else(|| self.error("use", "its context is gone".into()))
    }

    fn error(&self, operation: &'static str, cause: String) -> Error {
        Error::Gpu { operation, name: self.0.name.clone(), cause: cause.into(), way_out: "report this as a bug".into() }
    }
}
