// Bounds of casters along a view's axes, written by maps/bounds.comp and read by maps/fit.comp. Floats are stored as integers that compare
// in the same order, for atomicMin and atomicMax. Twin: reference::twin::fit, maps::fit::Extents.
#ifndef MAPS_EXTENTS_GLSL
#define MAPS_EXTENTS_GLSL
#extension GL_EXT_scalar_block_layout : require
#include "maps/float_order.glsl"

// Extents of one map: low and high along right, up and forward, first of its casters, then of the meshes. Without any caster or mesh, low
// is above high.
struct Extents {
    uint low[6];
    uint high[6];
};
#endif
