#version 460
// Moments of the optical depth of each texel's casters over its range. Source: Münstermann, Krumpen, Klein and Peters 2018, Moment-Based
// Order-Independent Transparency; from tiles, in whole numbers, with exact segments, between each texel's own ends, and powers as
// Chebyshev polynomials: ours. Inputs: maps, casters, parts, entries. Output: words. Twin: reference::twin::moments.
// Invariant: as maps/sums/binned.glsl.
#include "technique/moments/store.glsl"
#include "maps/sums/binned.glsl"
