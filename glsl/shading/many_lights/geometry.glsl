// The surface that each pixel sees, stored to tell one surface from another: z, 0 in the sky, and the normal in 10 bits per coordinate.
#ifndef CONSUME_MANY_LIGHTS_GEOMETRY_GLSL
#define CONSUME_MANY_LIGHTS_GEOMETRY_GLSL
#include "shading/packed_normal.glsl"
#include "shading/many_lights/frame.glsl"

// set 1: many_lights_seen
layout(set = 1, binding = 0, scalar) buffer Geometry { uvec2 geometry[]; };
layout(set = 1, binding = 1, scalar) readonly buffer GeometryBefore { uvec2 geometry_before[]; };
layout(set = 1, binding = 2, scalar) readonly buffer ShadowsBefore { uint shadows_before[]; };
layout(set = 1, binding = 3, scalar) buffer Sources { uint sources[]; };  // where a pixel's surface was in the previous frame, or NOWHERE

const uint NOWHERE = 0xffffffffu;
#endif
