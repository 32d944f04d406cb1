// Bindings of every look-up through maps. Bound by maps::Maps::look_up.
//   binding 0  lights (world/light.glsl)
//   binding 1  maps of all lights (world/light.glsl)
//   binding 2  the opaque map of maps/opaque.glsl: depths in red, D32_SFLOAT, D16_UNORM or R32_SFLOAT, fetched and gathered but not
//              filtered (any 1×1 image if has_opaque is 0)
#ifndef MAPS_LOOK_UP_SET_GLSL
#define MAPS_LOOK_UP_SET_GLSL
#include "world/light.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer LookUpLights { Light look_up_lights[]; };
layout(set = GOBO_SET, binding = 1, scalar) readonly buffer LookUpMaps { Map look_up_maps[]; };
layout(set = GOBO_SET, binding = 2) uniform sampler2D look_up_opaque;
#endif
