// How much of the sun reaches a point. gobo.glsl is the file of one technique, as `gobo glsl` writes it; renderer/pipelines.rs
// says which, and calls its two functions gobo_visibility and gobo_receiver whichever it is.
#include "gobo.glsl"

const uint SUN_LIGHT = 0u;

// At a point in space.
float sun_visibility(vec3 position) { return gobo_visibility(SUN_LIGHT, position); }

// At a point of a surface.
float sun_visibility(vec3 position, vec3 normal) {
    return gobo_visibility(SUN_LIGHT, gobo_receiver(SUN_LIGHT, position, normal));
}
