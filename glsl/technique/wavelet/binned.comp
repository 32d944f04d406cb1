#version 460
// Builds the Haar wavelets of each texel's optical depth over the texel's range, stored as means over intervals, which carry the same
// information. Source: Aizenshtein, Smal and McGuire 2022, Wavelet Transparency; building them from tiles, with integer sums, exact
// segments and a range per texel, is ours. Inputs: maps, casters, parts, entries. Output: words. Twin: reference::twin::wavelet. Invariant:
// as in maps/sums/binned.glsl.
#include "technique/wavelet/parts.glsl"
#include "maps/sums/store_halves.glsl"
#include "maps/sums/binned.glsl"
