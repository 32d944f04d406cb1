// Tiles of 8×8 texels without casters are neither written nor read.
#ifndef TECHNIQUE_AVSM_TILED_GLSL
#define TECHNIQUE_AVSM_TILED_GLSL

// True: tiles without casters are skipped. False: every tile is built and read.
CONSTANT(bool, TILED, false)

bool tile_skipped(uint count) { return TILED && count == 0u; }
#endif
