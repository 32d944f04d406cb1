//! How much of the heap is in use. Resident memory has besides what was freed and the C library keeps: after a driver's many small
//! allocations that is tens of megabytes, more with each frame, and no leak.

/// Bytes, of this process and of the drivers in it; none where the C library does not say.
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
    // Its numbers have 32 bits.
    crate::bench::host_bytes().filter(|resident| *resident < 1 << 31)?;
    // SAFETY: glibc has it in all versions, and it takes the locks that it needs.
    let info = unsafe { mallinfo() };
    Some(u64::from(info.hblkhd.cast_unsigned()) + u64::from(info.uordblks.cast_unsigned()))
}

/// Nothing, where the C library does not say.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub fn heap_bytes() -> Option<u64> {
    None
}
