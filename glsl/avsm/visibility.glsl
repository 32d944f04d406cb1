// AVSM look-up: how much of light `light` reaches `position`, 0 to 1. Source: seed 000 (sampling).
//
// To use it elsewhere: define GOBO_SET (a descriptor set number, default 1) if set 1 is taken, include this file, and bind
//   binding 0  readonly buffer: Light[] (common/light.glsl)
//   binding 1  readonly buffer: Node[], light-major, then texel rows, then NODES nodes in order of depth
//   binding 2  texture2D: the opaque map of common/opaque_map.glsl (any 1×1 image where has_opaque is 0)
//   binding 3  readonly buffer: uint[], casters in each tile of 8×8 texels, tile rows (any buffer where TILED is 0)
// with specialization constants 0 (NODES), 1 (EXPONENTIAL) and 5 (TILED) as the curves were built.
#include "avsm/node.glsl"
#include "common/opaque_map.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1, scalar) readonly buffer VisibilityNodes { Node visibility_nodes[]; };
layout(set = GOBO_SET, binding = 2) uniform texture2D visibility_opaque;
layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityTiles { uint visibility_tiles[]; };

// 1: curves of tiles without casters were never written and are not read. 0: every curve was written.
layout(constant_id = 5) const uint TILED = 0u;

bool texel_empty(View view, ivec2 texel) {
    uint tiles_x = (view.width + 7u) / 8u;
    return TILED == 1u && visibility_tiles[(uint(texel.y) / 8u) * tiles_x + uint(texel.x) / 8u] == 0u;
}

// Transmittance of one texel's curve: a coarse search over every fourth node, then four compares.
float texel_transmittance(uint first, float depth) {
    uint group = 0u;
    for (uint i = 4u; i < NODES; i += 4u) {
        group = visibility_nodes[first + i].depth <= depth ? i : group;
    }
    uint before = group;
    for (uint i = 0u; i < 4u; ++i) {
        before += uint(visibility_nodes[first + group + i].depth <= depth);
    }
    // `before` nodes are at or in front of `depth`.
    if (before == 0u) {
        return 1.0;
    }
    Node near = visibility_nodes[first + before - 1u];
    Node far = visibility_nodes[first + min(before, NODES - 1u)];
    float along = far.depth > near.depth ? clamp((depth - near.depth) / (far.depth - near.depth), 0.0, 1.0) : 0.0;
    return curve_transmittance(mix(near.value, far.value, along));
}

float light_visibility(uint light, vec3 position) {
    View view = visibility_lights[light].volume;
    vec3 at = view_project(view, position);
    float opaque = opaque_visibility(visibility_lights[light], visibility_opaque, position);
    if (!(at.z > view.near)) {
        return opaque;  // in front of all casters
    }
    float depth = view_depth(view, at.z);
    Footprint footprint = view_footprint(view, at.xy);
    float transmittance = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 texel = footprint.corner + ivec2(i & 1, i >> 1);
        // The map is fitted to the casters: past its edge there is nothing to lose light to.
        uint index = (light * view.height + uint(texel.y)) * view.width + uint(texel.x);
        float through = view_has(view, texel) && !texel_empty(view, texel) ? texel_transmittance(index * NODES, depth) : 1.0;
        transmittance += footprint.weights[i] * through;
    }
    return transmittance * opaque;
}
