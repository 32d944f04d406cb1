#version 460
// Runs the arithmetic in compute threads. Inputs: push constants. Output: a value and a multiprocessor per thread.
// variants: PROCESSORS 0 1
#include "bench/arithmetic.glsl"

layout(local_size_x = 128) in;

// set 0: in_compute
layout(set = 0, binding = 0, std430) writeonly buffer Values { uvec2 values[]; };

void main() {
    uint thread = gl_GlobalInvocationID.x;
    if (thread < values.length()) {
        values[thread] = arithmetic(thread);
    }
}
