#version 460
// The optical depth of each texel's casters up to the end of each layer. Sources: Kim and Neumann 2001, Opacity Shadow Maps; Yuksel
// and Keyser 2008, Deep Opacity Maps; from tiles, in whole numbers, with exact segments and between each texel's own ends: ours.
// Inputs: maps, casters, parts, entries. Output: words. Twin: reference::twin::layers.
// Invariant: as maps/sums/binned.glsl.
#include "technique/layers/store.glsl"
#include "maps/sums/binned.glsl"
