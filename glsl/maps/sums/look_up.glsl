// A texel's words in a look-up: its range, then so many words of the technique's.
#ifndef MAPS_SUMS_LOOK_UP_GLSL
#define MAPS_SUMS_LOOK_UP_GLSL
#include "maps/look_up.glsl"
#include "maps/sums/halves.glsl"
#include "maps/sums/range.glsl"

layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityWords { uint visibility_words[]; };

// Where a texel's words begin that stand behind its range.
uint texel_words_at(LookUp l, ivec2 texel, uint words) {
    uint place = (l.map * l.view.height + uint(texel.y)) * l.view.width + uint(texel.x);
    return place * (range_words() + words) + range_words();
}

// The place of the look-up's depth in the range of the texel whose words begin there.
float texel_place(LookUp l, uint at) {
    vec2 range = vec2(0.0, 1.0);
    if (SUM_RANGE != RANGE_SCENE) {
        range.x = uintBitsToFloat(visibility_words[at - range_words()]);
        range.y = SUM_RANGE == RANGE_FRONT ? 1.0 : uintBitsToFloat(visibility_words[at - 1u]);
    }
    return range_place(range, l.depth);
}

float visibility_word(uint at) { return uintBitsToFloat(visibility_words[at]); }

// Sum k of the texel whose words begin there.
float visibility_sum(uint at, uint k) {
    if (SUM_STORAGE == STORAGE_F32) {
        return visibility_word(at + k);
    }
    vec2 two = unpackHalf2x16(visibility_words[at + k / 2u]);
    return (k & 1u) == 0u ? two.x : two.y;
}
#endif
