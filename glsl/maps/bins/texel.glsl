// Which rays through its square a texel of a curve or of sums stands for.
#ifndef MAPS_BINS_TEXEL_GLSL
#define MAPS_BINS_TEXEL_GLSL
#include "world/caster.glsl"

// False: the ray through its centre. True: the mean of all rays through it.
CONSTANT(bool, AREA, false)

// How far, in texels, it reaches from its centre.
const float TEXEL_REACH = AREA ? 0.5 : 0.0;

// Its sides where the rays' parameter is z, world units.
vec2 texel_sides(View view, float z) {
    return abs(2.0 / (vec2(view.width, view.height) * vec2(view.scale_x, view.scale_y))) *
           (view.projection == VIEW_PARALLEL ? 1.0 : z);
}

// Texels low to high, not rounded, that a caster in the view's axes reaches, their centres or with AREA their squares; they may
// lie outside of the map. False where there is none.
bool texel_bounds(View view, Caster caster, out vec2 low, out vec2 high) {
    bool ahead = view_caster_bounds(view, caster, low, high);
    vec2 size = vec2(view.width, view.height);
    // Texel i has its centre at i + 0.5.
    low = (low * 0.5 + 0.5) * size - 0.5 - TEXEL_REACH;
    high = (high * 0.5 + 0.5) * size - 0.5 + TEXEL_REACH;
    return ahead;
}
#endif
