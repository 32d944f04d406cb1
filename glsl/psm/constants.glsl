// How a volume is laid out. Four slices stand in the channels of a texel: slice k in channel k % 4 of layer k / 4. The
// volumes of all maps stand in one 3D image, LAYERS layers each, one behind the other. Twin: technique::psm.
#ifndef PSM_CONSTANTS_GLSL
#define PSM_CONSTANTS_GLSL

layout(constant_id = 0) const uint SLICES = 256u;   // divisible by 4
layout(constant_id = 1) const uint SPLIT = 0u;      // 1: a caster is shared by the two slices about its centre
layout(constant_id = 2) const uint ADDITIVE = 0u;   // 1: optical depths are added, and what is lost of the light is kept
layout(constant_id = 3) const uint LAYERS = 64u;    // of a map: SLICES / 4, and one more for COVERAGE_VIEWPORT
layout(constant_id = 4) const uint COVERAGE = 0u;

const uint COVERAGE_OFF = 0u;
const uint COVERAGE_VIEWPORT = 1u;  // the last layer of a map says which 8×8 rays meet casters
const uint COVERAGE_TILES = 2u;     // the bins say it
#endif
