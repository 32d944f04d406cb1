#version 460
// Adds a caster to a texel's sums. For each even interval of the texel's range, a sum is the mean of the optical depth up to each place in
// the interval; one more sum is the whole optical depth. These means carry the same information as Haar wavelets. Source: Aizenshtein, Smal
// and McGuire 2022, Wavelet Transparency. Inputs: maps, casters, ends. Outputs: sums. Twin: reference::twin::wavelet. Invariant: as
// maps/sums/raster.glsl.
// variants: TARGETS 1 2 4 8
#include "technique/wavelet/parts.glsl"
#include "maps/sums/raster.glsl"
