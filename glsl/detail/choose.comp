#version 460
// Chooses how fine each tile of all maps is, and where its blocks stand, as fine as so many blocks allow. One workgroup.
// Where edges of a strength E stand per texel, the error falls with about the side to the power of −1 (hair: −0.7), so that a
// tile's side goes with E to about a third; that edges hide each other makes it a fifth of E / (1 + optical depth).
// Inputs: surveys. Outputs: slots, totals. Twin: reference::twin::detail::choose.
// Invariants: there are never more blocks than were allowed; only whole numbers are computed with, so that the same surveys
// are the same choice on every device; every block that a caster meets has a place.
#include "bins/totals.glsl"
#include "detail/blocks.glsl"
#include "detail/survey.glsl"
#include "maps/rounds.glsl"
#include "maps/scene.glsl"

const uint THREADS = 128u;

layout(local_size_x = THREADS) in;

layout(push_constant, scalar) uniform ChoosePush {
    uint tile_count;  // of all maps
    uint across;      // tiles
    uint block_count;  // at most
};

// False: blocks without casters are built too.
CONSTANT(bool, TILED, false)

layout(set = 1, binding = 3, scalar) writeonly buffer Totals { BinTotals totals[]; };
layout(set = 1, binding = 7, scalar) writeonly buffer Slots { uint slots[]; };
layout(set = 2, binding = 0, scalar) readonly buffer Surveys { Survey surveys[]; };

shared uint sums[THREADS];
shared uint total;
// Of a side: which cells a block of a row reaches over; how many blocks of a row reach over some of a mask of cells. Whole
// numbers are slow to divide.
shared uint cells_of_block[8][8];
shared uint blocks_of_row[8][16];

// 16 log2(x), x > 0, the mantissa linear.
int log_16(uint x) {
    int top = findMSB(x);
    return 16 * top + int(x << (31 - top) >> 27 & 15u);
}

// Side of a tile at a scale: 2^(level / 80), rounded, where 16 levels are an octave of edges to the power of a fifth.
uint tile_side(Survey survey, uint tile, int scale) {
    if (survey.cells == 0u) {
        return 8u;
    }
    int level = log_16(survey.edges + 1u) - log_16(uint(DEPTH_UNITS) + survey.optical_depth) + 160 + scale;
    // Tiles that are alike do not all change at the same scale.
    level += int((tile % across * 13u + tile / across * 29u) & 31u);
    // 80 log2(1.5), 80 log2(2.5), …
    return 1u + uint(level >= 47) + uint(level >= 106) + uint(level >= 145) + uint(level >= 174) + uint(level >= 197)
         + uint(level >= 217) + uint(level >= 233);
}

// Scales at which all tiles have side 1, and from which on all have side 8.
const int LEAST_SCALE = -760;
const int MOST_SCALE = 240;

Survey surveyed(uint tile) {
    Survey survey = surveys[tile];
    survey.cells = TILED ? survey.cells : 0xFFFFu;
    return survey;
}

// Cells that a block reaches over along x or y, as a mask: place i of `side`.
uint block_cells(uint i, uint side) { return cells_of_block[side - 1u][i]; }

// The tables above. All threads call it alike.
void fill_tables() {
    uint i = gl_LocalInvocationIndex, side = i / 16u + 1u;
    if (i % 16u < side) {
        uint first = i % 16u * SURVEY_CELLS / side, last = ((i % 16u + 1u) * SURVEY_CELLS - 1u) / side;
        cells_of_block[side - 1u][i % 16u] = (2u << last) - (1u << first);
    }
    barrier();
    uint count = 0u;
    for (uint x = 0u; x < side; ++x) {
        count += uint((i % 16u & block_cells(x, side)) != 0u);
    }
    blocks_of_row[side - 1u][i % 16u] = count;
    barrier();
}

// Cells of a row of blocks in which there are casters, as a mask of x.
uint row_cells(uint cells, uint y, uint side) {
    uint rows = block_cells(y, side), mask = 0u;
    [[unroll]] for (uint row = 0u; row < SURVEY_CELLS; ++row) {
        mask |= (rows >> row & 1u) != 0u ? cells >> (row * SURVEY_CELLS) & 15u : 0u;
    }
    return mask;
}

uint used_blocks(uint cells, uint side) {
    uint count = 0u;
    for (uint y = 0u; y < side; ++y) {
        count += blocks_of_row[side - 1u][row_cells(cells, y, side)];
    }
    return count;
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    fill_tables();
    int scale = LEAST_SCALE, above = MOST_SCALE;
    while (above - scale > 1) {
        int middle = (scale + above) / 2;
        uint sum = 0u;
        for (uint tile = thread; tile < tile_count; tile += THREADS) {
            Survey survey = surveyed(tile);
            sum += used_blocks(survey.cells, tile_side(survey, tile, middle));
        }
        if (thread == 0u) {
            total = 0u;
        }
        barrier();
        atomicAdd(total, sum);
        barrier();
        bool fits = total <= block_count;
        scale = fits ? middle : scale;
        above = fits ? above : middle;
        barrier();
    }
    uint run = (tile_count + THREADS - 1u) / THREADS;
    uint begin = min(thread * run, tile_count), end = min(begin + run, tile_count), count = 0u;
    for (uint tile = begin; tile < end; ++tile) {
        Survey survey = surveyed(tile);
        count += used_blocks(survey.cells, tile_side(survey, tile, scale));
    }
    sums[thread] = count;
    barrier();
    uint place = 0u;
    for (uint i = 0u; i < thread; ++i) {
        place += sums[i];
    }
    for (uint tile = begin; tile < end; ++tile) {
        Survey survey = surveyed(tile);
        uint side = tile_side(survey, tile, scale);
        uint slot = tile * SLOTS;
        for (uint y = 0u; y < side; ++y) {
            uint mask = row_cells(survey.cells, y, side);
            for (uint x = 0u; x < side; ++x, ++slot) {
                bool used = (mask & block_cells(x, side)) != 0u;
                place += uint(used);
                slots[slot] = slot_word(side, used ? place : 0u);
            }
        }
        for (; slot < (tile + 1u) * SLOTS; ++slot) {
            slots[slot] = slot_word(side, 0u);
        }
    }
    if (rounds_ran_out(tile_count)) {
        totals[0].cut_short = 1u;
    }
}
