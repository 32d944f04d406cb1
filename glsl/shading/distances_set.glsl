// The set for casters that are drawn in front of meshes: the meshes' z. Bound by shading::Renderer.
// set 2: picture_distances
#ifndef CONSUME_DISTANCES_SET_GLSL
#define CONSUME_DISTANCES_SET_GLSL
#define PICTURE_DISTANCES layout(set = 2, binding = 0) uniform texture2D distances;
#endif
