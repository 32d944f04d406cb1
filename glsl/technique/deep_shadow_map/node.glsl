// What a texel's nodes are stored as: by rising depth, one behind the other, those of a tile's 8×8 texels behind each other, tile after
// tile. Between two nodes optical depth is a straight line, which is exact within a sphere of constant extinction; two at one
// depth are a step. In front of the first the light is whole, behind the last it stays. Twin: technique::NodeData.
#ifndef TECHNIQUE_DEEP_SHADOW_MAP_NODE_GLSL
#define TECHNIQUE_DEEP_SHADOW_MAP_NODE_GLSL

struct Node {
    float depth;  // in the light's range, 0 to 1
    float value;  // optical depth
};
#endif
