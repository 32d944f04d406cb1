#version 460
// Builds the Fourier series of each texel's optical depth over the texel's range. Source: Jansen and Bavoil 2010, Fourier Opacity Mapping;
// building them from tiles, with integer sums, exact segments and a range per texel, is ours. Inputs: maps, casters, parts, entries.
// Output: words. Twin: reference::twin::fourier. Invariant: as in maps/sums/binned.glsl.
#include "technique/fourier/parts.glsl"
#include "maps/sums/store_halves.glsl"
#include "maps/sums/binned.glsl"
