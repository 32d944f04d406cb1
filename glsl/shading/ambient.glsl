// Ambient light: it replaces indirect light and needs no look-up. Under virtual lights, which are the indirect light, it is 0; a scene
// has either virtual lights or others. Sums over all lights begin with it. Needs, declared before: lights[]. Twin:
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
