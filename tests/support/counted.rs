//! A device whose functions that submit or wait are counted, for whoever is given it: proof that Gobo calls none of them. The
//! renderer calls its own device, in which nothing is counted.

use ash::vk::{self, Handle};
use std::collections::BTreeMap;
use std::ffi::{CStr, c_void};
use std::mem::transmute;
use std::sync::atomic::{AtomicPtr, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// How often each function was called that submits or waits.
#[derive(Clone, Default)]
pub struct Counts(Arc<[AtomicU64; NAMES.len()]>);

impl Counts {
    /// Those that were called, by their names.
    pub fn calls(&self) -> Vec<(&'static str, u64)> {
        let counts = self.0.iter().map(|count| count.load(Ordering::Relaxed));
        NAMES.iter().map(|name| name.to_str().unwrap_or_default()).zip(counts).filter(|(_, count)| *count > 0).collect()
    }
}

/// By device and by queue, which are what these functions are told.
static COUNTED: Mutex<BTreeMap<u64, Counts>> = Mutex::new(BTreeMap::new());

fn note(handle: impl Handle, place: usize) {
    let counted = COUNTED.lock().unwrap_or_else(PoisonError::into_inner);
    // A handle that nobody gave away ends the program here: it cannot be from a device that is counted.
    counted[&handle.as_raw()].0[place].fetch_add(1, Ordering::Relaxed);
}

/// The same device and queue, as somebody else is given it.
///
/// # Safety
/// All of these belong together, and the application asked for Vulkan 1.3.
pub unsafe fn counted(
    entry: &ash::Entry,
    instance: &ash::Instance,
    device: &ash::Device,
    queue: vk::Queue,
) -> (ash::Device, Counts) {
    let counts = Counts::default();
    let handles = [device.handle().as_raw(), queue.as_raw()];
    COUNTED.lock().unwrap_or_else(PoisonError::into_inner).extend(handles.map(|handle| (handle, counts.clone())));
    let of_instance = |name: &CStr| {
        // SAFETY: the instance is the entry's.
        let found = unsafe { entry.get_instance_proc_addr(instance.handle(), name.as_ptr()) };
        found.map_or(std::ptr::null_mut(), |function| function as *mut c_void)
    };
    let load = |name: &CStr| -> *const c_void {
        if let Some(place) = NAMES.iter().position(|counted| *counted == name) {
            // The instance's are the loader's own, which are right for all devices.
            REAL[place].store(of_instance(name), Ordering::Relaxed);
            return COUNTING[place].0;
        }
        // SAFETY: the device is the instance's.
        let found = unsafe { instance.get_device_proc_addr(device.handle(), name.as_ptr()) };
        found.map_or(std::ptr::null(), |function| function as *const c_void)
    };
    // SAFETY: each function is found by its name, or has the same signature.
    (unsafe { ash::Device::load_with(load, device.handle()) }, counts)
}

/// A function of this file, by its address.
struct Function(*const c_void);

// SAFETY: functions are never written to.
unsafe impl Sync for Function {}

/// A function each that is counted, if `$if`, and then calls the real one.
macro_rules! counting {
    ($($place:literal $vulkan:literal $name:ident as $signature:ident(
        $handle:ident: $of:ty $(, $argument:ident: $type:ty)*) if $if:expr;)*) => {
        /// What is counted.
        pub const NAMES: [&CStr; [$($place),*].len()] = [$($vulkan),*];

        static REAL: [AtomicPtr<c_void>; NAMES.len()] =
            [const { AtomicPtr::new(std::ptr::null_mut()) }; NAMES.len()];

        static COUNTING: [Function; NAMES.len()] = [$(Function($name as *const c_void)),*];

        $(unsafe extern "system" fn $name($handle: $of $(, $argument: $type)*) -> vk::Result {
            if $if {
                note($handle, $place);
            }
            // SAFETY: `counted` has put it there before anybody knows this function, and it is of this signature.
            unsafe {
                let real: vk::$signature = transmute(REAL[$place].load(Ordering::Relaxed));
                real($handle $(, $argument)*)
            }
        })*
    };
}

counting! {
    0 c"vkQueueSubmit" queue_submit as PFN_vkQueueSubmit(
        queue: vk::Queue, count: u32, submits: *const vk::SubmitInfo<'_>, fence: vk::Fence) if true;
    1 c"vkQueueSubmit2" queue_submit2 as PFN_vkQueueSubmit2(
        queue: vk::Queue, count: u32, submits: *const vk::SubmitInfo2<'_>, fence: vk::Fence) if true;
    2 c"vkQueueBindSparse" queue_bind_sparse as PFN_vkQueueBindSparse(
        queue: vk::Queue, count: u32, binds: *const vk::BindSparseInfo<'_>, fence: vk::Fence) if true;
    3 c"vkQueueWaitIdle" queue_wait_idle as PFN_vkQueueWaitIdle(queue: vk::Queue) if true;
    4 c"vkDeviceWaitIdle" device_wait_idle as PFN_vkDeviceWaitIdle(device: vk::Device) if true;
    5 c"vkWaitForFences" wait_for_fences as PFN_vkWaitForFences(
        device: vk::Device, count: u32, fences: *const vk::Fence, all: vk::Bool32, timeout_ns: u64) if true;
    6 c"vkWaitSemaphores" wait_semaphores as PFN_vkWaitSemaphores(
        device: vk::Device, info: *const vk::SemaphoreWaitInfo<'_>, timeout_ns: u64) if true;
    7 c"vkGetQueryPoolResults" get_query_pool_results as PFN_vkGetQueryPoolResults(
        device: vk::Device, pool: vk::QueryPool, first: u32, count: u32, bytes: usize, data: *mut c_void,
        stride: vk::DeviceSize, flags: vk::QueryResultFlags) if flags.contains(vk::QueryResultFlags::WAIT);
}
