//! Host memory used by this process.

/// Returns the resident memory of this process in bytes; `None` if the system does not report it.
pub(crate) fn host_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The reported memory of the process must grow once the process holds more.
    #[test]
    fn memory_is_seen() {
        let Some(before) = host_bytes() else { return println!("skipped: the system does not say") };
        // More than other tests free in the meantime.
        let held = std::hint::black_box(vec![1_u8; 512 << 20]);
        assert!(host_bytes() > Some(before + (held.len() as u64) / 2));
        drop(std::hint::black_box(held));
    }
}
