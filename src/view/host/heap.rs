//! Heap bytes in use. Resident memory also includes freed memory that the C library retains: after a driver's many small allocations this
//! is tens of megabytes and grows with each frame, but it is not a leak.

/// Returns the heap bytes of this process, including its drivers; `None` if the C library does not report them.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn heap_bytes() -> Option<u64> {
    use std::ffi::c_int;

    /// `struct mallinfo` of glibc's malloc.h.
    #[repr(C)]
    struct Info {
        arena: c_int,
        ordblks: c_int,
        smblks: c_int,
        hblks: c_int,
        hblkhd: c_int,
        usmblks: c_int,
        fsmblks: c_int,
        uordblks: c_int,
        fordblks: c_int,
        keepcost: c_int,
    }
    unsafe extern "C" {
        fn mallinfo() -> Info;
    }
    // The counters in `Info` have 32 bits.
    crate::bench::host_bytes().filter(|resident| *resident < 1 << 31)?;
    // SAFETY: every glibc has this function, and it takes the locks that it needs.
    let info = unsafe { mallinfo() };
    Some(u64::from(info.hblkhd.cast_unsigned()) + u64::from(info.uordblks.cast_unsigned()))
}

/// Returns `None`: this C library does not report it.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub fn heap_bytes() -> Option<u64> {
    None
}
