#version 460
// Builds each texel's list of segments from the casters of its tile, for a group of maps. One workgroup per tile. Inputs: maps, casters,
// parts, entries. Outputs: heads, segments, the count of fragments. Invariant: the count includes fragments that did not fit into the
// buffer, so that the caller can grow the buffer.
#include "technique/deep_shadow_map/maps.glsl"
#include "maps/bins/area.glsl"
#include "maps/bins/part.glsl"

const uint THREADS = 64u;
layout(local_size_x = THREADS) in;
#include "maps/bins/batch.glsl"

// set 2: list
layout(set = 2, binding = 0, r32ui) uniform writeonly uimage2D heads;
layout(set = 2, binding = 1, std430) writeonly buffer Segments { uvec4 segments[]; };
layout(set = 2, binding = 2, scalar) buffer Counters { uint counters[]; };

void main() {
    TilePart tile;
    if (!listed_part(tile) || part_map(tile) < first_map || part_map(tile) >= first_map + map_count) {
        return;
    }
    View view = part_view(tile);
    uvec2 texel = part_corner(view, tile) + uvec2(gl_LocalInvocationIndex % 8u, gl_LocalInvocationIndex / 8u);
    bool within = all(lessThan(texel, uvec2(view.width, view.height)));
    Ray ray = view_texel_ray(view, texel);
    float ray_length = length(ray.direction);
    uint head = NO_SEGMENT;
    for (uint begin = 0u; begin < tile.count; begin += batch_size()) {
        uint filled = min(batch_size(), tile.count - begin);
        fetch_batch(view, tile.first + begin, filled);
        for (uint i = 0u; within && i < filled; ++i) {
            vec2 z;
            float optical_depth;
            if (!texel_part(view, ray, ray_length, batch_caster(i), MAX_OPTICAL_DEPTH, z, optical_depth)) {
                continue;
            }
            uint index = atomicAdd(counters[FRAGMENTS + group], 1u);
            if (index < segment_room) {
                vec2 depth = vec2(view_depth(view, z.x), view_depth(view, z.y));
                segments[index] = segment_words(Segment(depth.x, depth.y, optical_depth, head));
                head = index;
            }
        }
    }
    end_part(tile);
    if (within) {
        imageStore(heads, ivec2(texel + uvec2(0u, (part_map(tile) - first_map) * view.height)), uvec4(head, 0u, 0u, 0u));
    }
}
