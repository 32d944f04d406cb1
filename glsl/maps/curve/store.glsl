// Stores a finished curve, exactly once in every path, so that rounding never accumulates. Include it after the declaration of `uvec2
// nodes[]`, which has the layout of maps/curve/node.glsl.
#ifndef MAPS_CURVE_STORE_GLSL
#define MAPS_CURVE_STORE_GLSL
#extension GL_EXT_control_flow_attributes : require
#include "maps/curve/pack.glsl"

void store_curve(uint texel, Node curve[NODES]) {
    uint at = texel * curve_pairs();
    if (!PACKED) {
        [[unroll]] for (int i = 0; i < NODES; ++i) {
            nodes[at + i] = uvec2(floatBitsToUint(curve[i].depth), floatBitsToUint(curve[i].value));
        }
        return;
    }
    if (TIGHT) {
        uint word = 0u;
        [[unroll]] for (int i = 0; i < NODES; i += 4) {
            uint words[4];
            [[unroll]] for (int j = 0; j < 4; ++j) {
                word = pack_node(word, curve[i + j], vec2(0.0, 1.0));
                words[j] = word;
            }
            nodes[at + i / 4] = uvec2(words[0] | words[1] << 16, words[2] | words[3] << 16);
        }
        return;
    }
    vec2 range = vec2(curve[0].depth);
    [[unroll]] for (int i = 1; i < NODES; ++i) {
        range.y = curve[i].depth < EMPTY ? curve[i].depth : range.y;
    }
    range.y -= range.x;
    nodes[at] = floatBitsToUint(range);
    uint before = 0u;
    [[unroll]] for (int i = 0; i < NODES; i += 2) {
        uint even = pack_node(before, curve[i], range);
        before = pack_node(even, curve[i + 1], range);
        nodes[at + 1 + i / 2] = uvec2(even, before);
    }
}

// set 2: curves
#ifdef MAPS_CURVE_CURVE_GLSL
// The same buffer as `nodes`. Full nodes are stored as two floats each: if each is stored as one uvec2, NVIDIA 580.159 takes seven times as
// long to build curves of 16 nodes.
layout(set = 2, binding = 2, scalar) writeonly buffer FullNodes { Node full_nodes[]; };

// Stores the curve of maps/curve/curve.glsl.
void store_curve(uint texel) {
    if (PACKED) {
        Node curve[NODES];
        [[unroll]] for (int i = 0; i < NODES; ++i) {
            curve[i] = curve_node(i);
        }
        store_curve(texel, curve);
        return;
    }
    [[unroll]] for (int i = 0; i < NODES; ++i) {
        full_nodes[texel * NODES + i] = curve_node(i);
    }
}
#endif
#endif
