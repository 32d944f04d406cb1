#version 460
// Chooses the resolution of each tile of all maps, and where its blocks are stored: as fine as the allowed number of blocks permits. One
// workgroup. A tile's side is its number of blocks per side (maps/detail/blocks.glsl). With edges of strength E per texel, the error falls
// roughly as the side to the power of −1 (hair: −0.7), so that the best side grows roughly as the cube root of E. Since edges hide each
// other, the side follows the fifth root of E / (1 + optical depth), times a scale that all tiles share: the greatest for which there are
// enough blocks. The number of blocks at each scale is counted from the scales at which each tile changes its side. Inputs: surveys.
// Outputs: slots, listed, totals. Twin: reference::twin::detail::choose. Invariants: there are never more blocks than allowed; all
// arithmetic is on integers, so that the same surveys give the same choice on every device; every block that a caster touches has a place.
#include "maps/bins/set.glsl"
#include "maps/bins/totals.glsl"
#include "maps/detail/blocks.glsl"
#include "maps/detail/set.glsl"
#include "maps/detail/survey.glsl"
#include "maps/rounds.glsl"
#include "maps/scene.glsl"

// Workgroup size: a multiple of SLOTS, at least 128.
layout(local_size_x_id = ID_WORKGROUP) in;
// The workgroup's size again: some tools do not accept a specialized gl_WorkGroupSize as a constant.
CONSTANT(uint, THREADS, 128u)

layout(push_constant, scalar) uniform ChoosePush {
    uint tile_count;  // number of tiles of all maps
    uint across;      // number of tiles across a map
    uint block_count;  // maximum number of blocks, over all maps
};

// True also lists the blocks: their number, then their slots in the order of their places.
CONSTANT(bool, LISTS, false)

// False: blocks without casters are built too.
CONSTANT(bool, TILED, false)

BINS_TOTALS(writeonly buffer)
BINS_SLOTS(writeonly buffer)
DETAIL_SURVEYS(readonly buffer)
DETAIL_LISTED(writeonly buffer)

// The scale at which all tiles have side 1, and the scale from which few tiles have a side below 8.
const int LEAST_SCALE = -760;
const int MOST_SCALE = 240;
const uint SCALES = uint(MOST_SCALE - LEAST_SCALE);

// Increase in the number of blocks from one scale to the next, modulo 2³².
shared uint more[SCALES];
shared uint sums[THREADS];
// Number of threads per run of the prefix sum, and number of runs.
const uint RUN = 32u, RUNS = (THREADS + RUN - 1u) / RUN;
shared uint run_sums[RUNS];
// The greatest scale that fits, counted from LEAST_SCALE.
shared uint greatest;
// Tables for one axis, by a tile's side. cells_of_block: a mask of the cells that a block of a row covers. blocks_of_row: for each mask of
// cells, a mask of the blocks of a row that cover any of these cells. The tables save integer divisions, which are slow.
shared uint cells_of_block[8][8];
shared uint blocks_of_row[8][16];
// For THREADS tiles at a time. used_of_tile: one bit for each of a tile's blocks that casters touch. word_of_tile: the tile's side and the
// number of blocks before the tile, in the form of a word of the table (maps/detail/blocks.glsl).
shared uvec2 used_of_tile[THREADS];
shared uint word_of_tile[THREADS];
// Number of blocks of all tiles before the current THREADS tiles.
shared uint placed;

// 16 log2(x), x > 0, linear in the mantissa.
int log_16(uint x) {
    int top = findMSB(x);
    return 16 * top + int(x << (31 - top) >> 27 & 15u);
}

// 80 log2(1.5), 80 log2(2.5), …: levels from which a tile has side 2, 3, …
const int LEVELS[7] = int[](47, 106, 145, 174, 197, 217, 233);

