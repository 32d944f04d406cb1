// Light that reaches a point of a caster: ambient light and the sum over all lights. Must be declared before inclusion: lights[] and
// light_visibility. Twin: reference::truth::picture::light.
#ifndef CONSUME_CASTER_LIGHT_GLSL
#define CONSUME_CASTER_LIGHT_GLSL
#include "shading/ambient.glsl"
#include "query/colored.glsl"
#include "query/receiver.glsl"
#include "shading/shading.glsl"

vec3 caster_light(Caster caster, vec3 position) {
    vec3 light = ambient();
    for (uint i = 0u; i < lights.length(); ++i) {
        vec3 radiance = light_radiance(lights[i], position);
        if (any(greaterThan(radiance, vec3(0.0)))) {
            vec3 asked = lit_side(lights[i], caster, position);
            if (caster_is_splat(caster)) {
                vec3 normal = splat_shape(caster.radius, caster.axis).axes[2];
                asked = light_receiver(i, asked, dot(normal, light_direction(lights[i], position)) < 0.0 ? -normal : normal);
            }
            light += radiance * colored(light_visibility(i, asked));
        }
    }
    return light;
}
#endif
