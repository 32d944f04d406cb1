// Deep shadow map look-up: how much of light `light` reaches `position`, 0 to 1. Source: Lokovic and Veach 2000.
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  nodes of all texels, as words, laid out as in technique/deep_shadow_map/node.glsl
//   binding 4  index of each texel's first node, map by map, rows of tiles of 8×8 texels, rows of texels within a tile; then one more word,
//              the end of the last texel's nodes
// Set the specialization constant PACKED to the value that the nodes were stored with.
// flat: bindings 136, constants 272: PACKED FILTER FILTER_RADIUS
#include "technique/deep_shadow_map/node.glsl"
#include "maps/look_up.glsl"

layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityNodes { uint visibility_nodes[]; };
layout(set = GOBO_SET, binding = 4, scalar) readonly buffer VisibilityStarts { uint visibility_starts[]; };

// Returns a node's depth, which is in its first word.
float node_depth(uint i) {
    uint word = visibility_nodes[i * node_words()];
    return PACKED ? unpack_depth(word) : uintBitsToFloat(word);
}

float node_value(uint i) {
    uint word = visibility_nodes[i * node_words() + node_words() - 1u];
    return PACKED ? unpack_value(word) : uintBitsToFloat(word);
}

float texel_transmittance(LookUp l, ivec2 texel) {
    uvec2 tiles = (uvec2(l.view.width, l.view.height) + 7u) / 8u, tile = uvec2(texel) / 8u, within = uvec2(texel) % 8u;
    uint place = ((l.map * tiles.y + tile.y) * tiles.x + tile.x) * 64u + within.y * 8u + within.x;
    uint first = visibility_starts[place], end = visibility_starts[place + 1u];
    // Finds the first node behind the depth.
    uint low = first, high = end;
    while (low < high) {
        uint middle = (low + high) / 2u;
        bool is_behind = node_depth(middle) > l.depth;
        low = is_behind ? low : middle + 1u;
        high = is_behind ? middle : high;
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
    }
    if (low == first) {
        return 1.0;
    }
    uint last = min(low, end - 1u);
    float near = node_depth(low - 1u), far = node_depth(last);
    float along = far > near ? clamp((l.depth - near) / (far - near), 0.0, 1.0) : 0.0;
    return exp(-mix(node_value(low - 1u), node_value(last), along));
}
