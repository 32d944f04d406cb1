#version 460
// Computes where each tile's nodes begin: after the nodes of all previous tiles. One workgroup scans the tiles of a group of maps. In and
// out: tile_starts, on input the number of nodes of each tile; state.
#include "technique/deep_shadow_map/maps.glsl"

const uint SCAN_THREADS = 128u;
layout(local_size_x = SCAN_THREADS) in;

// set 1: deep_shadow_map
layout(set = 1, binding = 3, scalar) buffer TileStarts { uint tile_starts[]; };
layout(set = 1, binding = 4, scalar) buffer State { DeepState state; };

shared uint sums[SCAN_THREADS];

void main() {
    uvec2 tiles = map_tiles();
    uint t = gl_LocalInvocationIndex, count = map_count * tiles.x * tiles.y, each = (count + SCAN_THREADS - 1u) / SCAN_THREADS;
    uint begin = first_map * tiles.x * tiles.y, end = begin + min((t + 1u) * each, count);
    begin += min(t * each, count);
    uint sum = 0u;
    for (uint i = begin; i < end; ++i) {
        sum += tile_starts[i];
    }
    sums[t] = sum;
    barrier();
    for (uint by = 1u; by < SCAN_THREADS; by *= 2u) {
        uint more = t >= by ? sums[t - by] : 0u;
        barrier();
        sums[t] += more;
        barrier();
    }
    uint before = group > 0u ? state.nodes : 0u;
    uint start = before + sums[t] - sum;
    for (uint i = begin; i < end; ++i) {
        uint nodes = tile_starts[i];
        tile_starts[i] = start;
        start += nodes;
    }
    barrier();
    if (t == 0u) {
        state.nodes = before + sums[SCAN_THREADS - 1u];
        state.covered = group > 0u ? state.covered : 0u;
    }
}
