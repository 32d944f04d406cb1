// What a camera ray sees of a caster, and its colour there.
#ifndef CONSUME_CASTER_SEEN_GLSL
#define CONSUME_CASTER_SEEN_GLSL
#include "consume/shading.glsl"

// From z.x to z.y, between the near plane and the mesh at `farthest`; false where the ray sees nothing of it.
bool caster_seen(View camera, Ray ray, Caster caster, float farthest, out vec2 z) {
    vec3 within;
    bool hit = caster_overlap(ray, caster, within);
    z = vec2(max(within.x, camera.near), min(within.y, farthest));
    return hit && z.y >= z.x;
}

// Premultiplied, of what is seen from z.x to z.y.
vec4 caster_color(Ray ray, Caster caster, vec2 z, vec3 light) {
    float opacity = 1.0 - exp(-caster_optical_depth(ray, caster, z));
    return vec4(shade_caster(caster, light) * opacity, opacity);
}
#endif
