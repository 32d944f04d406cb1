// Position at which a surface point looks up its light. A technique that resolves surfaces coarsely, as voxels do, moves the point off its
// surface. Such a technique defines TECHNIQUE_RECEIVERS and vec3 light_receiver(uint light, vec3 position, vec3 normal) in its
// visibility.glsl. `normal` has unit length and points to the side of the surface whose light is looked up. The function may keep the
// normal for the following call of light_visibility (maps/opaque.glsl). Include this file after visibility.glsl.
#ifndef CONSUME_RECEIVER_GLSL
#define CONSUME_RECEIVER_GLSL

#include "world/light.glsl"

#ifndef TECHNIQUE_RECEIVERS
vec3 light_receiver(uint light, vec3 position, vec3 normal) { return position; }
#endif

// Sets the receiver's width across the light, in world units, for the look-ups that follow. Techniques with levels of detail choose a level
// by it.
void light_footprint(float side) {
#ifdef TECHNIQUE_FOOTPRINTS
    look_up_footprint = side;
#endif
}

// Returns the width of a pixel at a distance along the camera's axis.
float pixel_side(View camera, float z) {
    return (camera.projection == VIEW_PARALLEL ? 2.0 : 2.0 * z) / abs(float(camera.height) * camera.scale_y);
}

// Returns whether a surface is in its own shadow because of its normal alone: the outside of a closed mesh that faces away from a light at
// infinity. (A light with a position may be inside the mesh.) Twin: reference::truth::SurfacePoint::looks_away.
bool looks_away(Light light, vec3 normal, bool closed) {
    return closed && light.kind == LIGHT_DIRECTIONAL && dot(normal, light.direction) > 0.0;
}

// Returns how much of the scene's `index`-th light reaches a surface. `normal` points out of a closed mesh. On an open mesh it may point to
// either side: the side towards the light is looked up.
float surface_visibility(uint index, Light light, vec3 position, vec3 normal, bool closed) {
    if (looks_away(light, normal, closed)) {
#ifdef TECHNIQUE_COLORS
        look_up_meshes = 0.0;
#endif
        return 0.0;
    }
    vec3 facing = closed || dot(normal, light_direction(light, position)) >= 0.0 ? normal : -normal;
    return light_visibility(index, light_receiver(index, position, facing));
}
#endif
