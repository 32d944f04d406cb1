// Tiles of 8×8 texels without casters are neither written nor read.
#ifndef MAPS_CURVE_TILED_GLSL
#define MAPS_CURVE_TILED_GLSL

// True: tiles without casters are skipped. False: every tile is built and read.
CONSTANT(bool, TILED, false)

bool tile_skipped(uint count) { return TILED && count == 0u; }
#endif
