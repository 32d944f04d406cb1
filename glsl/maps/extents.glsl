// Bounds of casters along a view's axes, which maps/bounds.comp writes and maps/fit.comp reads. Floats are kept as
// whole numbers that order as they do, for atomicMin and atomicMax. Twin: reference::twin::fit, maps::fit::Extents.
#ifndef MAPS_EXTENTS_GLSL
#define MAPS_EXTENTS_GLSL
#extension GL_EXT_scalar_block_layout : require
#include "maps/float_order.glsl"

// The extents of one map: low and high along right, up and forward, first of its casters, then of the meshes. Where there is no caster or
// no mesh, low is above high.
struct Extents {
    uint low[6];
    uint high[6];
};
#endif
