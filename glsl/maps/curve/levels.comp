#version 460
// Builds the levels of detail of all maps. For each texel, the mean transmittance of the four texels below it is sampled at the ends of
// equal steps from the first to the last of their nodes. A texel's nodes are chosen among these ends so that interpolation between them has
// the least squared error, summed over all ends. Dynamic programming finds them, with one thread per end, so that no thread has to walk
// along a whole curve. A texel past the map's edge, or without casters, transmits all light. Source: ours. Inputs: maps, nodes of the level
// below, counts. Output: nodes of the levels.
// Twin: reference::twin::avsm::levels. Invariant: at its nodes and behind them a curve is the mean of the four, up to rounding when stored.
#include "maps/level_tile.glsl"
#include "maps/curve/tiled.glsl"

// set 1: curve_levels
layout(set = 1, binding = 0, scalar) coherent buffer Nodes { uvec2 nodes[]; };
layout(set = 1, binding = 1, scalar) readonly buffer Counts { uint counts[]; };

uvec2 curve_pair(uint i) { return nodes[i]; }

#include "maps/curve/store.glsl"
#include "maps/curve/read.glsl"

// Number of equal steps: 16, or with 16 nodes 15, so that every end of a step is a node.
const uint STEPS = 16u - uint(NODES) / 16u;
const uint ENDS = STEPS + 1u;
const uint PAIRS = STEPS * ENDS / 2u;

// At first `scratch` holds the curves of the texels below: row by row of the tile, each node's depth and value. Later it holds, for each
// texel to build, the cost of the line between every two ends.
const uint BELOW_FLOATS = 2u * BELOW * MADE * uint(NODES);
// The costs of lines take more memory than the curves, except with 16 nodes.
const uint SCRATCH = MADE * PAIRS + uint(NODES) / 16u * (BELOW_FLOATS - MADE * PAIRS);
shared float scratch[SCRATCH];
// For each texel to build: its range of depths, the means at the ends of steps, and these means as values of nodes.
shared vec2 ranges[MADE];
shared float means[MADE * ENDS];
shared float values[MADE * ENDS];
// For each end, among all curves that have a node at that end: `costs` is the least cost of such a curve up to the end. `chosen` has one
// bit per end, set where that cheapest curve has a node. Both arrays are double-buffered.
shared float costs[2u * MADE * ENDS];
shared uint chosen[2u * MADE * ENDS];

// Where the curve of texel i begins, one of the four below texel t.
uint below_curve(LevelTile tile, uint t, uint i) {
    uvec2 at = below_texel(tile, t, i);
    return (at.y * 2u * tile.side + at.x) * uint(NODES);
}

Node below_node(uint i) { return Node(scratch[2u * i], scratch[2u * i + 1u]); }

// Reads and decodes the whole level below; one thread per node.
void read_below(LevelTile tile) {
    uint side = 2u * tile.side;
    [[dont_unroll]] for (uint i = gl_LocalInvocationIndex; i < side * side * uint(NODES); i += LEVEL_THREADS) {
        uint texel = i / uint(NODES);
        uint place = below_place(tile, uvec2(texel % side, texel / side));
        if (place != NONE && tile.level == 1u) {
            uvec2 tiles = gl_NumWorkGroups.xy;
            uint count = counts[(gl_WorkGroupID.z * tiles.y + gl_WorkGroupID.y) * tiles.x + gl_WorkGroupID.x];
            place = tile_skipped(count) ? NONE : place;
        }
        uint at = place * curve_pairs();
        Node node = Node(EMPTY, curve_unshadowed());
        if (place != NONE) {
            node = texel_node(at, i % uint(NODES), curve_range(at));
        }
        scratch[2u * i] = node.depth;
        scratch[2u * i + 1u] = node.value;
    }
}

float curve_at(uint curve, float depth) {
    uint before = 0u;
    for (uint i = 0u; i < uint(NODES); ++i) {
        before += uint(scratch[2u * (curve + i)] <= depth);
    }
    if (before == 0u) {
        return 1.0;
    }
    Node near = below_node(curve + before - 1u), far = below_node(curve + min(before, uint(NODES) - 1u));
    float extent = far.depth - near.depth;
    float along = far.depth < EMPTY && extent > 0.0 ? clamp((depth - near.depth) / extent, 0.0, 1.0) : 0.0;
    return curve_transmittance(mix(near.value, far.value, along));
}

float mean_at(LevelTile tile, uint t, float depth) {
    float mean = 0.0;
    for (uint i = 0u; i < BELOW; ++i) {
        mean += 0.25 * curve_at(below_curve(tile, t, i), depth);
    }
    return min(mean, 1.0);
}

// Range of depths from the first to the last node of the four texels below.
vec2 merged_range(LevelTile tile, uint t) {
    vec2 range = vec2(EMPTY, -EMPTY);
    for (uint i = 0u; i < BELOW; ++i) {
        uint curve = below_curve(tile, t, i);
        bool casts = below_node(curve + uint(NODES) - 1u).value != curve_unshadowed();
        for (uint k = 0u; casts && k < uint(NODES); ++k) {
            float depth = below_node(curve + k).depth;
            range = depth < EMPTY ? vec2(min(range.x, depth), max(range.y, depth)) : range;
        }
    }
    return range;
}

