#version 460
// The optical depth of each texel's casters in Haar wavelets over its range, as the means that these make. Source: Aizenshtein, Smal and
// McGuire 2022, Wavelet Transparency; from tiles, in whole numbers, with exact segments and between each texel's own ends: ours. Inputs:
// maps, casters, parts, entries. Output: words. Twin: reference::twin::wavelet.
// Invariant: as maps/sums/binned.glsl.
#include "technique/wavelet/parts.glsl"
#include "maps/sums/store_halves.glsl"
#include "maps/sums/binned.glsl"
