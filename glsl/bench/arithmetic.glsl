// Arithmetic of adjustable length, the same in compute and fragment shaders. Twin: reference::twin::arithmetic. Inputs: the thread's
// number, push constants. Output: the value after all rounds; with PROCESSORS 1 also the index of the multiprocessor. Invariant: integers
// only, so every device computes the same value; each round depends on the one before, so none can be optimized away.
#if PROCESSORS == 1
#extension GL_NV_shader_sm_builtins : require
#endif
#extension GL_EXT_scalar_block_layout : require

layout(push_constant, scalar) uniform ArithmeticPush {
    uint seed;
    uint rounds;
    uint width;  // threads per row
};

uvec2 arithmetic(uint thread) {
    uint value = seed ^ (thread * 0x9e3779b9u);
    for (uint i = 0u; i < rounds; i++) {
        value = value * 747796405u + 2891336453u;
        value ^= value >> 15;
    }
#if PROCESSORS == 1
    return uvec2(value, gl_SMIDNV);
#else
    return uvec2(value, 0u);
#endif
}
