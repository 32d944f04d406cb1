#version 460
// Packs moments that were drawn. Inputs: ends, sums. Output: words. Twin: reference::twin::moments.
#include "technique/moments/store.glsl"
#include "maps/sums/pack.glsl"
