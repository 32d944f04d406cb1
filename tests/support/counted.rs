//! A device that counts calls of the functions that submit or wait, to prove that Gobo calls none of them. The renderer itself calls its
//! own, uncounted device.

use ash::vk::{self, Handle};
use std::collections::BTreeMap;
use std::ffi::{CStr, c_void};
use std::mem::transmute;
use std::sync::atomic::{AtomicPtr, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Number of calls of each function that submits or waits.
#[derive(Clone, Default)]
pub struct Counts(Arc<[AtomicU64; NAMES.len()]>);

impl Counts {
    /// Returns the functions that were called, with their numbers of calls.
    pub fn calls(&self) -> Vec<(&'static str, u64)> {
        let counts = self.0.iter().map(|count| count.load(Ordering::Relaxed));
        NAMES.iter().map(|name| name.to_str().unwrap_or_default()).zip(counts).filter(|(_, count)| *count > 0).collect()
    }
}

/// Counts by device and by queue handle, the first argument of these functions.
static COUNTED: Mutex<BTreeMap<u64, Counts>> = Mutex::new(BTreeMap::new());

fn note(handle: impl Handle, place: usize) {
    let counted = COUNTED.lock().unwrap_or_else(PoisonError::into_inner);
    // Panics on an unknown handle: it cannot belong to a counted device.
    counted[&handle.as_raw()].0[place].fetch_add(1, Ordering::Relaxed);
}

/// Returns the same device and queue with calls counted, to hand to others.
///
/// # Safety
/// All arguments must belong together, and the application must have requested Vulkan 1.3.
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
        // SAFETY: the instance was created from this entry.
        let found = unsafe { entry.get_instance_proc_addr(instance.handle(), name.as_ptr()) };
        found.map_or(std::ptr::null_mut(), |function| function as *mut c_void)
    };
    let load = |name: &CStr| -> *const c_void {
        if let Some(place) = NAMES.iter().position(|counted| *counted == name) {
            // The instance's functions are the loader's trampolines, which are valid for every device.
            REAL[place].store(of_instance(name), Ordering::Relaxed);
            return COUNTING[place].0;
        }
        // SAFETY: the device was created from this instance.
        let found = unsafe { instance.get_device_proc_addr(device.handle(), name.as_ptr()) };
        found.map_or(std::ptr::null(), |function| function as *const c_void)
    };
    // SAFETY: each function is loaded by its name, or replaced by one of the same signature.
    (unsafe { ash::Device::load_with(load, device.handle()) }, counts)
}

/// Address of a function in this file.
struct Function(*const c_void);

// SAFETY: functions are immutable.
unsafe impl Sync for Function {}

/// Defines one function per entry, which counts the call if `$if` holds and then calls the real function.
macro_rules! counting {
    ($($place:literal $vulkan:literal $name:ident as $signature:ident(
        $handle:ident: $of:ty $(, $argument:ident: $type:ty)*) if $if:expr;)*) => {
        /// Names of the counted functions.
        pub const NAMES: [&CStr; [$($place),*].len()] = [$($vulkan),*];

        static REAL: [AtomicPtr<c_void>; NAMES.len()] =
            [const { AtomicPtr::new(std::ptr::null_mut()) }; NAMES.len()];

        static COUNTING: [Function; NAMES.len()] = [$(Function($name as *const c_void)),*];

        $(unsafe extern "system" fn $name($handle: $of $(, $argument: $type)*) -> vk::Result {
            if $if {
                note($handle, $place);
            }
            // SAFETY: `counted` stores the function before it hands out this one, and both have the same signature.
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