// Level of a tile. At scale 0 the tile's side is 2^(level / 80), rounded. Doubling the edges raises a tile's level by 16, which makes its
// side 2^(1/5) times as large.
int tile_level(Survey survey, uint tile) {
    int level = log_16(survey.edges + 1u) - log_16(uint(DEPTH_UNITS) + survey.optical_depth) + 160;
    // An offset, so that similar tiles do not all change at the same scale.
    return level + int((tile % across * 13u + tile / across * 29u) & 31u);
}

// Side of a tile at a scale.
uint tile_side(Survey survey, uint tile, int scale) {
    if (survey.cells == 0u) {
        return 8u;
    }
    int level = tile_level(survey, tile) + scale;
    uint side = 1u;
    [[unroll]] for (uint i = 0u; i < 7u; ++i) {
        side += uint(level >= LEVELS[i]);
    }
    return side;
}

// First scale, counted from LEAST_SCALE, at which a tile of this level reaches a side; SCALES or more if it never does.
uint first_scale(int level, uint side) {
    return side == 1u ? 0u : side > 8u ? SCALES : uint(max(LEVELS[side - 2u] - level - LEAST_SCALE, 0));
}

Survey surveyed(uint tile) {
    Survey survey = surveys[tile];
    survey.cells = TILED ? survey.cells : 0xFFFFu;
    return survey;
}

// Cells that block `i` of `side` covers along x or y, as a mask.
uint block_cells(uint i, uint side) { return cells_of_block[side - 1u][i]; }

// Fills the tables above. All threads must call it.
void fill_tables() {
    uint i = gl_LocalInvocationIndex, side = min(i / 16u + 1u, 8u);
    if (i < 128u && i % 16u < side) {
        uint first = i % 16u * SURVEY_CELLS / side, last = ((i % 16u + 1u) * SURVEY_CELLS - 1u) / side;
        cells_of_block[side - 1u][i % 16u] = (2u << last) - (1u << first);
    }
    barrier();
    uint blocks = 0u;
    [[dont_unroll]] for (uint x = 0u; x < side; ++x) {
        blocks |= uint((i % 16u & block_cells(x, side)) != 0u) << x;
    }
    if (i < 128u) {
        blocks_of_row[side - 1u][i % 16u] = blocks;
    }
    barrier();
}

// Cells with casters in a row of blocks, as a mask of x.
uint row_cells(uint cells, uint y, uint side) {
    uint rows = block_cells(y, side), mask = 0u;
    [[dont_unroll]] for (uint row = 0u; row < SURVEY_CELLS; ++row) {
        mask |= (rows >> row & 1u) != 0u ? cells >> (row * SURVEY_CELLS) & 15u : 0u;
    }
    return mask;
}

// Blocks that cover cells with casters, one bit each.
uvec2 used_blocks(uint cells, uint side) {
    uvec2 used = uvec2(0u);
    [[dont_unroll]] for (uint y = 0u; y < side && cells != 0u; ++y) {
        uint row = blocks_of_row[side - 1u][row_cells(cells, y, side)], at = y * side;
        used.x |= at < 32u ? row << at : 0u;
        used.y |= at >= 32u ? row << (at - 32u) : at > 24u ? row >> (32u - at) : 0u;
    }
    return used;
}

uint bit_count(uvec2 bits) { return bitCount(bits.x) + bitCount(bits.y); }

// Sum of `value` over all earlier threads. All threads must call it.
uint sum_before(uint value) {
    uint thread = gl_LocalInvocationIndex, run = thread / RUN * RUN, sum = 0u;
    sums[thread] = value;
    barrier();
    // Not unrolled, here and below: code that runs once waits for its instructions to load, so they should be few.
    [[dont_unroll]] for (uint i = run; i < thread; ++i) {
        sum += sums[i];
    }
    if (thread == min(run + RUN, THREADS) - 1u) {
        run_sums[thread / RUN] = sum + value;
    }
    barrier();
    [[dont_unroll]] for (uint i = 0u; i < thread / RUN; ++i) {
        sum += run_sums[i];
    }
    return sum;
}

