// The light that a surface reflects from one light, shadowed by the technique. Must be declared before inclusion: lights[] and
// light_visibility.
#ifndef CONSUME_SURFACE_LIGHT_GLSL
#define CONSUME_SURFACE_LIGHT_GLSL
#include "query/colored.glsl"
#include "query/receiver.glsl"
#include "shading/shading.glsl"

vec3 surface_light(uint light, vec3 position, vec3 normal, bool closed) {
    if (light_radiance(lights[light], position) == vec3(0.0)) {
        return vec3(0.0);  // not queried: the light does not reach the point, or shines elsewhere
    }
    float visibility = surface_visibility(light, lights[light], position, normal, closed);
    return light_on_surface(lights[light], position, normal, colored(visibility));
}
#endif
