// AVSM look-up: how much of light `light` reaches `position`, 0 to 1. Source: Fife and Strugar 2013, Sampling from the AVSM data structure.
// Bindings 0 to 2: maps/look_up.glsl, which says how to use this elsewhere. Then
//   binding 3  readonly buffer: uvec2[], map-major, then texel rows, then a texel's curve as avsm/node.glsl states it
//   binding 4  readonly buffer: uint[], casters in each tile of 8×8 texels, map-major, tile rows (any buffer where TILED is false)
// Specialization constants NODES, EXPONENTIAL, TILED and PACKED as the curves were built.
#include "avsm/pack.glsl"
#include "avsm/tiled.glsl"
#include "maps/look_up.glsl"

layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityNodes { uvec2 visibility_nodes[]; };
layout(set = GOBO_SET, binding = 4, scalar) readonly buffer VisibilityTiles { uint visibility_tiles[]; };

// Curves of tiles that were skipped were never written and are not read.
bool texel_empty(LookUp l, ivec2 texel) {
    uvec2 tiles = (uvec2(l.view.width, l.view.height) + 7u) / 8u;
    uvec2 tile = uvec2(texel) / 8u;
    return TILED && tile_skipped(visibility_tiles[(l.map * tiles.y + tile.y) * tiles.x + tile.x]);
}

// Node i of the curve at `at`; `range` is that of a packed curve.
Node texel_node(uint at, uint i, vec2 range) {
    if (PACKED) {
        uvec2 words = visibility_nodes[at + 1u + i / 2u];
        return unpack_node(i % 2u == 0u ? words.x : words.y, range);
    }
    uvec2 bits = visibility_nodes[at + i];
    return Node(uintBitsToFloat(bits.x), uintBitsToFloat(bits.y));
}

// Of one texel's curve: a coarse search over every fourth node, then four compares.
float texel_transmittance(LookUp l, ivec2 texel) {
    if (texel_empty(l, texel)) {
        return 1.0;
    }
    uint at = ((l.map * l.view.height + uint(texel.y)) * l.view.width + uint(texel.x)) * curve_pairs();
    vec2 range = PACKED ? uintBitsToFloat(visibility_nodes[at]) : vec2(0.0);
    uint group = 0u;
    for (uint i = 4u; i < NODES; i += 4u) {
        group = texel_node(at, i, range).depth <= l.depth ? i : group;
    }
    uint before = group;
    for (uint i = 0u; i < 4u; ++i) {
        before += uint(texel_node(at, group + i, range).depth <= l.depth);
    }
    // `before` nodes are at or in front of the depth.
    if (before == 0u) {
        return 1.0;
    }
    Node near = texel_node(at, before - 1u, range);
    Node far = texel_node(at, min(before, NODES - 1u), range);
    float along = far.depth > near.depth ? clamp((l.depth - near.depth) / (far.depth - near.depth), 0.0, 1.0) : 0.0;
    return curve_transmittance(mix(near.value, far.value, along));
}
