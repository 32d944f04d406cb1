#version 460
// Computes the product of the transmittances of each texel's casters, and writes each texel once. Source: ours. Inputs: maps, casters,
// parts, entries. Output: transmittance. Twin: reference::twin::translucency_map::sum. Invariant: sums are integers, so the result does not
// depend on the order of the casters.
// variants: BITS 8 16
layout(local_size_x = 8, local_size_y = 8) in;
const uint THREADS = 64u;
#include "maps/bins/batch.glsl"
#include "maps/bins/scale.glsl"

#if BITS == 8
#define TEXEL_FORMAT r8
#else
#define TEXEL_FORMAT r16f
#endif
// set 2: maps_texels
layout(set = 2, binding = 0, TEXEL_FORMAT) uniform writeonly image2D texels;

void main() {
    TilePart part;
    if (!listed_part(part)) {
        return;
    }
    uint map = part_map(part), sum = 0u;
    View view = maps[map].caster_view;
    uvec2 texel = part_corner(view, part) + gl_LocalInvocationID.xy;
    Ray ray = view_texel_ray(view, texel);
    float ray_length = length(ray.direction), scale = tile_scale(part);
    for (uint begin = 0u; begin < part.count; begin += batch_size()) {
        uint filled = min(batch_size(), part.count - begin);
        fetch_batch(view, part.first + begin, filled);
        for (uint i = 0u; i < filled; ++i) {
            vec2 z;
            float optical_depth;
            if (view_segment(view, ray, ray_length, batch_caster(i), DARK, z, optical_depth)) {
                sum += uint(optical_depth * scale + 0.5);
            }
        }
    }
    end_part(part);
    if (all(lessThan(texel, uvec2(view.width, view.height)))) {
        imageStore(texels, ivec2(texel + uvec2(0u, map * view.height)), vec4(exp(-float(sum) / scale)));
    }
}
