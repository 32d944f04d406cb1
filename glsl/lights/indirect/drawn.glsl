// Buffers from which virtual lights are chosen, and the chosen texels. Bound by lights::indirect::Vpls.
#ifndef LIGHTS_INDIRECT_DRAWN_GLSL
#define LIGHTS_INDIRECT_DRAWN_GLSL
#extension GL_EXT_scalar_block_layout : require
#include "lights/indirect/texels.glsl"
#include "lights/indirect/units.glsl"

// set 2: indirect_drawn
// Flux of each texel, as luminance.
layout(set = 2, binding = 0, scalar) buffer Fluxes { float fluxes[]; };
// The greatest flux as float bits, which compare like the floats since none is negative.
layout(set = 2, binding = 1, scalar) buffer Greatest { uint greatest; };
// Units of flux in each row of a map's texels.
layout(set = 2, binding = 2, scalar) buffer Sums { uint sums[]; };
// Units before each row; after the last row, the total.
layout(set = 2, binding = 3, scalar) buffer Starts { uvec2 starts[]; };
// The texel that each virtual light is drawn from, or NO_TEXEL.
layout(set = 2, binding = 4, scalar) buffer Picks { uint picks[]; };

// The pick if there is no flux at all.
const uint NO_TEXEL = 0xffffffffu;

// Upper limit of a texel's flux, so that sums over all texels stay finite.
const float BRIGHTEST = 1e30;

// Returns a texel's flux, clamped to BRIGHTEST; NaN and negative flux become 0.
float counted(float flux) { return flux > 0.0 ? min(flux, BRIGHTEST) : 0.0; }
#endif
