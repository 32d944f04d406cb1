//! For tests of this library: a device that reports less than it has, checks in shaders, calls that fail. None of this happens unless a
//! program asks for it by [`Testing::begin`]; the library reads no variable of the environment.

pub(crate) mod fault;
pub(super) mod lowest;
pub(super) mod validation;

use crate::Result;
use crate::gpu::testing::fault::Fault;
use crate::gpu::{Buffer, Context, Limit, Memory};
use std::cell::Cell;
use std::sync::OnceLock;

/// Changes that tests want of all devices that this process opens. By default none.
#[doc(hidden)]
#[derive(Clone, Debug, Default)]
pub struct Testing {
    /// Whether the device counts as one whose limits are as low as Vulkan 1.3 allows.
    pub lowest_limits: bool,
    /// Whether the device counts as one without optional features.
    pub no_features: bool,
    /// Whether the validation layer puts checks into shaders too, so that a read or write beyond a buffer gives a
    /// message.
    pub checks_in_shaders: bool,
    /// A call that fails.
    pub fault: Option<Fault>,
    /// MiB that each build fills in addition, so that it takes longer than it should; 0 for none.
    pub burden: u64,
    /// Milliseconds that each row of the window's reference takes longer than it should.
    pub slow_truth_ms: u64,
}

static TESTING: OnceLock<Testing> = OnceLock::new();

impl Testing {
    /// Applies these changes from now on, for the whole process. Later calls change nothing.
    pub fn begin(self) {
        TESTING.get_or_init(|| self);
    }

    /// Runs `body`. Devices that this thread opens during `body` report one less of `limit` than is needed, or what they really have, if
    /// that is less.
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

/// The limit that [`Testing::just_below`] lowers, if there is one.
pub(in crate::gpu) fn lowered() -> Option<Limit> {
    LOWERED.get()
}

/// The changes that are wanted; none before testing has begun.
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

/// For tests that want builds to take longer: a buffer that each build fills, and how many times it does so; none where no test wants this.
/// The buffer has at most 64 MiB, since every device can bind 128 MiB.
///
/// # Errors
/// [`crate::Error::Gpu`] where memory runs out.
pub(crate) fn burden(context: &Context) -> Result<Option<(Buffer, u64)>> {
    let mib = testing().burden;
    let times = mib.div_ceil(64);
    let buffer = |times| Buffer::new(context, "test.burden", (mib << 20) / times / 4 * 4, Memory::Device);
    (times > 0).then(|| Ok((buffer(times)?, times))).transpose()
}

/// Sleeps for as long as a test wants `rows` rows of the window's reference to take.
#[cfg(feature = "view")]
pub(crate) fn slow_truth(rows: u32) {
    let ms = testing().slow_truth_ms;
    if ms > 0 {
        std::thread::sleep(std::time::Duration::from_millis(ms * u64::from(rows)));
    }
}
