#version 460
// What casters there are in each tile: which of its cells they meet, and how long and strong their edges are. A caster's share
// of a tile is the most that it can be, which is enough to tell tiles apart.
// Inputs: maps, casters, horizon. Outputs: surveys (cleared before). Twin: reference::twin::detail::survey.
// Invariants: sums are whole numbers, so that the order of the casters is no matter; a cell that any ray through the tile meets
// a caster in is marked.
#include "detail/casters.glsl"
#include "detail/survey.glsl"

layout(local_size_x = BIN_THREADS) in;

layout(set = 1, binding = 6, scalar) readonly buffer Horizon { float horizon[]; };
layout(set = 2, binding = 0, scalar) buffer Surveys { Survey surveys[]; };

// Cells reach so far, in their own texels, against rounding.
const float OUTSET = 0.0625;

// Length of the caster's edge within a tile, in texels, x; what it takes of the light, y; its mean optical depth over the
// tile, z.
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
    return vec3(min(edge, 8.0), optical_depth / (1.0 + optical_depth), min(area / 64.0 * optical_depth, 1.0));
}

void main() {
    uint map = gl_WorkGroupID.z, index = map_thread() / TILE_LANES, lane = map_thread() % TILE_LANES;
    uvec2 low, high, first, last;
    if (index >= caster_count || !caster_touches(maps[map].volume, casters[index], low, high)) {
        return;
    }
    View view = maps[map].volume, fine = finer(view, SURVEY_CELLS);
    Caster caster = casters[index];
    caster_touches(fine, caster, first, last);
    vec3 share = share_of_tile(view, caster);
    uvec2 tiles = tile_counts(view), size = high - low + 1u;
    for (uint i = lane; i < size.x * size.y; i += TILE_LANES) {
        uvec2 tile = low + uvec2(i % size.x, i / size.x), from = first, to = last;
        uint place = (map * tiles.y + tile.y) * tiles.x + tile.x, cells = 0u;
        if (tile_hidden(view, caster, horizon[place]) || !within_tile(tile, SURVEY_CELLS, from, to)) {
            continue;
        }
        for (uint y = from.y; y <= to.y; ++y) {
            for (uint x = from.x; x <= to.x; ++x) {
                bool missed = tile_missed(tile_distance(fine, caster, uvec2(x, y), -OUTSET));
                cells |= missed ? 0u : 1u << (y % SURVEY_CELLS * SURVEY_CELLS + x % SURVEY_CELLS);
            }
        }
        if (cells != 0u) {
            atomicOr(surveys[place].cells, cells);
            atomicAdd(surveys[place].edges, uint(share.x * share.y * LENGTH_UNITS) + 1u);
            atomicAdd(surveys[place].optical_depth, uint(share.z * DEPTH_UNITS + 0.5));
        }
    }
}
