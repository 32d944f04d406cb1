// Transmittance of a cone through a grid. The cone samples cells as wide as itself, and each cell blocks light by its occupied share. Needs
// visibility_bits, visibility_cells and the constant GRID_SIZE. Source: Crassin et al. 2011, section 5; making walls opaque on every level
// is ours. Twin: reference::twin::cone::Cells::march_cone.
#ifndef GRID_MARCH_CONE_GLSL
#define GRID_MARCH_CONE_GLSL
#include "grid/cells.glsl"
#include "grid/march.glsl"

// Less light than this counts as darkness.
const float CONE_DARK = 1.0 / 256.0;

// Factor that makes walls opaque. The cover is interpolated between the centres of cells. Steps are half a cell apart, so that at least one
// step finds ¾ or more of a wall's cover: 1.34 · ¾ > 1.
const float CONE_GAIN = 1.34;

// Share of light that a cell blocks along an axis: its number of occupied voxels relative to one layer of voxels across the axis. 0 outside
// the grid.
float cell_cover(uint level, ivec3 cell) {
    if (any(lessThan(cell, ivec3(0))) || any(greaterThanEqual(cell, ivec3(GRID_SIZE >> level)))) {
        return 0.0;
    }
    uvec3 at = uvec3(cell);
    uint count = 0u;
    if (level >= CELLS_FIRST) {
        count = visibility_cells[cell_at(GRID_SIZE, level, at)];
    } else {
        uvec2 bits = grid_bits(0u, at >> (2u - level));
        if (level == 2u) {
            count = uint(bitCount(bits.x) + bitCount(bits.y));
        } else if (level == 1u) {
            uvec3 corner = 2u * (at & 1u);
            count = uint(bitCount((corner.z == 0u ? bits.x : bits.y) & (0x00330033u << (corner.x + 4u * corner.y))));
        } else {
            count = grid_has(bits, at) ? 1u : 0u;
        }
    }
    // Divided by the square of the cell's side, a power of two.
    return min(1.0, float(count) * uintBitsToFloat((127u - 2u * level) << 23));
}

// The cover at a position, interpolated between the eight cells whose centres surround it.
float cone_cover(uint level, float side, vec3 place) {
    vec3 at = place / side - 0.5, corner = floor(at), share = at - corner;
    ivec3 cell = ivec3(corner);
    float sum = 0.0;
    for (uint i = 0u; i < 8u; ++i) {
        ivec3 offset = ivec3(i & 1u, i >> 1 & 1u, i >> 2);
        vec3 weight = mix(1.0 - share, share, vec3(offset));
        sum += weight.x * weight.y * weight.z * cell_cover(level, cell + offset);
    }
    return sum;
}

// `slope`: growth of the cone's radius per unit of length. Cells are as wide as the cone, or half as wide; steps are half a cell.
float march_cone(vec3 from, vec3 way, float slope) {
    vec2 range = grid_clip(from, way, GRID_SIZE);
    float voxels = length(way), light = 1.0, side = 1.0;
    if (range.x > range.y || voxels == 0.0) {
        return 1.0;
    }
    uint level = 0u;
    float at = range.x * voxels, end = range.y * voxels;
    for (uint turn = 0u; turn < 4u * GRID_SIZE && at < end; ++turn) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        for (; at * slope >= side && (GRID_SIZE >> level) > 1u; ++level) {
            side *= 2.0;
        }
        float cover = CONE_GAIN * cone_cover(level, side, from + way * (at / voxels));
        light *= sqrt(max(0.0, 1.0 - cover));
        if (light < CONE_DARK) {
            return 0.0;
        }
        at += 0.5 * side;
    }
    return light;
}
#endif
