// Makes levels of detail of texels that hold sums. A texel's range covers the ranges of the four texels below it and is divided into cells.
// At the end of each cell, the texel's optical depth follows from the mean transmittance of the four texels. Within a cell the optical
// depth grows evenly, as it does along a caster's segment. So each cell is added to the texel's sums in the same way as a caster's segment.
// A texel past the map's edge, or without casters, lets all light through. Twin: reference::twin::texel_sums::merged. Invariant: behind the
// range a texel has the mean of the four, to the rounding of storing; sums never fall along the range. A technique declares before: SUMS,
// segment_parts and store_sums, as for maps/sums/binned.glsl; how it reads (maps/sums/read.glsl); LEVEL_CELLS, and float cell_end(uint k),
// the place where cell k − 1 ends, k = 0 being the range's beginning.
#ifndef MAPS_SUMS_LEVELS_GLSL
#define MAPS_SUMS_LEVELS_GLSL
#include "maps/level_tile.glsl"
#include "maps/sums/read.glsl"

// For each texel that is made: its range, and the optical depths at the ends of its cells.
shared vec2 level_ranges[MADE];
shared float level_depths[MADE * LEVEL_CELLS];

// The first word of texel i of the four below texel t; NONE where that texel has no casters.
uint casting_words(LevelTile tile, uint t, uint i) {
    uint place = below_place(tile, below_texel(tile, t, i));
    uint first = place * texel_words();
    return place != NONE && kept_total(first + range_words()) > 0.0 ? first : NONE;
}

vec2 merged_range(LevelTile tile, uint t) {
    vec2 ends = vec2(FARTHEST, -FARTHEST);
    for (uint i = 0u; i < BELOW; ++i) {
        uint first = casting_words(tile, t, i);
        if (first != NONE) {
            vec2 range = kept_range(first);
            ends = vec2(min(ends.x, range.x), max(ends.y, range.y));
        }
    }
    return range_of(ends);
}

// The optical depth that stands for the mean transmittance of the four texels below, up to a depth.
float merged_depth(LevelTile tile, uint t, float depth) {
    float mean = 0.0;
    for (uint i = 0u; i < BELOW; ++i) {
        uint first = casting_words(tile, t, i);
        mean += 0.25 * (first != NONE ? words_transmittance(first, depth) : 1.0);
    }
    return mean < 1.0 ? min(-log(max(mean, 1e-35)), MAX_OPTICAL_DEPTH) : 0.0;
}

void make_level(LevelTile tile) {
    uint thread = gl_LocalInvocationIndex;
    if (thread < tile_texels(tile)) {
        level_ranges[thread] = merged_range(tile, thread);
    }
    barrier();
    for (uint i = thread; i < tile_texels(tile) * LEVEL_CELLS; i += LEVEL_THREADS) {
        uint t = i / LEVEL_CELLS;
        vec2 range = level_ranges[t];
        level_depths[i] = merged_depth(tile, t, depth_along(range, cell_end(i % LEVEL_CELLS + 1u)));
    }
    barrier();
    uint place = thread < tile_texels(tile) ? made_place(tile, thread) : NONE;
    if (place == NONE) {
        return;
    }
    float sums[SUMS];
    for (uint k = 0u; k < SUMS; ++k) {
        sums[k] = 0.0;
    }
    float last = 0.0;
    for (uint i = 0u; i < LEVEL_CELLS; ++i) {
        float optical_depth = max(level_depths[thread * LEVEL_CELLS + i], last);
        float parts[SUMS];
        segment_parts(vec2(cell_end(i), cell_end(i + 1u)), optical_depth - last, parts);
        for (uint k = 0u; k < SUMS; ++k) {
            sums[k] += parts[k];
        }
        last = optical_depth;
    }
    store_sums(place, level_ranges[thread], sums);
}
#endif
