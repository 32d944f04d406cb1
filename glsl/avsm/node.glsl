// What a texel's transmittance curve is stored as. Twin: technique::avsm::NodeData.
#ifndef AVSM_NODE_GLSL
#define AVSM_NODE_GLSL

layout(constant_id = 0) const int NODES = 8;
// 0: values are transmittances, interpolated linearly (the seed). 1: values are optical depths, interpolated linearly,
// which is exact within a sphere of constant extinction.
layout(constant_id = 1) const uint EXPONENTIAL = 1u;

// Depth of an unused node. Its value is that of the last used one.
const float EMPTY = 3e38;

struct Node {
    float depth;  // in the light's range, 0 to 1
    float value;
};

float curve_unshadowed() { return EXPONENTIAL == 1u ? 0.0 : 1.0; }

float curve_transmittance(float value) { return EXPONENTIAL == 1u ? exp(-value) : value; }
#endif
