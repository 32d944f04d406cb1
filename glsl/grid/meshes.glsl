// Visibility past meshes, from the opaque map, for look-ups of grids that hold only smoke and hair. Needs visibility_lights,
// visibility_maps (world/light.glsl) and visibility_opaque. Twin: reference::twin::receiver.
#ifndef GRID_MESHES_GLSL
#define GRID_MESHES_GLSL
#define look_up_lights visibility_lights
#define look_up_maps visibility_maps
#define look_up_opaque visibility_opaque
#include "maps/opaque_look_up.glsl"
#include "world/colors.glsl"

float meshes_leave(uint light, vec3 position) {
    vec3 normal = look_up_normal;
    look_up_normal = vec3(0.0);
    look_up_meshes = opaque_leaves(light, light_map(visibility_lights[light], position), position, normal);
    return look_up_meshes;
}
#endif
