// What of its square a texel of a curve or a sum stands for.
#ifndef BINS_TEXEL_GLSL
#define BINS_TEXEL_GLSL
#include "world/view.glsl"

// False: the ray through its centre. True: the mean of all rays through it.
CONSTANT(bool, AREA, false)

// How far, in texels, it reaches from its centre.
const float TEXEL_REACH = AREA ? 0.5 : 0.0;

// Its sides where the rays' parameter is z, world units.
vec2 texel_sides(View view, float z) {
    return abs(2.0 / (vec2(view.width, view.height) * vec2(view.scale_x, view.scale_y))) *
           (view.projection == VIEW_PARALLEL ? 1.0 : z);
}
#endif
