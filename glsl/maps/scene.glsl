// Set 0 of every pass over the maps of the lights. Bound by maps::Maps::scene.
#ifndef MAPS_SCENE_GLSL
#define MAPS_SCENE_GLSL
#extension GL_EXT_samplerless_texture_functions : require
#include "world/caster.glsl"
#include "world/caster_room.glsl"
#include "world/light.glsl"
#include "world/triangle.glsl"

// set 0: maps_scene
layout(set = 0, binding = 0, scalar) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Triangles { Triangle triangles[]; };
// The opaque maps: see opaque_corner in maps/opaque.glsl.
layout(set = 0, binding = 3) uniform sampler2D opaque_map;

// Texels across and down a volume map: all maps have the same size.
uvec2 map_size() { return uvec2(maps[0].caster_view.width, maps[0].caster_view.height); }
#endif
