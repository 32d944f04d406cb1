// Layout of a volume. The four channels of a texel hold four slices: slice k is in channel k % 4 of layer k / 4. One 3D image holds the
// volumes of all maps one after another, LAYERS layers each. Twin: technique::psm::volume.
#ifndef TECHNIQUE_PSM_CONSTANTS_GLSL
#define TECHNIQUE_PSM_CONSTANTS_GLSL

CONSTANT(uint, SLICES, 256u)   // slices per volume; divisible by 4
CONSTANT(bool, SPLIT, false)     // splits a caster between the two slices around its centre
CONSTANT(bool, ADDITIVE, false)  // adds optical depths; the volume holds the lost light, 1 − transmittance
CONSTANT(uint, LAYERS, 64u)      // layers per map: SLICES / 4, and one more for COVERAGE_VIEWPORT
CONSTANT(uint, COVERAGE, 0u)

const uint COVERAGE_OFF = 0u;
const uint COVERAGE_VIEWPORT = 1u;  // the last layer of a map marks the blocks of 8×8 rays that hit casters
const uint COVERAGE_TILES = 2u;     // the counts of the bins mark these blocks
#endif
