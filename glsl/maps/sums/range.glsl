// Maps depths on a texel's ray to places from 0 to 1 in the range of its sums. Twin: reference::twin::texel_sums.
#ifndef MAPS_SUMS_RANGE_GLSL
#define MAPS_SUMS_RANGE_GLSL
#include "world/view.glsl"

CONSTANT(uint, SUM_RANGE, 2u)  // range of the sums: 0 all of the map's depths, 1 from the first caster on, 2 first to last caster

const uint RANGE_SCENE = 0u;
const uint RANGE_FRONT = 1u;
const uint RANGE_TEXEL = 2u;

// Number of words of a texel that hold its range: none, the front, or the front and the back.
uint range_words() { return SUM_RANGE; }

// Range of a texel whose casters begin and end at these depths; without casters they are FARTHEST and -FARTHEST.
vec2 range_of(vec2 ends) {
    bool empty = ends.x > ends.y;
    return vec2(empty || SUM_RANGE == RANGE_SCENE ? 0.0 : ends.x,
                SUM_RANGE != RANGE_TEXEL ? 1.0 : empty ? 0.0 : ends.y);
}

// Range of a texel whose ends were drawn (maps/sums/ends.frag): two words, blended by maximum; 0 without casters.
vec2 range_of_words(uvec2 words) {
    return range_of(words.x == 0u ? vec2(FARTHEST, -FARTHEST) : uintBitsToFloat(uvec2(~words.x, words.y)));
}

// Place of a depth in the range. The comparisons come first, so that behind an empty range the place is 1, and not 0/0.
float range_place(vec2 range, float depth) {
    return depth >= range.y ? 1.0 : depth <= range.x ? 0.0 : min((depth - range.x) / (range.y - range.x), 1.0);
}
#endif
