#version 460
// Draws the depths at which the samples of a tile's texels end in its casters; the nearest end is kept. Source: Enderton et al. 2010; tiles
// are ours. Inputs: maps, casters, parts, entries. Output: samples. Twin: reference::twin::stochastic::draw. Invariant: a minimum of
// integers, so the bytes are the same in any order.
layout(local_size_x = 8, local_size_y = 8) in;
const uint THREADS = 64u;
#include "maps/bins/batch.glsl"
#include "technique/stochastic/draw.glsl"

// Not atomic: each texel belongs to one thread.
void keep_sample(uint place, uint bits) { samples[place] = min(samples[place], bits); }

void main() {
    TilePart part;
    if (!listed_part(part)) {
        return;
    }
    uint map = part_map(part);
    View view = maps[map].caster_view;
    uvec2 texel = part_corner(view, part) + gl_LocalInvocationID.xy;
    bool inside = all(lessThan(texel, uvec2(view.width, view.height)));
    uint first = first_sample(view, map, texel);
    for (uint i = 0u; i < SAMPLES && inside; ++i) {
        samples[first + i] = NO_END;
    }
    Ray ray = view_texel_ray(view, texel);
    float ray_length = length(ray.direction);
    for (uint begin = 0u; begin < part.count; begin += batch_size()) {
        uint filled = min(batch_size(), part.count - begin);
        fetch_batch(view, part.first + begin, filled);
        for (uint i = 0u; i < filled; ++i) {
            vec2 z;
            float optical_depth;
            if (view_segment(view, ray, ray_length, batch_caster(i), MAX_OPTICAL_DEPTH, z, optical_depth) && inside) {
                vec2 depth = vec2(view_depth(view, z.x), view_depth(view, z.y));
                // Numbered as in draw.frag: among the casters that the map sees.
                uint number = entries[part.first + begin + i].y - map_casters(map);
                draw_caster(texel, number, first, depth, optical_depth);
            }
        }
    }
    end_part(part);
}
