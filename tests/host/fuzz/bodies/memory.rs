//! Memory that a body lets Gobo take: a header that promises 4 billion rows must not be believed.

/// Whatever the size of the input: buffers that are filled in any case.
const ALWAYS_BYTES: u64 = 4 << 20;

/// Bytes of memory for a byte of input. The most is glTF's: `{},` is a node of 500 bytes, in a list that grew by doubling.
const PER_BYTE: u64 = 1000;

/// What `of` gives, which takes no more memory at once than so many bytes of input account for.
#[track_caller]
pub fn bounded<T>(input_bytes: usize, of: impl FnOnce() -> T) -> T {
    let mut result = None;
    let taken = allocation_counter::measure(|| result = Some(of())).bytes_max;
    let allowed = ALWAYS_BYTES + PER_BYTE * input_bytes as u64;
    assert!(taken <= allowed, "{taken} bytes of memory for {input_bytes} of input, more than {allowed}");
    result.expect("it was run")
}
