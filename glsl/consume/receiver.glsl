// Where light is asked for at a point of a surface. A technique whose answers are of voxels, or of whatever else is coarser than
// the surface, moves the point off it: it defines TECHNIQUE_RECEIVERS and, in its visibility.glsl,
// vec3 light_receiver(uint light, vec3 position, vec3 normal), `normal` of unit length on the side that light is asked for; it
// may keep the normal for the light_visibility that follows (maps/opaque.glsl). To be included behind visibility.glsl.
#ifndef CONSUME_RECEIVER_GLSL
#define CONSUME_RECEIVER_GLSL

#ifndef TECHNIQUE_RECEIVERS
vec3 light_receiver(uint light, vec3 position, vec3 normal) { return position; }
#endif

// How much of a light reaches a surface. `normal` is the outside of what is closed; of what is open it is either side, and the
// light's is asked for.
float surface_visibility(uint light, vec3 towards, vec3 position, vec3 normal, bool closed) {
    vec3 facing = closed || dot(normal, towards) >= 0.0 ? normal : -normal;
    return light_visibility(light, light_receiver(light, position, facing));
}
#endif
