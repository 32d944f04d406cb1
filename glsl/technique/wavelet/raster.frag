#version 460
// Adds a caster to a texel's sums. For each of the equal intervals of the texel's range, a sum is the optical depth up to a place, averaged
// over the interval; one more sum is the total optical depth. These means carry the same information as Haar wavelets. Source: Aizenshtein,
// Smal and McGuire 2022, Wavelet Transparency. Inputs: maps, casters, ends. Outputs: sums. Twin: reference::twin::wavelet. Invariant: as in
// maps/sums/raster.glsl.
// variants: TARGETS 1 2 4 8
#include "technique/wavelet/parts.glsl"
#include "maps/sums/raster.glsl"
