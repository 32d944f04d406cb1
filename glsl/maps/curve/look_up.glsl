// Looks up stored curves in maps, with any filter and through levels of detail. Source: Fife and Strugar 2013, Sampling from the AVSM data
// structure. A technique defines MAP_TRANSMITTANCE first, as leveled_transmittance or as a function that calls it.
//   binding 3  curves, map-major, then texel rows, then a texel's curve in the layout of maps/curve/node.glsl; then the curves of
//              coarser levels, in the layout of maps/level_place.glsl
//   binding 4  words, one per tile of 8×8 texels, map-major, tile rows: 0 if the tile has no curves (any buffer if TILED is false)
#ifndef MAPS_CURVE_LOOK_UP_GLSL
#define MAPS_CURVE_LOOK_UP_GLSL
#include "maps/curve/pack.glsl"
#include "maps/curve/tiled.glsl"
#include "maps/levels.glsl"

layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityNodes { uvec2 visibility_nodes[]; };
layout(set = GOBO_SET, binding = 4, scalar) readonly buffer VisibilityTiles { uint visibility_tiles[]; };

uvec2 curve_pair(uint i) { return visibility_nodes[i]; }

#include "maps/curve/read.glsl"

// Curves of skipped tiles were never written and are not read.
bool texel_empty(LookUp l, ivec2 texel) {
    uvec2 tiles = (uvec2(l.view.width, l.view.height) + 7u) / 8u;
    uvec2 tile = uvec2(texel) / 8u;
    return TILED && tile_skipped(visibility_tiles[(l.map * tiles.y + tile.y) * tiles.x + tile.x]);
}

// Transmittance at `depth` on the curve of texel `place`: a coarse search over every fourth node, then four compares.
float curve_transmittance_at(uint place, float depth) {
    uint at = place * curve_pairs();
    vec2 range = curve_range(at);
    uint group = 0u;
    for (uint i = 4u; i < NODES; i += 4u) {
        group = texel_node(at, i, range).depth <= depth ? i : group;
    }
    uint before = group;
    for (uint i = 0u; i < 4u; ++i) {
        before += uint(texel_node(at, group + i, range).depth <= depth);
    }
    // `before`: number of nodes at or in front of the depth.
    if (before == 0u) {
        return 1.0;
    }
    Node near = texel_node(at, before - 1u, range);
    Node far = texel_node(at, min(before, NODES - 1u), range);
    float along = far.depth > near.depth ? clamp((depth - near.depth) / (far.depth - near.depth), 0.0, 1.0) : 0.0;
    return curve_transmittance(mix(near.value, far.value, along));
}

float texel_transmittance(LookUp l, ivec2 texel) {
    // Coarser levels are written everywhere.
    bool empty = l.first == 0u && texel_empty(l, texel);
    return empty ? 1.0 : curve_transmittance_at(texel_place(l, texel), l.depth);
}
#endif
