// Tiles of 8×8 texels without casters are neither written nor read. For passes with one workgroup a tile.
#ifndef AVSM_TILED_GLSL
#define AVSM_TILED_GLSL
#extension GL_EXT_scalar_block_layout : require

// 1: they are skipped. 0: every tile is built and read.
layout(constant_id = 5) const uint TILED = 0u;

// The workgroup's tile among those of all maps.
uint tile_place(uint map) {
    return (map * gl_NumWorkGroups.y + gl_WorkGroupID.y) * gl_NumWorkGroups.x + gl_WorkGroupID.x;
}

bool tile_skipped(uint count) { return TILED == 1u && count == 0u; }
#endif
