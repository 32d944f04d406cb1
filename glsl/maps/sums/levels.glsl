// Builds levels of detail of texels that hold sums. A texel's range covers the ranges of the four texels below it and is divided into
// cells. At the end of each cell, the texel's optical depth follows from the mean transmittance of the four texels. Within a cell the
// optical depth grows linearly, as it does along a caster's segment. So each cell is added to the texel's sums in the same way as a
// caster's segment. A texel past the map's edge, or without casters, transmits all light. Only the map's own texels are read from their
// sums: a look-up in sums does not return exactly what was added to them, and look-ups in sums of look-ups would drift further off with
// each level. From level 1 on the optical depths at the cells' ends are read instead, from shared memory, or at the beginning of a pass
// from the values that the previous pass stored. Twin: reference::twin::texel_sums::Curve. Invariant: behind its range a texel has the mean
// of the four, up to rounding when stored; sums never decrease along the range. A technique declares before inclusion: SUMS, segment_parts
// and store_sums, as for maps/sums/binned.glsl; how it reads (maps/sums/read.glsl); LEVEL_CELLS; float cell_end(uint k), the place where
// cell k − 1 ends, k = 0 being the range's beginning; and uint cell_at(float place), the cell that contains a place.
#ifndef MAPS_SUMS_LEVELS_GLSL
#define MAPS_SUMS_LEVELS_GLSL
#include "maps/level_tile.glsl"
#include "maps/sums/read.glsl"

// For each texel to build, level by level of the pass: its range, and the optical depths at the ends of its cells.
const uint MADE_A_PASS = MADE + MADE / 4u + MADE / 16u;
shared vec2 level_ranges[MADE_A_PASS];
shared float level_depths[MADE_A_PASS * LEVEL_CELLS];

// Number of a tile's texels that a pass builds before it builds the level with `side` texels per side of the tile.
uint made_before(uint side) { return (MADE - side * side) / 3u * 4u; }

// Index of a texel of a pass's last level among those that store their curves; `place`: its index among those of all maps and levels.
uint curve_place(uint level, uint place) {
    uint maps_count = gl_NumWorkGroups.z;
    for (uint i = 0u; i < level; ++i) {
        uvec2 its = level_size(map_size(), i);
        place -= i == 0u || i % LEVELS_A_PASS != 0u ? its.x * its.y * maps_count : 0u;
    }
    return place;
}

// Optical depth of a texel below up to the beginning of cell k. Not for the map's own texels.
float carried_depth(LevelTile tile, uvec2 texel, uint k) {
    if (k == 0u) {
        return 0.0;
    }
    uint side = 2u * tile.side;
    if (side * side > MADE) {
        return level_curves[curve_place(tile.level - 1u, below_place(tile, texel)) * LEVEL_CELLS + k - 1u];
    }
    return level_depths[(made_before(side) + texel.y * side + texel.x) * LEVEL_CELLS + k - 1u];
}

// First word of a texel of the level below; NONE if the texel has no casters.
uint casting_words(LevelTile tile, uvec2 texel) {
    uint place = below_place(tile, texel);
    uint first = place * texel_words();
    if (place == NONE) {
        return NONE;
    }
    float total = tile.level == 1u ? kept_total(first + range_words()) : carried_depth(tile, texel, LEVEL_CELLS);
    return total > 0.0 ? first : NONE;
}

vec2 merged_range(LevelTile tile, uint t) {
    vec2 ends = vec2(FARTHEST, -FARTHEST);
    for (uint i = 0u; i < BELOW; ++i) {
        uint first = casting_words(tile, below_texel(tile, t, i));
        if (first != NONE) {
            vec2 range = kept_range(first);
            ends = vec2(min(ends.x, range.x), max(ends.y, range.y));
        }
    }
    return range_of(ends);
}

// Transmittance of a texel below up to a depth.
float below_transmittance(LevelTile tile, uvec2 texel, float depth) {
    uint first = casting_words(tile, texel);
    if (first == NONE) {
        return 1.0;
    }
    if (tile.level == 1u) {
        return words_transmittance(first, depth);
    }
    float place = range_place(kept_range(first), depth);
    uint cell = cell_at(place);
    float begin = cell_end(cell), along = clamp((place - begin) / (cell_end(cell + 1u) - begin), 0.0, 1.0);
    return exp(-mix(carried_depth(tile, texel, cell), carried_depth(tile, texel, cell + 1u), along));
}

// Optical depth that corresponds to the mean transmittance of the four texels below, up to a depth.
float merged_depth(LevelTile tile, uint t, float depth) {
    float mean = 0.0;
    for (uint i = 0u; i < BELOW; ++i) {
        mean += 0.25 * below_transmittance(tile, below_texel(tile, t, i), depth);
    }
    return mean < 1.0 ? min(-log(max(mean, 1e-35)), MAX_OPTICAL_DEPTH) : 0.0;
}

void make_level(LevelTile tile) {
    uint thread = gl_LocalInvocationIndex, made = made_before(tile.side);
    if (thread < tile_texels(tile)) {
        level_ranges[made + thread] = merged_range(tile, thread);
    }
    barrier();
    for (uint i = thread; i < tile_texels(tile) * LEVEL_CELLS; i += LEVEL_THREADS) {
        uint t = i / LEVEL_CELLS;
        vec2 range = level_ranges[made + t];
        float depth = depth_along(range, cell_end(i % LEVEL_CELLS + 1u));
        level_depths[made * LEVEL_CELLS + i] = merged_depth(tile, t, depth);
    }
    barrier();
    uint place = thread < tile_texels(tile) ? made_place(tile, thread) : NONE;
    if (place == NONE) {
        return;
    }
    // The next pass begins where this one ends.
    bool leaves = tile.side == 1u && tile.level + 1u < LEVELS;
    uint left = leaves ? curve_place(tile.level, place) * LEVEL_CELLS : 0u, own = (made + thread) * LEVEL_CELLS;
    float sums[SUMS];
    for (uint k = 0u; k < SUMS; ++k) {
        sums[k] = 0.0;
    }
    float last = 0.0;
    for (uint i = 0u; i < LEVEL_CELLS; ++i) {
        float optical_depth = max(level_depths[own + i], last);
        level_depths[own + i] = optical_depth;
        if (leaves) {
            level_curves[left + i] = optical_depth;
        }
        float parts[SUMS];
        segment_parts(vec2(cell_end(i), cell_end(i + 1u)), optical_depth - last, parts);
        for (uint k = 0u; k < SUMS; ++k) {
            sums[k] += parts[k];
        }
        last = optical_depth;
    }
    store_sums(place, level_ranges[made + thread], sums);
}
#endif
