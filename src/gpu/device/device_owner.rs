//! An open device, opened here or supplied by the caller, with its pipelines and its memory. It outlives the context
//! for as long as anything created on it is alive.

use crate::gpu::device::instance::InstanceOwner;
use crate::gpu::profile::executables::Executables;
use crate::gpu::resource::pipelines::Pipelines;
use crate::gpu::testing::fault;
use crate::gpu::{Features, Messages};
use crate::{Error, Less, Result, WayOut};
use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, Allocator};
use gpu_allocator::{AllocationError, MemoryLocation};
use std::ffi::CString;
use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// An open device. Clones share it; the last one closes it, unless the caller owns it.
#[derive(Clone)]
pub(in crate::gpu) struct Device(Arc<Parts>);

/// Fields are dropped in this order.
pub(in crate::gpu) struct Parts {
    pub allocator: Memory,
    /// Bytes of memory held by resources created here.
    pub allocated: AtomicU64,
    pub pipelines: Pipelines,
    /// Present if validation or a capture tool reads labels.
    pub labels: Option<ext::debug_utils::Device>,
    /// Present if the device supports ray queries.
    pub acceleration: Option<khr::acceleration_structure::Device>,
    /// Present if the device's clock can be read.
    pub clock: Option<ext::calibrated_timestamps::Device>,
    /// The driver's reports about pipelines.
    pub executables: Executables,
    pub features: Features,
    pub messages: Messages,
    pub handle: Handle,
    /// Keeps the Vulkan library loaded while its functions are called.
    pub _entry: ash::Entry,
    pub _instance: Option<InstanceOwner>,
}

/// Source of device memory.
pub(in crate::gpu) enum Memory {
    /// An allocator of our own, dropped with the device.
    Own(Arc<Mutex<Allocator>>),
    /// The caller's allocator, shared with the caller.
    Theirs(Arc<Mutex<Allocator>>),
}

impl Memory {
    fn allocator(&self) -> &Mutex<Allocator> {
        match self {
            Self::Own(allocator) | Self::Theirs(allocator) => allocator,
        }
    }
}

/// The logical device.
pub(in crate::gpu) enum Handle {
    /// Destroyed on drop.
    Own(ash::Device),
    /// Owned by the caller, and never destroyed here.
    Theirs(ash::Device),
}

impl Deref for Handle {
    type Target = ash::Device;
    fn deref(&self) -> &ash::Device {
        match self {
            Self::Own(device) | Self::Theirs(device) => device,
        }
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        if let Self::Own(device) = self {
            // SAFETY: every other object created from the device keeps it alive, so none is left, and the device is idle.
            unsafe { device.destroy_device(None) };
        }
    }
}

impl Drop for Parts {
    fn drop(&mut self) {
        self.pipelines.destroy(&self.handle);
        match &self.allocator {
            Memory::Own(allocator) => {
                for leak in allocator.lock().unwrap_or_else(PoisonError::into_inner).generate_report().allocations {
                    self.messages.push("gobo-leak", &format!("{} ({} bytes) was never freed", leak.name, leak.size));
                }
            }
            // The allocator also holds the caller's memory, so only our own byte count reveals a leak.
            Memory::Theirs(_) => match *self.allocated.get_mut() {
                0 => {}
                bytes => self.messages.push("gobo-leak", &format!("{bytes} bytes were never freed")),
            },
        }
    }
}

impl Deref for Device {
    type Target = ash::Device;
    fn deref(&self) -> &ash::Device {
        &self.0.handle
    }
}

impl Device {
    pub(in crate::gpu) fn new(parts: Parts) -> Self {
        Self(Arc::new(parts))
    }

    pub(in crate::gpu) fn features(&self) -> &Features {
        &self.0.features
    }

    pub(in crate::gpu) fn messages(&self) -> &Messages {
        &self.0.messages
    }

    pub(in crate::gpu) fn pipelines(&self) -> &Pipelines {
        &self.0.pipelines
    }

    pub(in crate::gpu) fn labels(&self) -> Option<&ext::debug_utils::Device> {
        self.0.labels.as_ref()
    }

    /// Returns the acceleration structure functions.
    pub(in crate::gpu) fn acceleration(&self) -> Option<&khr::acceleration_structure::Device> {
        self.0.acceleration.as_ref()
    }

    /// Returns the driver's reports about pipelines.
    pub(in crate::gpu) fn executables(&self) -> &Executables {
        &self.0.executables
    }

    /// Returns the function that reads the device's clock.
    pub(in crate::gpu) fn clock(&self) -> Option<&ext::calibrated_timestamps::Device> {
        self.0.clock.as_ref()
    }

    /// Returns the number of bytes of memory held by resources created here.
    pub(in crate::gpu) fn allocated_bytes(&self) -> u64 {
        self.0.allocated.load(Ordering::Relaxed)
    }

    /// Gives `handle` a name in validation messages and captures.
    pub(in crate::gpu) fn set_name<H: vk::Handle>(&self, handle: H, name: &str) {
        if let (Some(labels), Ok(name)) = (self.labels(), CString::new(name)) {
            let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
            // SAFETY: the handle belongs to this device. Failing to set a name is harmless.
            let _ = unsafe { labels.set_debug_utils_object_name(&info) };
        }
    }

    /// Allocates memory, to be returned with [`Device::free`].
    pub(in crate::gpu) fn allocate(&self, wanted: &AllocationCreateDesc) -> Result<Allocation> {
        let mut allocator = self.0.allocator.allocator().lock().unwrap_or_else(PoisonError::into_inner);
        let allocation = fault::allocation(wanted.location != MemoryLocation::GpuOnly)
            .and_then(|()| allocator.allocate(wanted))
            .map_err(|e| allocation_error(wanted.name, &e))?;
        self.0.allocated.fetch_add(allocation.size(), Ordering::Relaxed);
        Ok(allocation)
    }

    /// Frees memory. If that fails, the memory is reported as a leak when the device closes.
    pub(in crate::gpu) fn free(&self, allocation: Allocation) {
        let bytes = allocation.size();
        let mut allocator = self.0.allocator.allocator().lock().unwrap_or_else(PoisonError::into_inner);
        if allocator.free(allocation).is_ok() {
            self.0.allocated.fetch_sub(bytes, Ordering::Relaxed);
        }
    }
}

/// Returns the error for a failed allocation.
pub(in crate::gpu) fn allocation_error(name: &str, cause: &AllocationError) -> Error {
    Error::Gpu {
        operation: "allocate memory for",
        name: name.into(),
        cause: cause.to_string().into(),
        way_out: WayOut::Less(&[Less::Map, Less::Casters, Less::MoreMemory]),
    }
}
