//! For tests of this library: a device that reports less than it supports, checks in shaders, calls that fail. None of this is active
//! unless a program requests it with [`Testing::begin`]; the library reads no environment variables.

pub(crate) mod fault;
pub(super) mod lowest;
pub(super) mod validation;

use crate::Result;
use crate::gpu::testing::fault::Fault;
use crate::gpu::{Buffer, Context, Limit, Memory};
use std::cell::Cell;
use std::sync::OnceLock;

/// Changes that tests make to all devices that this process opens. None by default.
#[doc(hidden)]
#[derive(Clone, Debug, Default)]
pub struct Testing {
    /// Whether to treat the device as one whose limits are as low as Vulkan 1.3 allows.
    pub lowest_limits: bool,
    /// Whether to treat the device as one without optional features.
    pub no_features: bool,
    /// Whether the validation layer also adds checks to shaders, so that an out-of-bounds buffer access is reported.
    pub checks_in_shaders: bool,
    /// The call that should fail.
    pub fault: Option<Fault>,
    /// MiB that each build fills in addition, to make it slower on purpose; 0 for none.
    pub burden: u64,
    /// Milliseconds by which each row of the window's reference is slowed down on purpose.
    pub slow_truth_ms: u64,
}

static TESTING: OnceLock<Testing> = OnceLock::new();

impl Testing {
    /// Applies these changes from now on, for the whole process. Later calls have no effect.
    pub fn begin(self) {
        TESTING.get_or_init(|| self);
    }

    /// Runs `body`. Devices that this thread opens during `body` report one less than the required `limit`, or their real value if that is
    /// lower.
    pub fn just_below<T>(limit: Limit, body: impl FnOnce() -> T) -> T {
        LOWERED.set(Some(limit));
        let done = body();
        LOWERED.set(None);
        done
    }
}

thread_local! {
    static LOWERED: Cell<Option<Limit>> = const { Cell::new(None) };
}

/// Returns the limit that [`Testing::just_below`] lowers, if any.
pub(in crate::gpu) fn lowered() -> Option<Limit> {
    LOWERED.get()
}

/// Returns the requested changes; no changes before testing has begun.
pub(in crate::gpu) fn testing() -> &'static Testing {
    static NONE: Testing = Testing {
        lowest_limits: false,
        no_features: false,
        checks_in_shaders: false,
        fault: None,
        burden: 0,
        slow_truth_ms: 0,
    };
    TESTING.get().unwrap_or(&NONE)
}

/// For tests that need slower builds: returns a buffer that each build fills, and how many times to fill it; `None` if no test requests
/// this. The buffer has at most 64 MiB, since every device can bind 128 MiB.
///
/// # Errors
/// [`crate::Error::Gpu`] if memory runs out.
pub(crate) fn burden(context: &Context) -> Result<Option<(Buffer, u64)>> {
    let mib = testing().burden;
    let times = mib.div_ceil(64);
    let buffer = |times| Buffer::new(context, "test.burden", (mib << 20) / times / 4 * 4, Memory::Device);
    (times > 0).then(|| Ok((buffer(times)?, times))).transpose()
}

/// Sleeps for as long as a test slows down `rows` rows of the window's reference.
#[cfg(feature = "view")]
pub(crate) fn slow_truth(rows: u32) {
    let ms = testing().slow_truth_ms;
    if ms > 0 {
        std::thread::sleep(std::time::Duration::from_millis(ms * u64::from(rows)));
    }
}
