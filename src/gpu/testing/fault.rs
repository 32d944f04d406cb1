//! For tests: the n-th call of a kind fails, as a driver or a full disk would make it fail. `allocation:17` names the
//! kind and the number. With `0` all calls succeed; with `17+` all calls after the 17th fail too. Calls of all kinds
//! are counted. Without a [`Fault`] nothing fails and nothing is counted.

use crate::gpu::testing::testing;
use ash::prelude::VkResult;
use ash::vk;
use gpu_allocator::AllocationError;
use std::sync::atomic::{AtomicU64, Ordering};

/// Kinds of calls that can be made to fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Call {
    /// Memory for a buffer or an image: none is left.
    Allocation,
    /// Memory that the host sees: it cannot be mapped.
    Map,
    /// Any other object: the host's memory is full.
    Creation,
    /// Commands handed to the device, which is lost from then on.
    Submission,
    /// Waiting for them: the same.
    Wait,
    /// Writing to a file or to standard output: the disk is full.
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

/// How many calls of each kind there were.
static MADE: [AtomicU64; CALLS.len()] = [const { AtomicU64::new(0) }; CALLS.len()];

/// The kind of call that is to fail, and the number of the call.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    call: Call,
    nth: u64,
    /// Whether all later calls of the kind fail too.
    lasts: bool,
}

impl Fault {
    /// Parses `allocation:17`; none where the text is no fault.
    pub fn read(text: &str) -> Option<Self> {
        let (kind, nth) = text.split_once(':')?;
        let (_, call) = CALLS.into_iter().find(|(name, _)| *name == kind)?;
        let (nth, lasts) = nth.strip_suffix('+').map_or((nth, false), |nth| (nth, true));
        Some(Self { call, nth: nth.parse().ok()?, lasts })
    }
}

/// Whether a fault was asked for.
#[cfg(feature = "program")]
pub(crate) fn is_asked() -> bool {
    testing().fault.is_some()
}

/// Whether this call is the one to fail.
fn fails(call: Call) -> bool {
    let made = || MADE[call as usize].fetch_add(1, Ordering::Relaxed) + 1;
    testing().fault.is_some_and(|fault| {
        let (made, nth) = (made(), fault.nth);
        fault.call == call && (made == nth || fault.lasts && nth > 0 && made > nth)
    })
}

/// Fails where this allocation, or its mapping where the host sees the memory, is the call to fail.
pub(in crate::gpu) fn allocation(is_mapped: bool) -> Result<(), AllocationError> {
    if fails(Call::Allocation) {
        return Err(AllocationError::OutOfMemory);
    }
    if is_mapped && fails(Call::Map) {
        return Err(AllocationError::FailedToMap(vk::Result::ERROR_MEMORY_MAP_FAILED.to_string()));
    }
    Ok(())
}

/// The result of `make`, or the fault.
pub(in crate::gpu) fn creation<T>(make: impl FnOnce() -> VkResult<T>) -> VkResult<T> {
    if fails(Call::Creation) { Err(vk::Result::ERROR_OUT_OF_HOST_MEMORY) } else { make() }
}

/// The result of `submit`, or the fault.
pub(crate) fn submission(submit: impl FnOnce() -> VkResult<()>) -> VkResult<()> {
    if fails(Call::Submission) { Err(vk::Result::ERROR_DEVICE_LOST) } else { submit() }
}

/// The result of `wait`, or the fault. The device really runs in either case, so `wait` is always called.
pub(in crate::gpu) fn wait(wait: impl FnOnce() -> VkResult<()>) -> VkResult<()> {
    let fails = fails(Call::Wait);
    wait().and(if fails { Err(vk::Result::ERROR_DEVICE_LOST) } else { Ok(()) })
}

/// Fails where this write to a file or to standard output is the call to fail.
#[cfg(feature = "program")]
pub(crate) fn write() -> std::io::Result<()> {
    if fails(Call::Write) { Err(std::io::ErrorKind::StorageFull.into()) } else { Ok(()) }
}

/// How many calls of each kind there were, for the end of the program; none unless a fault was asked for.
#[cfg(feature = "program")]
pub(crate) fn counted() -> Option<String> {
    let of = |(name, call): (&str, Call)| format!("{name} {}", MADE[call as usize].load(Ordering::Relaxed));
    testing().fault.map(|_| CALLS.map(of).join(", "))
}
