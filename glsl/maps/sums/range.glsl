// Where on a texel's ray its sums are: at places from 0 to 1 of a range of depths. Twin: reference::twin::texel_sums.
#ifndef MAPS_SUMS_RANGE_GLSL
#define MAPS_SUMS_RANGE_GLSL
#include "world/view.glsl"

CONSTANT(uint, SUM_RANGE, 2u)  // which: 0 all of the map's depths, 1 as many from the texel's front on, 2 from its front to its back

const uint RANGE_SCENE = 0u;
const uint RANGE_FRONT = 1u;
const uint RANGE_TEXEL = 2u;

// Words of a texel in which its range is kept: the front, and the back.
uint range_words() { return SUM_RANGE; }

// The range of a texel whose casters begin and end at these depths; from FARTHEST to -FARTHEST where it has none.
vec2 range_of(vec2 ends) {
    if (ends.x > ends.y) {
        return vec2(0.0, SUM_RANGE == RANGE_TEXEL ? 0.0 : 1.0);
    }
    return SUM_RANGE == RANGE_SCENE   ? vec2(0.0, 1.0)
           : SUM_RANGE == RANGE_FRONT ? vec2(ends.x, ends.x + 1.0)
                                      : ends;
}

// A depth's place in the range. Compared first, so that of a range of no extent all is behind and not 0/0.
float range_place(vec2 range, float depth) {
    return depth >= range.y ? 1.0 : depth <= range.x ? 0.0 : min((depth - range.x) / (range.y - range.x), 1.0);
}
#endif
