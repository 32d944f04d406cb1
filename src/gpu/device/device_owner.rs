//! An open device, opened here or the caller's, with its pipelines and its memory. It outlives the context for as long
//! as anything that was made on it lives.

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

/// An open device. Clones share it; the last one closes it, if it is not the caller's.
#[derive(Clone)]
pub(in crate::gpu) struct Device(Arc<Parts>);

/// Fields are destroyed in this order.
pub(in crate::gpu) struct Parts {
    pub allocator: Memory,
    /// Bytes of memory that resources made here hold.
    pub allocated: AtomicU64,
    pub pipelines: Pipelines,
    /// Present where validation or captures read labels.
    pub labels: Option<ext::debug_utils::Device>,
    /// Present where the device has ray queries.
    pub acceleration: Option<khr::acceleration_structure::Device>,
    /// Present where the device's clock can be read.
    pub clock: Option<ext::calibrated_timestamps::Device>,
    /// The driver's reports about pipelines.
    pub executables: Executables,
    pub features: Features,
    pub messages: Messages,
    pub handle: Handle,
    /// The library whose functions are called stays loaded.
    pub _entry: ash::Entry,
    pub _instance: Option<InstanceOwner>,
}

/// Where device memory is allocated from.
pub(in crate::gpu) enum Memory {
    /// Dropped with the device.
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
    /// Destroyed when dropped.
    Own(ash::Device),
    /// Left as it is.
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
            // SAFETY: every other object made from the device holds it, so none is left; it is idle.
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
            // The allocator holds the caller's memory too, so only the sum of bytes made here tells of a leak.
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

    /// The functions of acceleration structures.
    pub(in crate::gpu) fn acceleration(&self) -> Option<&khr::acceleration_structure::Device> {
        self.0.acceleration.as_ref()
    }

    /// The driver's reports about pipelines.
    pub(in crate::gpu) fn executables(&self) -> &Executables {
        &self.0.executables
    }

    /// The function that reads its clock.
    pub(in crate::gpu) fn clock(&self) -> Option<&ext::calibrated_timestamps::Device> {
        self.0.clock.as_ref()
    }

    /// Bytes of memory that resources made here hold.
    pub(in crate::gpu) fn allocated_bytes(&self) -> u64 {
        self.0.allocated.load(Ordering::Relaxed)
    }

    /// Gives `handle` a name in validation messages and captures.
    pub(in crate::gpu) fn set_name<H: vk::Handle>(&self, handle: H, name: &str) {
        if let (Some(labels), Ok(name)) = (self.labels(), CString::new(name)) {
            let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
            // SAFETY: the handle belongs to this device. A name that cannot be set is no loss.
            let _ = unsafe { labels.set_debug_utils_object_name(&info) };
        }
    }

    /// Allocates memory, which the caller gives back with [`Device::free`].
    pub(in crate::gpu) fn allocate(&self, wanted: &AllocationCreateDesc) -> Result<Allocation> {
        let mut allocator = self.0.allocator.allocator().lock().unwrap_or_else(PoisonError::into_inner);
        let allocation = fault::allocation(wanted.location != MemoryLocation::GpuOnly)
            .and_then(|()| allocator.allocate(wanted))
            .map_err(|e| allocation_error(wanted.name, &e))?;
        self.0.allocated.fetch_add(allocation.size(), Ordering::Relaxed);
        Ok(allocation)
    }

    /// A failed free shows up as a leak when the device closes.
    pub(in crate::gpu) fn free(&self, allocation: Allocation) {
        let bytes = allocation.size();
        let mut allocator = self.0.allocator.allocator().lock().unwrap_or_else(PoisonError::into_inner);
        if allocator.free(allocation).is_ok() {
            self.0.allocated.fetch_sub(bytes, Ordering::Relaxed);
        }
    }
}

/// The error for a failed allocation.
pub(in crate::gpu) fn allocation_error(name: &str, cause: &AllocationError) -> Error {
    Error::Gpu {
        operation: "allocate memory for",
        name: name.into(),
        cause: cause.to_string().into(),
        way_out: WayOut::Less(&[Less::Map, Less::Casters, Less::MoreMemory]),
    }
}
