// Whether a driver has ended loops before their time. lavapipe 22.3 gives an invocation some 65,536 rounds, of all its loops
// together, and then ends each after its first, without a word (docs/drivers.md).
#ifndef MAPS_ROUNDS_GLSL
#define MAPS_ROUNDS_GLSL
#extension GL_EXT_control_flow_attributes : require

// Asked last. `some`: any number that no compiler knows, not even its bounds, so that the loop stays one.
bool rounds_ran_out(uint some) {
    uint wanted = (some & 1u) + 2u, gone = 0u;
    [[dont_unroll]] while (gone < wanted) {
        ++gone;
    }
    // Not the loop's own condition, which compilers know to be false by now.
    return gone != wanted;
}
#endif
