// AVSM look-up: how much of light `light` reaches `position`, 0 to 1. Source: seed 000 (sampling).
//
// To use it elsewhere: define GOBO_SET (a descriptor set number, default 1) if set 1 is taken, include this file, and bind
//   binding 0  readonly buffer: Light[] (common/light.glsl)
//   binding 1  readonly buffer: uvec2[], map-major, then texel rows, then a texel's curve as avsm/node.glsl states it
//   binding 2  texture2D: the opaque map of common/opaque_map.glsl (any 1×1 image where has_opaque is 0)
//   binding 3  readonly buffer: uint[], casters in each tile of 8×8 texels, map-major, tile rows (any buffer where TILED is 0)
//   binding 4  readonly buffer: Map[] (common/light.glsl)
// with specialization constants 0 (NODES), 1 (EXPONENTIAL), 5 (TILED) and 8 (PACKED) as the curves were built, and 6
// (FILTER) and 7 (FILTER_RADIUS) of common/filter.glsl. A point light's faces have room for every filter about their 90 degrees, so
// that no look-up needs two of them.
#define FILTER_CONSTANT 6
#include "avsm/pack.glsl"
#include "common/filter.glsl"
#include "common/opaque_map.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1, scalar) readonly buffer VisibilityNodes { uvec2 visibility_nodes[]; };
layout(set = GOBO_SET, binding = 2) uniform texture2D visibility_opaque;
layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityTiles { uint visibility_tiles[]; };
layout(set = GOBO_SET, binding = 4, scalar) readonly buffer VisibilityMaps { Map visibility_maps[]; };

// 1: curves of tiles without casters were never written and are not read. 0: every curve was written.
layout(constant_id = 5) const uint TILED = 0u;

bool texel_empty(View view, uint map, ivec2 texel) {
    uvec2 tiles = (uvec2(view.width, view.height) + 7u) / 8u;
    uvec2 tile = uvec2(texel) / 8u;
    return TILED == 1u && visibility_tiles[(map * tiles.y + tile.y) * tiles.x + tile.x] == 0u;
}

// Node i of the curve at `at`; `range` is that of a packed curve.
Node texel_node(uint at, uint i, vec2 range) {
    if (PACKED == 1u) {
        uvec2 words = visibility_nodes[at + 1u + i / 2u];
        return unpack_node(i % 2u == 0u ? words.x : words.y, range);
    }
    uvec2 bits = visibility_nodes[at + i];
    return Node(uintBitsToFloat(bits.x), uintBitsToFloat(bits.y));
}

// Transmittance of one texel's curve: a coarse search over every fourth node, then four compares.
float texel_transmittance(uint texel, float depth) {
    uint at = texel * curve_pairs();
    vec2 range = PACKED == 1u ? uintBitsToFloat(visibility_nodes[at]) : vec2(0.0);
    uint group = 0u;
    for (uint i = 4u; i < NODES; i += 4u) {
        group = texel_node(at, i, range).depth <= depth ? i : group;
    }
    uint before = group;
    for (uint i = 0u; i < 4u; ++i) {
        before += uint(texel_node(at, group + i, range).depth <= depth);
    }
    // `before` nodes are at or in front of `depth`.
    if (before == 0u) {
        return 1.0;
    }
    Node near = texel_node(at, before - 1u, range);
    Node far = texel_node(at, min(before, NODES - 1u), range);
    float along = far.depth > near.depth ? clamp((depth - near.depth) / (far.depth - near.depth), 0.0, 1.0) : 0.0;
    return curve_transmittance(mix(near.value, far.value, along));
}

float light_visibility(uint light, vec3 position) {
    uint map = light_map(visibility_lights[light], position);
    View view = visibility_maps[map].volume, opaque_view = visibility_maps[map].opaque;
    float opaque = opaque_visibility(visibility_lights[light], opaque_view, map, visibility_opaque, position);
    vec3 at = view_project(view, position);
    if (!(at.z > view.near)) {
        return opaque;  // in front of all casters
    }
    float depth = view_depth(view, at.z);
    Filter f = filter_at(view, at.xy);
    float transmittance = 0.0;
    for (int i = 0; i < filter_side() * filter_side(); ++i) {
        ivec2 texel = filter_texel(f, i);
        // The map is fitted to the casters: past its edge there is nothing to lose light to.
        uint index = (map * view.height + uint(texel.y)) * view.width + uint(texel.x);
        bool empty = !view_has(view, texel) || texel_empty(view, map, texel);
        float through = empty ? 1.0 : texel_transmittance(index, depth);
        transmittance += filter_weight(f, i) * through;
    }
    return transmittance * opaque;
}
