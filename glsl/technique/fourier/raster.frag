#version 460
// Adds a caster to each sum of a Fourier series. Source: as in binned.comp. Inputs: maps, casters, ends. Outputs: sums. Twin:
// reference::twin::fourier. Invariant: as in maps/sums/raster.glsl.
// variants: TARGETS 1 2 4 8
#include "technique/fourier/parts.glsl"
#include "maps/sums/raster.glsl"
