// Deep shadow map look-up: how much of light `light` reaches `position`, 0 to 1. Source: Lokovic and Veach 2000.
// Bindings 0 to 2: maps/look_up_set.glsl. Then
//   binding 3  nodes of all texels, as technique/deep_shadow_map/node.glsl states them
//   binding 4  where each texel's nodes begin, map after map, tiles of 8×8 texels in rows, rows of a tile's texels; at last, where all end
// flat: bindings 136, constants 272: FILTER FILTER_RADIUS
#include "technique/deep_shadow_map/node.glsl"
#include "maps/look_up.glsl"

layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityNodes { vec2 visibility_nodes[]; };
layout(set = GOBO_SET, binding = 4, scalar) readonly buffer VisibilityStarts { uint visibility_starts[]; };

float texel_transmittance(LookUp l, ivec2 texel) {
    uvec2 tiles = (uvec2(l.view.width, l.view.height) + 7u) / 8u, tile = uvec2(texel) / 8u, within = uvec2(texel) % 8u;
    uint place = ((l.map * tiles.y + tile.y) * tiles.x + tile.x) * 64u + within.y * 8u + within.x;
    uint first = visibility_starts[place], end = visibility_starts[place + 1u];
    // The first node that is behind the depth.
    uint low = first, high = end;
    while (low < high) {
        uint middle = (low + high) / 2u;
        bool is_behind = visibility_nodes[middle].x > l.depth;
        low = is_behind ? low : middle + 1u;
        high = is_behind ? middle : high;
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
    }
    if (low == first) {
        return 1.0;
    }
    vec2 near = visibility_nodes[low - 1u], far = visibility_nodes[min(low, end - 1u)];
    float along = far.x > near.x ? clamp((l.depth - near.x) / (far.x - near.x), 0.0, 1.0) : 0.0;
    return exp(-mix(near.y, far.y, along));
}
