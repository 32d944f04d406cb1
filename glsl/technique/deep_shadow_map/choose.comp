#version 460
// Bisects for the least error bound whose nodes fit into the buffer, one step per round. Round 0 sets the bounds of the search; the last
// round leaves an error whose nodes fit. Input: tile_starts, the number of nodes of each tile at the error just tried. In and out: state.
// Invariant: the nodes of the final error have been counted, or it is the greatest error.
#include "technique/deep_shadow_map/maps.glsl"

const uint SCAN_THREADS = 128u;
layout(local_size_x = SCAN_THREADS) in;

// set 1: deep_shadow_map
layout(set = 1, binding = 3, scalar) readonly buffer TileStarts { uint tile_starts[]; };
layout(set = 1, binding = 4, scalar) buffer State { DeepState state; };

// Number of rounds of a search, and the least and the greatest error that it tries.
const uint ROUNDS = 14u;
const float LEAST_ERROR = 1.0 / 16384.0;
const float MOST_ERROR = 0.5;

shared uint sum;

void main() {
    uvec2 tiles = map_tiles();
    uint t = gl_LocalInvocationIndex, count = map_count * tiles.x * tiles.y;
    if (t == 0u) {
        sum = 0u;
    }
    barrier();
    uint its = 0u;
    for (uint i = t; round > 0u && i < count; i += SCAN_THREADS) {
        its += tile_starts[i];
    }
    atomicAdd(sum, its);
    barrier();
    if (t > 0u) {
        return;
    }
    if (round == 0u) {
        state.low = LEAST_ERROR;
        state.high = MOST_ERROR;
    } else if (sum <= node_room) {
        state.high = state.error;
    } else {
        state.low = state.error;
    }
    state.error = round < ROUNDS ? sqrt(state.low * state.high) : state.high;
}
