#version 460
// Surveys the casters of each tile: which cells of the tile they touch, and how long and strong their edges are. A caster counts equally in
// all tiles that it touches, with the greatest edge and optical depth that it may have in any tile. That is accurate enough to tell tiles
// apart. Inputs: maps, casters, horizon. Outputs: surveys (cleared beforehand). Twin: reference::twin::detail::survey. Invariants: sums are
// integers, so that the order of the casters does not matter; a cell is marked if any ray through it hits a caster.
#extension GL_EXT_control_flow_attributes : require
#include "maps/bins/set.glsl"
#include "maps/detail/casters.glsl"
#include "maps/detail/set.glsl"
#include "maps/detail/survey.glsl"

// TALLY 0: each caster is added to its tiles in memory. TALLY 1: a workgroup first sums its casters in shared memory. That is for maps with
// few tiles, where many casters would contend for one tile.
// variants: TALLY 0 1
#if TALLY == 1
layout(local_size_x_id = ID_WORKGROUP) in;
// The workgroup's size again: some tools do not accept a specialized gl_WorkGroupSize as a constant.
CONSTANT(uint, THREADS, 128u)
// Largest number of tiles of a map. Twin: MOST_SURVEYED in maps::threads.
const uint MOST_TILES = 1024u;
shared Survey own[MOST_TILES];
#else
const uint THREADS = BIN_THREADS;
layout(local_size_x = THREADS) in;
#endif

BINS_HORIZON(readonly buffer)
DETAIL_SURVEYS(buffer)

// Cells are enlarged by this much on each side, in texels of the finer view, as a margin for rounding.
const float OUTSET = 0.0625;

// x: length of the caster's edge within a tile, in texels; y: fraction of light that the caster absorbs; z: its mean optical depth over the
// tile.
vec3 share_of_tile(View view, Caster caster) {
    float z = dot(caster.position - view.origin, view.forward);
    float texels = 0.5 * float(view.width) * view.scale_x / (view.projection == VIEW_PARALLEL ? 1.0 : max(z, view.near));
    float wide = 2.0 * caster.radius * texels, area = min(wide * wide, 64.0), edge = 0.5 * wide;
    float optical_depth = caster.density * caster.radius * (4.0 / 3.0);
    if (caster_is_strand(caster)) {
        edge = length(caster.axis - dot(caster.axis, view.forward) * view.forward) * texels;
        area = min(edge, 8.0) * wide;
        optical_depth = caster.density;
    }
    optical_depth = caster_is_sheet(caster) ? caster.density : optical_depth;
    return vec3(min(edge, 8.0), optical_depth / (1.0 + optical_depth), min(area / 64.0 * optical_depth, 1.0));
}

// The cells of a tile, from `from` to `to`, that the caster touches.
uint cells_met(View fine, Caster caster, uvec2 tile, uvec2 from, uvec2 to) {
    uint cells = 0u;
    if (fine.projection != VIEW_PARALLEL || caster_is_strand(caster)) {
        for (uint y = from.y; y <= to.y; ++y) {
            for (uint x = from.x; x <= to.x; ++x) {
                bool missed = tile_missed(tile_distance(fine, caster, uvec2(x, y), -OUTSET));
                cells |= missed ? 0u : 1u << (y % SURVEY_CELLS * SURVEY_CELLS + x % SURVEY_CELLS);
            }
        }
        return cells;
    }
    // For a sphere, the distance to a cell follows from one number per row and one per column.
    vec2 apart[SURVEY_CELLS];
    [[unroll]] for (uint i = 0u; i < SURVEY_CELLS; ++i) {
        uvec2 cell = tile * SURVEY_CELLS + i;
        bvec2 outside = bvec2(any(bvec2(cell.x < from.x, cell.x > to.x)), any(bvec2(cell.y < from.y, cell.y > to.y)));
        apart[i] = mix(tile_apart(fine, caster, cell, -OUTSET), vec2(1e9), outside);
    }
    [[unroll]] for (uint i = 0u; i < SURVEY_CELLS * SURVEY_CELLS; ++i) {
        vec2 between = vec2(apart[i % SURVEY_CELLS].x, apart[i / SURVEY_CELLS].y);
        cells |= uint(!tile_missed(dot(between, between))) << i;
    }
    return cells;
}

// Number of threads that share a caster; fewer than in binning, since here the map has half the size, and a caster touches fewer tiles.
CONSTANT(uint, SHARING, 1u)

// Surveys a thread's share of a caster's tiles.
void survey(uint map, uint index, uint lane) {
    uvec2 low, high, first, last;
    if (!caster_touches(maps[map].caster_view, casters[index], low, high)) {
        return;
    }
    View view = maps[map].caster_view, fine = finer(view, SURVEY_CELLS);
    Caster caster = casters[map_casters(map) + index];
    caster_touches(fine, caster, first, last);
    vec3 share = share_of_tile(view, caster);
    uint edges = uint(share.x * share.y * LENGTH_UNITS) + 1u, optical_depth = uint(share.z * DEPTH_UNITS + 0.5);
    uvec2 tiles = tile_counts(view), size = high - low + 1u;
    for (uint i = lane; i < size.x * size.y; i += SHARING) {
        uvec2 tile = low + uvec2(i % size.x, i / size.x), from = first, to = last;
        uint place = tile.y * tiles.x + tile.x, first_tile = map * tiles.x * tiles.y;
        if (tile_hidden(view, caster, horizon[first_tile + place]) || !within_tile(tile, SURVEY_CELLS, from, to)) {
            continue;
        }
        uint cells = cells_met(fine, caster, tile, from, to);
        if (cells != 0u) {
#if TALLY == 1
            atomicOr(own[place].cells, cells);
            atomicAdd(own[place].edges, edges);
            atomicAdd(own[place].optical_depth, optical_depth);
#else
            atomicOr(surveys[first_tile + place].cells, cells);
            atomicAdd(surveys[first_tile + place].edges, edges);
            atomicAdd(surveys[first_tile + place].optical_depth, optical_depth);
#endif
        }
    }
}

void main() {
    uint map = gl_WorkGroupID.z, thread = gl_LocalInvocationIndex;
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint step = gl_NumWorkGroups.x * gl_NumWorkGroups.y * (THREADS / SHARING);
#if TALLY == 1
    uvec2 tiles = tile_counts(maps[map].caster_view);
    uint tile_count = tiles.x * tiles.y;
    for (uint i = thread; i < tile_count; i += THREADS) {
        own[i] = Survey(0u, 0u, 0u);
    }
    barrier();
#endif
    for (uint index = (group * THREADS + thread) / SHARING; index < caster_count; index += step) {
        survey(map, index, thread % SHARING);
    }
#if TALLY == 1
    barrier();
    for (uint i = thread; i < tile_count; i += THREADS) {
        if (own[i].cells != 0u) {
            atomicOr(surveys[map * tile_count + i].cells, own[i].cells);
            atomicAdd(surveys[map * tile_count + i].edges, own[i].edges);
            atomicAdd(surveys[map * tile_count + i].optical_depth, own[i].optical_depth);
        }
    }
#endif
}
