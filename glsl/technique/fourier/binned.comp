#version 460
// Makes the Fourier series of each texel's optical depth over the texel's range. Source: Jansen and Bavoil 2010, Fourier Opacity Mapping;
// from tiles, in whole numbers, with exact segments and between each texel's own ends: ours. Inputs: maps, casters, parts, entries. Output:
// words. Twin: reference::twin::fourier. Invariant: as maps/sums/binned.glsl.
#include "technique/fourier/parts.glsl"
#include "maps/sums/store_halves.glsl"
#include "maps/sums/binned.glsl"