// The greatest scale with no more blocks than allowed. All threads must call it.
int greatest_scale() {
    uint thread = gl_LocalInvocationIndex;
    for (uint i = thread; i < SCALES; i += THREADS) {
        more[i] = 0u;
    }
    if (thread == 0u) {
        greatest = placed = 0u;
    }
    barrier();
    // For each tile and each side that the tile may have: counts the tile's blocks at that side, adds them at the scale at which the tile
    // reaches that side, and subtracts them at the scale at which it reaches the next side.
    [[dont_unroll]] for (uint i = thread; i < tile_count * 8u; i += THREADS) {
        uint tile = i / 8u, side = i % 8u + 1u;
        Survey survey = surveyed(tile);
        int level = survey.cells == 0u ? 0 : tile_level(survey, tile);
        uint used = bit_count(used_blocks(survey.cells, side)), from = first_scale(level, side), to = first_scale(level, side + 1u);
        if (used > 0u && from < SCALES) {
            atomicAdd(more[from], used);
        }
        if (used > 0u && to < SCALES) {
            atomicAdd(more[to], 0u - used);
        }
    }
    barrier();
    uint run = (SCALES + THREADS - 1u) / THREADS, begin = min(thread * run, SCALES), end = min(begin + run, SCALES), sum = 0u;
    [[dont_unroll]] for (uint i = begin; i < end; ++i) {
        sum += more[i];
    }
    sum = sum_before(sum);
    uint fits = 0u, fitting = 0u;
    [[dont_unroll]] for (uint i = begin; i < end; ++i) {
        sum += more[i];
        if (sum <= block_count) {
            fits = 1u;
            fitting = i;
        }
    }
    barrier();
    sums[thread] = fits;
    barrier();
    // Scales that fit are contiguous: only the last one of each thread's run performs the atomic operation.
    if (fits != 0u && (thread == THREADS - 1u || sums[min(thread + 1u, THREADS - 1u)] == 0u)) {
        atomicMax(greatest, fitting);
    }
    barrier();
    return LEAST_SCALE + int(greatest);
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    fill_tables();
    int scale = greatest_scale();
    // Each thread writes the words of one slot, for different tiles.
    uint slot = thread % SLOTS, low = min(slot, 32u), high = max(slot, 32u) - 32u;
    uvec2 bit = slot < 32u ? uvec2(1u << slot, 0u) : uvec2(0u, 1u << high);
    uvec2 bits_before = uvec2(low == 32u ? ~0u : (1u << low) - 1u, (1u << high) - 1u);
    for (uint first = 0u; first < tile_count; first += THREADS) {
        uint tile = first + thread, side = 1u;
        uvec2 used = uvec2(0u);
        if (tile < tile_count) {
            Survey survey = surveyed(tile);
            side = tile_side(survey, tile, scale);
            used = used_blocks(survey.cells, side);
        }
        uint before = placed + sum_before(bit_count(used));
        used_of_tile[thread] = used;
        word_of_tile[thread] = slot_word(side, before);
        barrier();
        if (thread == THREADS - 1u) {
            placed = before + bit_count(used);
        }
        // Neighbouring threads write neighbouring words.
        [[dont_unroll]] for (uint its = thread / SLOTS; its < min(THREADS, tile_count - first); its += THREADS / SLOTS) {
            uint word = word_of_tile[its];
            uvec2 all = used_of_tile[its];
            side = slot_side(word);
            if (slot < side * side) {
                bool is_used = bit_count(all & bit) != 0u;
                uint place = slot_place(word) + bit_count(all & bits_before), at = (first + its) * SLOTS + slot;
                slots[at] = slot_word(side, is_used ? place + 1u : 0u);
                if (LISTS && is_used) {
                    listed[place + 1u] = at;
                }
            }
        }
        barrier();
    }
    if (LISTS && thread == 0u) {
        listed[0] = placed;
    }
    if (rounds_ran_out(tile_count)) {
        totals[0].cut_short = 1u;
    }
}
