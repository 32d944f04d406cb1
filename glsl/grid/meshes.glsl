// What meshes leave of a light, for look-ups of grids that hold smoke and hair alone: an opaque map per light, as techniques with maps have it.
// Needs visibility_lights, visibility_maps (world/light.glsl) and visibility_opaque. Bound with maps::Maps::opaque_bindings. Twin:
// reference::twin::receiver.
#ifndef GRID_MESHES_GLSL
#define GRID_MESHES_GLSL
#include "maps/opaque.glsl"

// A point of a surface leaves it by a part of a texel of the opaque map.
#define TECHNIQUE_RECEIVERS
vec3 light_receiver(uint light, vec3 position, vec3 normal) {
    Light l = visibility_lights[light];
    look_up_normal = normal;
    return l.has_opaque == 0u ? position
                              : opaque_receiver(visibility_maps[light_map(l, position)].opaque, position, normal);
}

float meshes_leave(uint light, vec3 position) {
    vec3 normal = look_up_normal;
    look_up_normal = vec3(0.0);
    Light l = visibility_lights[light];
    uint map = light_map(l, position);
    return opaque_visibility(l, visibility_maps[map].opaque, map, visibility_opaque, position, normal);
}
#endif
