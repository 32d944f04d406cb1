#version 460
// Adds a caster to each mean of the Haar wavelets. Source: as binned.comp. Inputs: maps, casters, ends. Outputs: sums. Twin:
// reference::twin::wavelet. Invariant: as maps/sums/raster.glsl.
// variants: TARGETS 1 2 4 8
#include "technique/wavelet/parts.glsl"
#include "maps/sums/raster.glsl"
