// Shared by the passes that put points on the meshes. Twin: technique::ism::SamplePush.
#ifndef TECHNIQUE_ISM_SAMPLE_GLSL
#define TECHNIQUE_ISM_SAMPLE_GLSL
#include "technique/ism/points.glsl"
#include "world/triangle.glsl"
#include "world/view.glsl"

layout(push_constant, scalar) uniform SamplePush {
    uint triangle_count;
    uint points;  // points per subset, a power of two
};

// set 0: ism_sample
layout(set = 0, binding = 0, scalar) readonly buffer SampleTriangles { Triangle triangles[]; };
layout(set = 0, binding = 1, scalar) readonly buffer SampleSides { int sides[]; };
layout(set = 0, binding = 2, scalar) buffer SampleHead { IsmPoints head; };
layout(set = 0, binding = 3, scalar) buffer SampleAreas { float areas[]; };   // area of each triangle
layout(set = 0, binding = 4, scalar) buffer SampleSums { uint sums[]; };      // sum of weights up to each triangle, within its block
layout(set = 0, binding = 5, scalar) buffer SampleBlocks { uint blocks[]; };  // per block: its area as a float, then the weight before it
layout(set = 0, binding = 6, scalar) writeonly buffer SamplePool { IsmPoint pool[]; };

const uint BLOCK = 128u;

uint block_count() { return (triangle_count + BLOCK - 1u) / BLOCK; }
#endif