// Whether any of the four texels below has casters.
bool makes_curve(uint t) { return ranges[t].x <= ranges[t].y; }

float value_of(float mean) {
    return !EXPONENTIAL ? mean : mean < 1.0 ? min(-log(max(mean, 1e-35)), MAX_OPTICAL_DEPTH) : 0.0;
}

// Cost of a line from end `from` to end `to`: the sum of its squared differences from the means in between. `first`: index of the texel's
// first end.
float line_cost(uint first, uint from, uint to) {
    float rise = (values[first + to] - values[first + from]) / float(to - from);
    float left = means[first + from], factor = EXPONENTIAL ? exp(-rise) : 1.0, cost = 0.0;
    for (uint k = from + 1u; k < to; ++k) {
        left = EXPONENTIAL ? left * factor : left + rise;
        cost += (left - means[first + k]) * (left - means[first + k]);
    }
    return cost;
}

// Cost in front of a curve whose first node is at end `to`: up to there a curve transmits all light.
float front_cost(uint first, uint to) {
    float cost = 0.0;
    for (uint k = 0u; k < to; ++k) {
        cost += (1.0 - means[first + k]) * (1.0 - means[first + k]);
    }
    return cost;
}

// Index of the line between two ends among a texel's lines: (0, 1), (0, 2), (1, 2), and so on.
uint line_place(uint from, uint to) { return to * (to - 1u) / 2u + from; }

// Chooses nodes among the ends; the last end is always one. Returns where the copy of `chosen` that holds them begins.
uint choose_nodes(uint count) {
    uint thread = gl_LocalInvocationIndex, now = 0u;
    // Neighbouring threads process lines of equal length, the longest first, between neighbouring ends.
    for (uint i = thread; i < count * PAIRS; i += LEVEL_THREADS) {
        uint t = i / PAIRS, pair = i % PAIRS, shorter = uint(0.5 * (sqrt(8.0 * float(pair) + 1.0) - 1.0) + 1e-3);
        uint from = pair - shorter * (shorter + 1u) / 2u, to = from + STEPS - shorter;
        if (makes_curve(t)) {
            scratch[t * PAIRS + line_place(from, to)] = line_cost(t * ENDS, from, to);
        }
    }
    for (uint i = thread; i < count * ENDS; i += LEVEL_THREADS) {
        uint first = i % count * ENDS, to = i / count;
        costs[first + to] = front_cost(first, to);
        chosen[first + to] = 1u << to;
    }
    barrier();
    [[dont_unroll]] for (uint node = 1u; node < uint(NODES); ++node) {
        uint next = MADE * ENDS - now;
        for (uint i = thread; i < count * ENDS; i += LEVEL_THREADS) {
            uint t = i % count, to = i / count, before = now + t * ENDS, lines = t * PAIRS + line_place(0u, to);
            // Another node is added only if it helps.
            float least = costs[before + to];
            uint best = chosen[before + to];
            for (uint from = 0u; from < to && makes_curve(t); ++from) {
                float cost = costs[before + from] + scratch[lines + from];
                if (cost < least) {
                    least = cost;
                    best = chosen[before + from] | 1u << to;
                }
            }
            costs[next + t * ENDS + to] = least;
            chosen[next + t * ENDS + to] = best;
        }
        now = next;
        barrier();
    }
    return now;
}

void make_level(LevelTile tile) {
    uint thread = gl_LocalInvocationIndex, count = tile_texels(tile);
    read_below(tile);
    barrier();
    if (thread < count) {
        ranges[thread] = merged_range(tile, thread);
    }
    barrier();
    for (uint i = thread; i < count * ENDS; i += LEVEL_THREADS) {
        vec2 range = ranges[i / ENDS];
        float along = float(i % ENDS) / float(STEPS);
        means[i] = makes_curve(i / ENDS) ? mean_at(tile, i / ENDS, depth_along(range, along)) : 1.0;
        values[i] = value_of(means[i]);
    }
    barrier();
    uint now = 0u;
    if (ENDS > uint(NODES)) {
        now = choose_nodes(count);
    }
    uint place = thread < count ? made_place(tile, thread) : NONE;
    if (place == NONE) {
        return;
    }
    vec2 range = ranges[thread];
    bool any_node = makes_curve(thread);
    uint ends = ENDS > uint(NODES) ? chosen[now + thread * ENDS + STEPS] : (1u << ENDS) - 1u;
    Node curve[NODES], last = Node(EMPTY, curve_unshadowed());
    [[unroll]] for (int i = 0; i < NODES; ++i) {
        last.depth = EMPTY;
        if (any_node && ends != 0u) {
            uint end = uint(findLSB(ends));
            ends &= ends - 1u;
            float value = values[thread * ENDS + end];
            // Rounding of the means may break the order of values.
            value = EXPONENTIAL ? max(value, last.value) : min(value, last.value);
            last = Node(depth_along(range, float(end) / float(STEPS)), value);
        }
        curve[i] = last;
    }
    store_curve(place, curve);
}
