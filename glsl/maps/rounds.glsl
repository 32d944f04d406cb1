// Detects that a driver has ended loops too early. lavapipe 22.3 allows an invocation about 65,536 loop iterations, summed over all its
// loops. After that it ends each loop after its first iteration, without an error (docs/reference/drivers.md).
#ifndef MAPS_ROUNDS_GLSL
#define MAPS_ROUNDS_GLSL
#extension GL_EXT_control_flow_attributes : require

// To be called after all other loops. `some`: any number whose value and bounds the compiler cannot know, so that the loop is not optimized
// away.
bool rounds_ran_out(uint some) {
    uint wanted = (some & 1u) + 2u, gone = 0u;
    [[dont_unroll]] while (gone < wanted) {
        ++gone;
    }
    // Not the loop's own condition, which compilers know to be false here.
    return gone != wanted;
}
#endif
