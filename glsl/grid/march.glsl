// Whether a segment through a grid hits an occupied voxel, or an occupied cell of its mask (march_exact), or an occupied voxel at
// equidistant steps (march_steps). Needs visibility_bits, visibility_masks and the constants GRID_SIZE and CELL. Source: after Amanatides
// and Woo 1987; skipping empty space on the levels above is ours. Twins: reference::twin::grid::Bits, march_exact and march_steps; for
// masks reference::twin::masks::Masks.
#ifndef GRID_MARCH_GLSL
#define GRID_MARCH_GLSL
#include "grid/masks.glsl"
#include "grid/occupied.glsl"
#include "grid/walk.glsl"

// log2 of the number of tested cells per side of a voxel: a voxel is a single cell, or has a mask of cells.
const uint CELL_SHIFT = CELL == CELL_MASK ? MASK_SHIFT : 0u;

// The mask of an occupied voxel, one bit per cell; `brick`: the bits of the voxel's brick.
uvec2 grid_mask(uvec3 voxel, uvec2 brick) {
    uint word = grid_word(GRID_SIZE, 0u, voxel);
    uint at = mask_word(GRID_SIZE, visibility_masks[word], brick, grid_bit(0u, voxel));
    return uvec2(visibility_masks[at], visibility_masks[at + 1u]);
}

// Returns one voxel's bit, for callers that need no other bit of its word.
bool grid_has_voxel(uvec3 voxel) {
    uint bit = grid_bit(0u, voxel);
    return (visibility_bits[2u * grid_word(GRID_SIZE, 0u, voxel) + (bit >> 5)] >> (bit & 31u) & 1u) == 1u;
}

// Visits every voxel on the segment, and no other. From each voxel the march continues into the next one on the segment; if the voxel is
// empty, the march leaves the largest empty cube around it in one step. If voxels have masks, the march visits the cells of the masks, and
// voxels are one more level that may be empty.
bool march_exact(vec3 from, vec3 way) {
    const float cells = float(1u << CELL_SHIFT);
    March march;
    ivec3 cell;
    if (!march_begin(cells * from, cells * way, GRID_SIZE << CELL_SHIFT, march, cell)) {
        return false;
    }
    // The words around the current cell: bricks of a block, voxels of a brick, cells of a voxel.
    uvec3 block = uvec3(~0u), brick = uvec3(~0u), masked = uvec3(~0u);
    uvec2 bricks = uvec2(0u), voxels = uvec2(0u), mask = uvec2(0u);
    // Upper bound of the number of iterations: each iteration ends at a different plane between cells.
    for (uint turn = 0u; turn < 3u * march.size + 3u; ++turn) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        uvec3 at = uvec3(cell) ^ march.mirror, voxel = at >> CELL_SHIFT;
        if (voxel >> 4u != block) {
            block = voxel >> 4u;
            bricks = grid_bits(1u, block);
        }
        uint shift = 0u;
        if (grid_is_empty(bricks)) {
            shift = CELL_SHIFT + (grid_is_empty(grid_bits(2u, voxel >> 6u)) ? 6u : 4u);
        } else if (!grid_has(bricks, voxel >> 2u)) {
            shift = CELL_SHIFT + 2u;
        } else {
            if (voxel >> 2u != brick) {
                brick = voxel >> 2u;
                voxels = grid_bits(0u, brick);
            }
            if (!grid_has(voxels, voxel)) {
                shift = CELL_SHIFT + (grid_octant_is_empty(voxels, voxel) ? 1u : 0u);
            } else if (CELL_SHIFT == 0u) {
                return true;
            } else {
                if (voxel != masked) {
                    masked = voxel;
                    mask = grid_mask(voxel, voxels);
                }
                if (grid_has(mask, at)) {
                    return true;
                }
                shift = grid_octant_is_empty(mask, at) ? 1u : 0u;
            }
        }
        vec3 planes = march_planes(march, cell, shift);
        float nearest = min(planes.x, min(planes.y, planes.z));
        if (nearest >= march.range.y || !march_on(march, planes, nearest, shift, cell)) {
            return false;
        }
    }
    return false;
}

// Tests the voxel at the segment's beginning, which darkens a face turned away from the light, and voxels at equidistant steps. Misses
// voxels between two steps.
bool march_steps(vec3 from, vec3 way, uint steps, float offset) {
    vec2 range = grid_clip(from, way, GRID_SIZE);
    for (uint i = 0u; i <= steps && range.x <= range.y; ++i) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        float at = i == 0u ? range.x : mix(range.x, range.y, (float(i - 1u) + offset) / float(steps));
        ivec3 voxel = clamp(ivec3(floor(from + way * at)), ivec3(0), ivec3(int(GRID_SIZE) - 1));
        if (grid_has_voxel(uvec3(voxel))) {
            return true;
        }
    }
    return false;
}
#endif
