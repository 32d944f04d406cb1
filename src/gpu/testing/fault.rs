//! For tests: makes the n-th call of a kind fail, as a driver or a full disk would. `allocation:17` names the kind and
//! the number. With `0` all calls succeed; with `17+` all calls after the 17th fail too. Calls of all kinds are
//! counted. Without a [`Fault`], nothing fails and nothing is counted.

use crate::gpu::testing::testing;
use ash::prelude::VkResult;
use ash::vk;
use gpu_allocator::AllocationError;
use std::sync::atomic::{AtomicU64, Ordering};

/// Kinds of calls that can be made to fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Call {
    /// Memory for a buffer or an image: out of memory.
    Allocation,
    /// Host-visible memory: it cannot be mapped.
    Map,
    /// Any other object: the host is out of memory.
    Creation,
    /// Submission of commands: the device is lost from then on.
    Submission,
    /// Wait for submitted commands: the device is lost from then on.
    Wait,
    /// Write to a file or to standard output: the disk is full.
    Write,
}

const CALLS: [(&str, Call); 6] = [
    ("allocation", Call::Allocation),
    ("map", Call::Map),
    ("creation", Call::Creation),
    ("submission", Call::Submission),
    ("wait", Call::Wait),
    ("write", Call::Write),
];

/// Number of calls of each kind so far.
static MADE: [AtomicU64; CALLS.len()] = [const { AtomicU64::new(0) }; CALLS.len()];

/// The kind of call that should fail, and the number of the call.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    call: Call,
    nth: u64,
    /// Whether all later calls of the kind fail too.
    lasts: bool,
}

impl Fault {
    /// Parses a fault such as `allocation:17`; `None` if the text is not one.
    pub fn read(text: &str) -> Option<Self> {
        let (kind, nth) = text.split_once(':')?;
        let (_, call) = CALLS.into_iter().find(|(name, _)| *name == kind)?;
        let (nth, lasts) = nth.strip_suffix('+').map_or((nth, false), |nth| (nth, true));
        Some(Self { call, nth: nth.parse().ok()?, lasts })
    }
}

/// Returns whether a fault was requested.
#[cfg(feature = "program")]
pub(crate) fn is_asked() -> bool {
    testing().fault.is_some()
}

/// Returns whether this call is the one to fail.
fn fails(call: Call) -> bool {
    let made = || MADE[call as usize].fetch_add(1, Ordering::Relaxed) + 1;
    testing().fault.is_some_and(|fault| {
        let (made, nth) = (made(), fault.nth);
        fault.call == call && (made == nth || fault.lasts && nth > 0 && made > nth)
    })
}

/// Fails if this allocation, or its mapping if the memory is host-visible, is the call to fail.
pub(in crate::gpu) fn allocation(is_mapped: bool) -> Result<(), AllocationError> {
    if fails(Call::Allocation) {
        return Err(AllocationError::OutOfMemory);
    }
    if is_mapped && fails(Call::Map) {
        return Err(AllocationError::FailedToMap(vk::Result::ERROR_MEMORY_MAP_FAILED.to_string()));
    }
    Ok(())
}

/// Returns the result of `make`, or the fault.
pub(in crate::gpu) fn creation<T>(make: impl FnOnce() -> VkResult<T>) -> VkResult<T> {
    if fails(Call::Creation) { Err(vk::Result::ERROR_OUT_OF_HOST_MEMORY) } else { make() }
}

/// Returns the result of `submit`, or the fault.
pub(crate) fn submission(submit: impl FnOnce() -> VkResult<()>) -> VkResult<()> {
    if fails(Call::Submission) { Err(vk::Result::ERROR_DEVICE_LOST) } else { submit() }
}

/// Returns the result of `wait`, or the fault. The device runs in either case, so `wait` is always called.
pub(in crate::gpu) fn wait(wait: impl FnOnce() -> VkResult<()>) -> VkResult<()> {
    let fails = fails(Call::Wait);
    wait().and(if fails { Err(vk::Result::ERROR_DEVICE_LOST) } else { Ok(()) })
}

/// Fails if this write to a file or to standard output is the call to fail.
#[cfg(feature = "program")]
pub(crate) fn write() -> std::io::Result<()> {
    if fails(Call::Write) { Err(std::io::ErrorKind::StorageFull.into()) } else { Ok(()) }
}

/// Returns the number of calls of each kind, for the end of the program; `None` unless a fault was requested.
#[cfg(feature = "program")]
pub(crate) fn counted() -> Option<String> {
    let of = |(name, call): (&str, Call)| format!("{name} {}", MADE[call as usize].load(Ordering::Relaxed));
    testing().fault.map(|_| CALLS.map(of).join(", "))
}
