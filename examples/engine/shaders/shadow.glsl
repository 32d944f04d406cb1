// How much of the sun reaches a point. gobo.glsl is one technique's file, as written by `gobo glsl`; renderer/pipelines.rs chooses it, and
// names its two functions gobo_visibility and gobo_receiver for every technique.
#include "gobo.glsl"

const uint SUN_LIGHT = 0u;

// For a point in space.
float sun_visibility(vec3 position) { return gobo_visibility(SUN_LIGHT, position); }

// For a point on a surface.
float sun_visibility(vec3 position, vec3 normal) {
    return gobo_visibility(SUN_LIGHT, gobo_receiver(SUN_LIGHT, position, normal));
}
