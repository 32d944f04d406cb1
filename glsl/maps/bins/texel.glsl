// Which rays a texel of a curve or of sums represents: the ray through its centre, or all rays through its square.
#ifndef MAPS_BINS_TEXEL_GLSL
#define MAPS_BINS_TEXEL_GLSL
#include "world/caster.glsl"

// False: a texel is the ray through its centre. True: a texel is the mean of all rays through it.
CONSTANT(bool, AREA, false)

// Largest distance of a texel's rays from its centre, in texels along an axis.
const float TEXEL_REACH = AREA ? 0.5 : 0.0;

// Lengths of a texel's sides, in world units, where the rays' parameter is z.
vec2 texel_sides(View view, float z) {
    return abs(2.0 / (vec2(view.width, view.height) * vec2(view.scale_x, view.scale_y))) *
           (view.projection == VIEW_PARALLEL ? 1.0 : z);
}

// The texels, low to high and not rounded, whose centres (with AREA: whose squares) are within the bounds of a caster in the view's axes.
// They may be outside the map. False if there are none.
bool texel_bounds(View view, Caster caster, out vec2 low, out vec2 high) {
    bool ahead = view_caster_bounds(view, caster, low, high);
    vec2 size = vec2(view.width, view.height);
    // Texel i has its centre at i + 0.5.
    low = (low * 0.5 + 0.5) * size - 0.5 - TEXEL_REACH;
    high = (high * 0.5 + 0.5) * size - 0.5 + TEXEL_REACH;
    return ahead;
}
#endif
