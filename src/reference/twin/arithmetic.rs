//! CPU twin of glsl/bench/arithmetic.glsl: the arithmetic of one thread, in a compute shader or a fragment shader.

/// Returns a thread's value after `rounds` rounds. Twin: arithmetic.
pub fn arithmetic(seed: u32, thread: u32, rounds: u32) -> u32 {
    (0..rounds).fold(seed ^ thread.wrapping_mul(0x9e37_79b9), |value, _| {
        let next = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        next ^ (next >> 15)
    })
}
