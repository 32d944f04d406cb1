#version 460
// Sums the optical depth of each texel's casters up to the end of each layer. Sources: Kim and Neumann 2001, Opacity Shadow Maps; Yuksel
// and Keyser 2008, Deep Opacity Maps; building them from tiles, with integer sums, exact segments and a range per texel, is ours. Inputs:
// maps, casters, parts, entries. Output: words. Twin: reference::twin::layers. Invariant: as in maps/sums/binned.glsl.
#include "technique/layers/store.glsl"
#include "maps/sums/binned.glsl"
