// How a volume is laid out. Four slices stand in the channels of a texel: slice k in channel k % 4 of layer k / 4. The
// volumes of all maps stand in one 3D image, LAYERS layers each, one behind the other. Twin: technique::psm::volume.
#ifndef TECHNIQUE_PSM_CONSTANTS_GLSL
#define TECHNIQUE_PSM_CONSTANTS_GLSL

CONSTANT(uint, SLICES, 256u)   // of a volume; divisible by 4
CONSTANT(bool, SPLIT, false)     // a caster is shared by the two slices about its centre
CONSTANT(bool, ADDITIVE, false)  // optical depths are added, and the volume holds lost light, 1 − transmittance
CONSTANT(uint, LAYERS, 64u)      // of a map: SLICES / 4, and one more for COVERAGE_VIEWPORT
CONSTANT(uint, COVERAGE, 0u)

const uint COVERAGE_OFF = 0u;
const uint COVERAGE_VIEWPORT = 1u;  // the last layer of a map says which 8×8 rays meet casters
const uint COVERAGE_TILES = 2u;     // the bins say it
#endif
