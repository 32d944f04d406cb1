// What a texel's transmittance curve is stored as: curve_pairs() pairs of words. In full, each is the bits of a Node. Packed,
// the first is the bits of the first node's depth and of how far the last node is behind it, the others hold two nodes
// each, as avsm/pack.glsl codes them: 8 + 4 NODES bytes. Twin: technique::avsm::NodeData.
#ifndef AVSM_NODE_GLSL
#define AVSM_NODE_GLSL

layout(constant_id = 0) const int NODES = 8;
// 0: values are transmittances, interpolated linearly (the seed). 1: values are optical depths, interpolated linearly,
// which is exact within a sphere of constant extinction.
layout(constant_id = 1) const uint EXPONENTIAL = 1u;

// 0: full. 1: packed.
layout(constant_id = 8) const uint PACKED = 0u;

// Depth of an unused node. Its value is that of the last used one.
const float EMPTY = 3e38;

struct Node {
    float depth;  // in the light's range, 0 to 1
    float value;
};

// Pairs of words that a texel has.
uint curve_pairs() { return PACKED == 1u ? uint(1 + NODES / 2) : uint(NODES); }

float curve_unshadowed() { return EXPONENTIAL == 1u ? 0.0 : 1.0; }

float curve_transmittance(float value) { return EXPONENTIAL == 1u ? exp(-value) : value; }
#endif
