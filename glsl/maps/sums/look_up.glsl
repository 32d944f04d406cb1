// Look-ups through texels of sums and their levels of detail. A technique that includes this file also includes its own file that reads a
// texel's words, and defines texel_transmittance with words_transmittance.
#ifndef MAPS_SUMS_LOOK_UP_GLSL
#define MAPS_SUMS_LOOK_UP_GLSL
#define MAP_TRANSMITTANCE leveled_transmittance
#include "maps/levels.glsl"
#include "maps/sums/read.glsl"

layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityWords { uint visibility_words[]; };

uint kept_word(uint i) { return visibility_words[i]; }
#endif
