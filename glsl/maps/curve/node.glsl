// Layout of a stored transmittance curve: curve_pairs() pairs of words. Without PACKED, each pair is the bits of a Node. With PACKED, the
// first pair is the bits of two floats: the depth of the first node, and the distance from there to the last node. Each other pair holds
// two nodes, encoded as in maps/curve/pack.glsl, so that a curve takes 8 + 4 NODES bytes. With TIGHT, each pair holds four nodes, and a
// curve takes 2 NODES bytes. Twin: technique::NodeData.
#ifndef MAPS_CURVE_NODE_GLSL
#define MAPS_CURVE_NODE_GLSL
#include "world/view.glsl"

// Number of nodes per curve.
CONSTANT(int, NODES, 8)
// False: values are transmittances, interpolated linearly (Salvi et al. 2010). True: they are optical depths, interpolated linearly,
// which is exact within a sphere of constant extinction.
CONSTANT(bool, EXPONENTIAL, true)
// Whether curves are packed, as in maps/curve/pack.glsl.
CONSTANT(bool, PACKED, false)
// Whether packed curves take two bytes per node instead of four.
CONSTANT(bool, TIGHT, false)

// Depth of an unused node, whose value is that of the last used node.
const float EMPTY = FARTHEST;

struct Node {
    float depth;  // in the light's range, 0 to 1
    float value;
};

// Number of pairs of words per texel.
uint curve_pairs() { return TIGHT ? uint(NODES / 4) : PACKED ? uint(1 + NODES / 2) : uint(NODES); }

float curve_unshadowed() { return EXPONENTIAL ? 0.0 : 1.0; }

float curve_transmittance(float value) { return EXPONENTIAL ? exp(-value) : value; }
#endif
