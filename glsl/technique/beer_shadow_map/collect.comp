#version 460
// Finds the nearest entry, the farthest exit and the optical depth of each texel's casters, and writes each texel once. Source: ours.
// Inputs: maps, casters, parts, entries. Output: texels. Twin: reference::twin::beer_shadow_map::collect. Invariant: sums are integers, so
// the result does not depend on the order of the casters. WEIGHTED_FRONT: the medium begins at the casters' mean depth, not at the first
// caster. Twin: weighted.
layout(local_size_x = 8, local_size_y = 8) in;
const uint THREADS = 64u;
#include "technique/beer_shadow_map/texel.glsl"
#include "maps/bins/batch.glsl"
#include "maps/bins/scale.glsl"

CONSTANT(bool, WEIGHTED_FRONT, false)

// set 2: maps_texels
layout(set = 2, binding = 0, rgba16f) uniform writeonly image2D texels;

// Rounds non-negative values to the nearest half floats, ties to even, so that drivers have nothing left to round differently.
vec4 nearest_half(vec4 value) {
    uvec4 bits = floatBitsToUint(value);
    vec4 nearest = uintBitsToFloat((bits + 0x0FFFu + (bits >> 13u & 1u)) & ~0x1FFFu);
    // Half floats below the smallest normal one, 2^-14, are multiples of 2^-24.
    vec4 small = roundEven(value * 16777216.0) * 5.9604644775390625e-8;
    return mix(nearest, small, lessThan(value, vec4(6.103515625e-5)));
}

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
    vec2 range = vec2(FARTHEST, -FARTHEST);
    for (uint begin = 0u; begin < part.count; begin += batch_size()) {
        uint filled = min(batch_size(), part.count - begin);
        fetch_batch(view, part.first + begin, filled);
        for (uint i = 0u; i < filled; ++i) {
            vec2 z;
            float optical_depth;
            if (view_segment(view, ray, ray_length, batch_caster(i), DARK, z, optical_depth) && optical_depth > 0.0) {
                range = vec2(min(range.x, z.x), max(range.y, z.y));
                sum += uint(optical_depth * scale + 0.5);
            }
        }
    }
    vec2 depth = vec2(view_depth(view, range.x), view_depth(view, range.y));
    if (WEIGHTED_FRONT) {
        // Mean of the casters' midpoints, as depths behind the front. A caster's weight is its optical depth times the transmittance of a
        // uniform medium from the front to the caster's midpoint. `weights` and `places` never exceed the sum of the optical depths, so
        // they do not overflow.
        float extinction = min(float(sum) / scale, DARK) / max(depth.y - depth.x, 1e-9);
        uint weights = 0u, places = 0u;
        for (uint begin = 0u; begin < part.count; begin += batch_size()) {
            uint filled = min(batch_size(), part.count - begin);
            fetch_batch(view, part.first + begin, filled);
            for (uint i = 0u; i < filled; ++i) {
                vec2 z;
                float optical_depth;
                if (view_segment(view, ray, ray_length, batch_caster(i), DARK, z, optical_depth) && optical_depth > 0.0) {
                    // max(…, 0): in a thin medium, rounding may put a midpoint just before the front, where its weight would be huge.
                    float place = max(0.5 * (view_depth(view, z.x) + view_depth(view, z.y)) - depth.x, 0.0);
                    float weight = optical_depth * exp(-extinction * place) * scale;
                    weights += uint(weight + 0.5);
                    places += uint(weight * place + 0.5);
                }
            }
        }
        depth += weights > 0u ? float(places) / float(weights) : 0.0;
    }
    end_part(part);
    if (all(lessThan(texel, uvec2(view.width, view.height)))) {
        vec4 value = range.x <= range.y ? beer_texel(depth, float(sum) / scale) : vec4(0.0);
        imageStore(texels, ivec2(texel + uvec2(0u, map * view.height)), nearest_half(value));
    }
}
