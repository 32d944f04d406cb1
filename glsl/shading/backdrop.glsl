// A sky with a sun, into which the ground fades: for display, never for measured pictures. Twins:
// scene::Backdrop, reference::truth::backdrop.
#ifndef CONSUME_BACKDROP_GLSL
#define CONSUME_BACKDROP_GLSL
#extension GL_EXT_scalar_block_layout : require

layout(push_constant, scalar) uniform BackdropPush {
    vec3 up;        // unit length
    vec3 sun;       // direction towards the sun, unit length
    vec3 sunlight;  // black if there is no sun
    vec3 horizon;   // colors
    vec3 zenith;
    vec3 middle;      // centre of the ground
    float fade_begin;  // distance from the centre at which the ground begins to fade
    float fade_end;
    float thick;  // how far the ground extends above and below the centre
};

// Cosines of angles from the sun's centre: the disc is full up to the first, and fades out up to the second.
const float SUN_WHOLE = 0.99985;
const float SUN_NONE = 0.99965;

// Color of the sky in a direction of unit length.
vec3 sky_color(vec3 direction) {
    float height = dot(direction, up);
    float below_zenith = 1.0 - max(height, 0.0);
    vec3 color = mix(zenith, horizon, below_zenith * below_zenith * below_zenith) * (1.0 + 0.5 * min(height, 0.0));
    float towards = max(dot(direction, sun), 0.0);
    float glow = towards * towards;
    glow *= glow;
    glow *= glow;
    glow *= glow;
    float disc = smoothstep(SUN_NONE, SUN_WHOLE, towards);
    return color + sunlight * (smoothstep(-0.02, 0.02, height) * (0.25 * glow * glow + 4.0 * disc));
}

// How far the ground has faded at a visible point, 0 to 1.
float ground_faded(vec3 position) {
    vec3 offset = position - middle;
    float height = dot(offset, up);
    float away = length(offset - height * up);
    return fade_end > 0.0 && abs(height) <= thick ? smoothstep(fade_begin, fade_end, away) : 0.0;
}
#endif
