// Adds a caster to each sum of a texel, by blending. Twin: reference::twin::texel_sums. Invariant: the order of casters affects only the
// rounding of sums; primitives blend in drawing order. A technique declares before inclusion: SUMS and segment_parts, as for
// maps/sums/binned.glsl, and TARGETS, at least a quarter of SUMS.
#ifndef MAPS_SUMS_RASTER_GLSL
#define MAPS_SUMS_RASTER_GLSL
#define QUADS_FRAGMENT
#include "maps/caster_quads.glsl"
#include "maps/sums/range.glsl"

// set 2: maps_ends
layout(set = 2, binding = 0, scalar) readonly buffer Ends { uint ends[]; };

layout(location = 0) out vec4 targets[TARGETS];

void main() {
    View view = maps[map].caster_view;
    vec2 depth;
    float optical_depth;
    if (!quad_part(view, DARK, depth, optical_depth) || optical_depth <= 0.0) {
        discard;
    }
    vec2 range = vec2(0.0, 1.0);
    if (SUM_RANGE != RANGE_SCENE) {
        uvec2 at = uvec2(gl_FragCoord.xy);
        uint texel = at.y * view.width + at.x;
        range = range_of_words(uvec2(ends[2u * texel], ends[2u * texel + 1u]));
    }
    float parts[SUMS];
    segment_parts(vec2(range_place(range, depth.x), range_place(range, depth.y)), optical_depth, parts);
    for (uint i = 0u; i < TARGETS; ++i) {
        vec4 four = vec4(0.0);
        for (uint k = 0u; k < 4u; ++k) {
            if (4u * i + k < SUMS) {
                four[k] = parts[4u * i + k];
            }
        }
        targets[i] = four;
    }
}
#endif
