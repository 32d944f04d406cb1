// Ambient light: it replaces indirect light and needs no look-up. It is 0 in scenes with virtual lights, which are the indirect light; a
// scene has either virtual lights only or none. Sums over all lights begin with it. Must be declared before inclusion: lights[]. Twin:
// reference::truth::picture.
#ifndef CONSUME_AMBIENT_GLSL
#define CONSUME_AMBIENT_GLSL
#include "world/light.glsl"

const vec3 AMBIENT = vec3(0.10, 0.12, 0.15);

vec3 ambient() {
    if (lights.length() > 0 && lights[0].kind == LIGHT_VIRTUAL) {
        return vec3(0.0);
    }
    return AMBIENT;
}
#endif
