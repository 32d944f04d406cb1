// The picture that compute passes paint on, in front of meshes. Bound by shading::painter.
// set 2: painter_picture
#ifndef CONSUME_PAINTER_PICTURE_GLSL
#define CONSUME_PAINTER_PICTURE_GLSL
#extension GL_EXT_samplerless_texture_functions : require
#define PAINTED_DISTANCES layout(set = 2, binding = 0) uniform texture2D distances;
#define PAINTED_COLORS layout(set = 2, binding = 1, rgba32f) uniform image2D colors;

// Painting stops when the transmittance falls below this value, which bounds the error relative to the light behind. Twin: HIDDEN.
const float HIDDEN = 1e-5;

bool is_seen(vec3 left) { return max(left.x, max(left.y, left.z)) > HIDDEN; }
#endif
