// Extinction of red, green and blue light in a scene's casters, and each color's transmittance from the result of a look-up. Shaders that
// query a technique include this file after visibility.glsl. Bound by query::colored. Twins: reference::truth::Casters::colors,
// reference::truth::picture.
#ifndef CONSUME_COLORED_GLSL
#define CONSUME_COLORED_GLSL
#include "world/caster_room.glsl"

// Factors that scale the casters' extinction for each color; all 1 if the casters are grey.
CONSTANT(float, EXTINCTION_RED, 1.0)
CONSTANT(float, EXTINCTION_GREEN, 1.0)
CONSTANT(float, EXTINCTION_BLUE, 1.0)
// The color channel that a draw blends: each channel has its own opacity, but blending uses a single alpha.
CONSTANT(uint, CHANNEL, 0u)

vec3 extinction_ratio() { return vec3(EXTINCTION_RED, EXTINCTION_GREEN, EXTINCTION_BLUE); }

// Returns the index of the first caster in the list for the channel that is drawn.
uint channel_casters() { return CHANNEL * CASTER_ROOM; }

// Returns the visibility of each color, from the last look-up.
vec3 colored(float visibility) {
#ifdef TECHNIQUE_COLORS
    return light_colors(visibility, extinction_ratio());
#else
    return vec3(visibility);
#endif
}

// Returns a premultiplied color with the opacity of the channel that is drawn.
vec4 blended_color(vec3 color, vec3 opacity) { return vec4(color, opacity[CHANNEL]); }
#endif
