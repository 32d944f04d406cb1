// The set of what is drawn in front of the meshes: their z. Bound by consume::Renderer.
// set 2: picture_distances
#ifndef CONSUME_DISTANCES_SET_GLSL
#define CONSUME_DISTANCES_SET_GLSL
#define PICTURE_DISTANCES layout(set = 2, binding = 0) uniform texture2D distances;
#endif
