// Visibility past meshes, from a light's opaque map, for techniques with maps and for grids that hold only smoke and hair. Needs
// look_up_lights, look_up_maps (world/light.glsl) and look_up_opaque. Bound with maps::Maps::opaque_bindings. Twin:
// reference::twin::receiver.
#ifndef MAPS_OPAQUE_LOOK_UP_GLSL
#define MAPS_OPAQUE_LOOK_UP_GLSL
#include "maps/opaque.glsl"

// Moves a point off its surface, by a fraction of a texel of the opaque map.
#define TECHNIQUE_RECEIVERS
vec3 light_receiver(uint light, vec3 position, vec3 normal) {
    Light l = look_up_lights[light];
    look_up_normal = normal;
    return l.has_opaque == 0u ? position
                              : opaque_receiver(look_up_maps[light_map(l, position)].opaque, position, normal);
}

// Visibility past the meshes at a point with this normal, from the light's map `map`, which sees the point.
float opaque_leaves(uint light, uint map, vec3 position, vec3 normal) {
    return opaque_visibility(look_up_lights[light], look_up_maps[map].opaque, map, look_up_opaque, position, normal);
}
#endif
