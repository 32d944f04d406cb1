// Codes of packed curves: a node is a word of 16 bits of depth within the texel's own range and 16 bits of value, both
// rounded to nearest and both 0 for what is farthest in front and unshadowed. Twin: reference::twin::avsm::pack.
// Invariant: words keep the order of nodes; a curve's first node is kept to the bit in depth.
#ifndef AVSM_PACK_GLSL
#define AVSM_PACK_GLSL
#include "avsm/node.glsl"

// A range of less is none: its inverse would overflow.
const float LEAST_EXTENT = 1e-30;

// The depths of a texel's nodes: the first and how far the last is behind it.
uint pack_depth(float depth, vec2 range) {
    return range.y > LEAST_EXTENT ? uint(min((depth - range.x) * (65535.0 / range.y) + 0.5, 65535.0)) : 0u;
}

float unpack_depth(uint code, vec2 range) { return range.x + float(code) * (range.y * (1.0 / 65535.0)); }

// Transmittance is coded evenly. Of an optical depth t the code is t / (1 + t): half a code is at most 2 / e of 2^-16 of
// the light, and in the dark still a small share of t, so that a ramp into darkness fades as it should.
uint pack_value(float value) {
    float code = EXPONENTIAL ? 65536.0 * (value / (1.0 + value)) : 65535.0 * (1.0 - value);
    return uint(clamp(code + 0.5, 0.0, 65535.0));
}

float unpack_value(uint code) {
    return EXPONENTIAL ? float(code) / float(65536u - code) : float(65535u - code) / 65535.0;
}

// The word of a node, given that of the node before it (0 for the first). Rounding never turns the order of nodes, and an
// unused node repeats the last.
uint pack_node(uint before, Node node, vec2 range) {
    if (node.depth >= EMPTY) {
        return before;
    }
    uint depth = max(pack_depth(node.depth, range), before >> 16), value = max(pack_value(node.value), before & 0xFFFFu);
    return depth << 16 | value;
}

Node unpack_node(uint word, vec2 range) {
    return Node(unpack_depth(word >> 16, range), unpack_value(word & 0xFFFFu));
}
#endif
