// Encoding of packed curves: a node is a word of 16 bits of depth, within the texel's own range, and 16 bits of value. Both are rounded to
// nearest, and both are 0 for a node at the very front without shadow. With TIGHT, depth and value have 8 bits each, and the depth is
// within the light's range. Twin: reference::twin::avsm::pack. Invariant: words keep the order of nodes; without TIGHT, the depth of a
// curve's first node is kept bit for bit.
#ifndef MAPS_CURVE_PACK_GLSL
#define MAPS_CURVE_PACK_GLSL
#include "maps/curve/node.glsl"

// A shorter range counts as empty: its inverse would overflow.
const float LEAST_EXTENT = 1e-30;

// Number of bits in a code, and number of codes.
const uint CODE_BITS = TIGHT ? 8u : 16u;
const uint CODES = 1u << CODE_BITS;
float last_code() { return TIGHT ? 255.0 : 65535.0; }

// `range`: depth of the texel's first node, and distance from there to the last node.
uint pack_depth(float depth, vec2 range) {
    return range.y > LEAST_EXTENT ? uint(min((depth - range.x) * (last_code() / range.y) + 0.5, last_code())) : 0u;
}

float unpack_depth(uint code, vec2 range) { return range.x + float(code) * (range.y * (1.0 / last_code())); }

// A transmittance is encoded in equal steps. An optical depth t is encoded as t / (1 + t), in equal steps. Rounding to the nearest code,
// which is off by up to half a step, changes the transmittance by at most 2 / e times the step of an equally spaced transmittance. Where it
// is dark, half a step is still a small fraction of t, so that a ramp into darkness fades smoothly.
uint pack_value(float value) {
    float code = EXPONENTIAL ? float(CODES) * (value / (1.0 + value)) : last_code() * (1.0 - value);
    return uint(clamp(code + 0.5, 0.0, last_code()));
}

float unpack_value(uint code) {
    return EXPONENTIAL ? float(code) / float(CODES - code) : float(CODES - 1u - code) / last_code();
}

// Encodes a node as a word, given the word of the node before it (0 for the first). Rounding never changes the order of nodes. The word of
// an unused node repeats the word before.
uint pack_node(uint before, Node node, vec2 range) {
    if (node.depth >= EMPTY) {
        return before;
    }
    uint depth = max(pack_depth(node.depth, range), before >> CODE_BITS);
    uint value = max(pack_value(node.value), before & (CODES - 1u));
    return depth << CODE_BITS | value;
}

Node unpack_node(uint word, vec2 range) {
    return Node(unpack_depth(word >> CODE_BITS, range), unpack_value(word & (CODES - 1u)));
}
#endif
