// Layout of nodes. A texel's nodes are sorted by depth, and stored texel by texel within a tile of 8×8 texels, tile by tile. Between two
// nodes the optical depth is linear, which is exact within a sphere of constant extinction. Two nodes at the same depth form a step. In
// front of the first node the transmittance is 1; behind the last it stays constant. Twin: technique::NodeData.
#ifndef TECHNIQUE_DEEP_SHADOW_MAP_NODE_GLSL
#define TECHNIQUE_DEEP_SHADOW_MAP_NODE_GLSL

// False: a node is two words, the bits of its depth and value. True: a node is one word.
CONSTANT(bool, PACKED, false)

struct Node {
    float depth;  // in the light's range, 0 to 1
    float value;  // optical depth
};

uint node_words() { return PACKED ? 1u : 2u; }

// A packed node is one word: 18 bits of depth, and 14 bits of t / (1 + t), where t is the optical depth. Rounding t / (1 + t) by half a
// step changes the transmittance by at most 2 / e of a step of 2⁻¹⁴. Both codes preserve the order of nodes. Twin:
// technique::deep_shadow_map::curves::unpack.
const uint VALUE_BITS = 14u;
const float VALUE_CODES = 16384.0;
const float LAST_DEPTH = 262143.0;

uint pack_node(Node node) {
    uint value = uint(min(VALUE_CODES * (node.value / (1.0 + node.value)) + 0.5, VALUE_CODES - 1.0));
    return uint(node.depth * LAST_DEPTH + 0.5) << VALUE_BITS | value;
}

float unpack_depth(uint word) { return float(word >> VALUE_BITS) / LAST_DEPTH; }

float unpack_value(uint word) {
    float value = float(word & uint(VALUE_CODES - 1.0));
    return value / (VALUE_CODES - value);
}
#endif
