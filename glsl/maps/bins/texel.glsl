// Which rays a texel of a curve or of sums stands for: the ray through its centre, or all rays through its square.
#ifndef MAPS_BINS_TEXEL_GLSL
#define MAPS_BINS_TEXEL_GLSL
#include "world/caster.glsl"

// False: the ray through its centre. True: the mean of all rays through it.
CONSTANT(bool, AREA, false)

// How far a texel's rays are from its centre at most, in texels along an axis.
const float TEXEL_REACH = AREA ? 0.5 : 0.0;

// A texel's sides, in world units, where the rays' parameter is z.
vec2 texel_sides(View view, float z) {
    return abs(2.0 / (vec2(view.width, view.height) * vec2(view.scale_x, view.scale_y))) *
           (view.projection == VIEW_PARALLEL ? 1.0 : z);
}

// The texels, low to high and not rounded, whose centres (with AREA: whose squares) a caster in the view's axes reaches. They
// may lie outside of the map. False where there is none.
bool texel_bounds(View view, Caster caster, out vec2 low, out vec2 high) {
    bool ahead = view_caster_bounds(view, caster, low, high);
    vec2 size = vec2(view.width, view.height);
    // Texel i has its centre at i + 0.5.
    low = (low * 0.5 + 0.5) * size - 0.5 - TEXEL_REACH;
    high = (high * 0.5 + 0.5) * size - 0.5 + TEXEL_REACH;
    return ahead;
}
#endif
