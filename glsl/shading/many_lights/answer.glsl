// A pixel's surface, and whether it is shadowed from a light: a result of one bit. Include this file after visibility.glsl.
#ifndef CONSUME_MANY_LIGHTS_ANSWER_GLSL
#define CONSUME_MANY_LIGHTS_ANSWER_GLSL
#include "shading/picture_set.glsl"
#include "query/receiver.glsl"
#include "shading/surface.glsl"
#include "shading/many_lights/dither.glsl"

SURFACE_ALBEDOS
SURFACE_NORMALS
SURFACE_DISTANCES

struct Seen {
    vec3 position;
    vec3 normal;
    bool is_closed;
    vec3 dither;
    float side;  // width of the pixel at the surface, world units
};

bool is_sky(uvec2 pixel) { return texelFetch(albedos, ivec2(pixel), 0).a == 0.0; }

Seen seen(uvec2 pixel) {
    vec4 normal = texelFetch(normals, ivec2(pixel), 0);
    Ray ray = surface_ray(frames[0].camera, vec2(pixel) + 0.5);
    float z = texelFetch(distances, ivec2(pixel), 0).r;
    return Seen(surface_position(ray, z), normal.xyz, normal.w != 0.0, dither(pixel), pixel_side(frames[0].camera, z));
}

// Turns a light's visibility, 0 to 1, into one bit by comparing it with the pixel's dither threshold. Thresholds differ between
// neighbouring pixels, so that the fraction of lit pixels among them is the visibility; the blur averages them. Without dither the
// threshold is a half.
bool is_shadowed(Seen at, uint light) {
#ifdef TECHNIQUE_DITHERS
    look_up_dither = at.dither;
#endif
    light_footprint(at.side);
    float visibility = surface_visibility(light, lights[light], at.position, at.normal, at.is_closed);
    return visibility < (DITHER == 0u ? 0.5 : at.dither.x);
}
#endif
