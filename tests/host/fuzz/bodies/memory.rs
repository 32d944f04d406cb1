//! Limits the memory that Gobo may use in a body: a header that promises 4 billion rows must not be believed.

/// Allowance for any input: buffers of a fixed size.
const ALWAYS_BYTES: u64 = 4 << 20;

/// Bytes of memory per byte of input. glTF needs the most: `{},` is a node of 500 bytes, in a list that grew by doubling.
const PER_BYTE: u64 = 1000;

/// Returns the result of `of`, and asserts that its peak memory is within the allowance for `input_bytes`.
#[track_caller]
pub fn bounded<T>(input_bytes: usize, of: impl FnOnce() -> T) -> T {
    let mut result = None;
    let taken = allocation_counter::measure(|| result = Some(of())).bytes_max;
    let allowed = ALWAYS_BYTES + PER_BYTE * input_bytes as u64;
    assert!(taken <= allowed, "{taken} bytes of memory for {input_bytes} of input, more than {allowed}");
    result.expect("it was run")
}
