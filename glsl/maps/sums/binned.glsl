// Sums over the casters on each texel's ray. A tile's workgroup first finds where the casters on each texel's ray begin and end, then adds
// each caster's part to each of the texel's sums. It writes each texel once. Twin: reference::twin::texel_sums.
// Invariant: the sums are of integers and ends are extremes, so the result depends only on the casters, not on their order.
// A technique declares before inclusion:
//   SUMS: number of sums per texel;
//   void segment_parts(vec2 place, float optical_depth, out float parts[SUMS]): what a segment between two places of the range adds to
//     each sum, a number from -optical_depth to optical_depth; the segment of a strand has no length;
//   void store_sums(uint texel, vec2 range, float sums[SUMS]): writes the texel's words (maps/sums/set.glsl).
#ifndef MAPS_SUMS_BINNED_GLSL
#define MAPS_SUMS_BINNED_GLSL
layout(local_size_x = 8, local_size_y = 8) in;
const uint THREADS = 64u;
#include "maps/bins/batch.glsl"
#include "maps/bins/scale.glsl"
#include "maps/sums/range.glsl"

// Depths at which the casters on a ray begin and end. All threads of the workgroup must call it with the same part.
vec2 binned_ends(TilePart part, View view, Ray ray, float ray_length) {
    vec2 ends = vec2(FARTHEST, -FARTHEST);
    for (uint begin = 0u; begin < part.count; begin += batch_size()) {
        uint filled = min(batch_size(), part.count - begin);
        fetch_batch(view, part.first + begin, filled);
        for (uint i = 0u; i < filled; ++i) {
            vec2 z;
            float optical_depth;
            if (view_segment(view, ray, ray_length, batch_caster(i), DARK, z, optical_depth) && optical_depth > 0.0) {
                ends = vec2(min(ends.x, z.x), max(ends.y, z.y));
            }
        }
    }
    return ends.x > ends.y ? ends : vec2(view_depth(view, ends.x), view_depth(view, ends.y));
}

void main() {
    TilePart part;
    if (!listed_part(part)) {
        return;
    }
    View view = maps[part_map(part)].caster_view;
    uvec2 texel = part_corner(view, part) + gl_LocalInvocationID.xy;
    Ray ray = view_texel_ray(view, texel);
    float ray_length = length(ray.direction), scale = tile_scale(part);
    vec2 range = range_of(SUM_RANGE == RANGE_SCENE ? vec2(0.0, 1.0) : binned_ends(part, view, ray, ray_length));
    int units[SUMS];
    for (uint k = 0u; k < SUMS; ++k) {
        units[k] = 0;
    }
    for (uint begin = 0u; begin < part.count; begin += batch_size()) {
        uint filled = min(batch_size(), part.count - begin);
        fetch_batch(view, part.first + begin, filled);
        for (uint i = 0u; i < filled; ++i) {
            vec2 z;
            float optical_depth;
            if (view_segment(view, ray, ray_length, batch_caster(i), DARK, z, optical_depth) && optical_depth > 0.0) {
                float parts[SUMS];
                vec2 depth = vec2(view_depth(view, z.x), view_depth(view, z.y));
                segment_parts(vec2(range_place(range, depth.x), range_place(range, depth.y)), optical_depth, parts);
                for (uint k = 0u; k < SUMS; ++k) {
                    units[k] += int(floor(parts[k] * scale + 0.5));
                }
            }
        }
    }
    end_part(part);
    if (all(lessThan(texel, uvec2(view.width, view.height)))) {
        float sums[SUMS];
        for (uint k = 0u; k < SUMS; ++k) {
            sums[k] = float(units[k]) / scale;
        }
        store_sums(part_texel(view, part, texel), range, sums);
    }
}
#endif
