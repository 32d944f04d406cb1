#version 460
// Builds the levels of detail of all maps. For each texel, the mean transmittance of the four texels below it is taken at the ends of even
// steps from the first to the last of their nodes. A texel's nodes are those ends between which interpolation errs least, by the sum of
// squares over all ends. Dynamic programming finds them: a thread has one or two ends, and what lines to them cost in registers. A texel
// past the map's edge, or without casters, lets all light through. Source: ours. Inputs: maps, nodes of the level below, counts. Output:
// nodes of the levels.
// Twin: reference::twin::avsm::levels. Invariant: at its nodes and behind them a curve is the mean of the four, to the rounding of storing.
#define LEVEL_THREADS 128u
#include "maps/level_tile.glsl"
#include "maps/curve/tiled.glsl"

// set 1: curve_levels
layout(set = 1, binding = 0, scalar) coherent buffer Nodes { uvec2 nodes[]; };
layout(set = 1, binding = 1, scalar) readonly buffer Counts { uint counts[]; };

uvec2 curve_pair(uint i) { return nodes[i]; }

#include "maps/curve/store.glsl"
#include "maps/curve/read.glsl"

// Even steps: 16, or with 16 nodes 15, so that every end of a step is a node.
const uint STEPS = 16u - uint(NODES) / 16u;
const uint ENDS = STEPS + 1u;

// The curves of the texels below: row after row of the tile, each node's depth and value.
shared float below[2u * BELOW * MADE * uint(NODES)];
// For each texel that is made: its range of depths, the means at the ends of steps, and these means as values of nodes.
shared vec2 ranges[MADE];
shared float means[MADE * ENDS];
shared float values[MADE * ENDS];
// For each end, among all curves that have a node at that end: `costs` is the least cost of such a curve up to the end. `chosen` says at
// which ends that cheapest curve has nodes, one bit per end. There are two copies of both, written in turns.
shared float costs[2u * MADE * ENDS];
shared uint chosen[2u * MADE * ENDS];

// Where the curve of texel i of the four below texel t begins.
uint below_curve(LevelTile tile, uint t, uint i) {
    uvec2 at = below_texel(tile, t, i);
    return (at.y * 2u * tile.side + at.x) * uint(NODES);
}

Node below_node(uint i) { return Node(below[2u * i], below[2u * i + 1u]); }

// Reads and decodes all of the level below; one thread per node.
void read_below(LevelTile tile) {
    uint side = 2u * tile.side;
    bool empty = false;
    if (tile.level == 1u) {
        uvec2 tiles = gl_NumWorkGroups.xy;
        empty = tile_skipped(counts[(gl_WorkGroupID.z * tiles.y + gl_WorkGroupID.y) * tiles.x + gl_WorkGroupID.x]);
    }
    for (uint i = gl_LocalInvocationIndex; i < side * side * uint(NODES); i += LEVEL_THREADS) {
        uint texel = i / uint(NODES), place = empty ? NONE : below_place(tile, uvec2(texel % side, texel / side));
        uint at = place * curve_pairs();
        Node node = Node(EMPTY, curve_unshadowed());
        if (place != NONE) {
            node = texel_node(at, i % uint(NODES), curve_range(at));
        }
        below[2u * i] = node.depth;
        below[2u * i + 1u] = node.value;
    }
}

float curve_at(uint curve, float depth) {
    uint before = 0u;
    for (uint i = 0u; i < uint(NODES); ++i) {
        before += uint(below[2u * (curve + i)] <= depth);
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

// The range of depths from the first node of the four texels below to their last.
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

// A thread has up to two ends after the first: `costs_of` holds what leads to each, in registers.
const uint ENDS_PER_THREAD = 2u;
// Steps where nodes are chosen: a literal, so that loops over ends unroll.
const uint MOST_STEPS = 16u;

// The cost of the line from every end to end `to`: the sum of squares of its differences from the means in between. `first`: the place of
// the texel's first end. Ends from `to` on get no meaning.
void line_costs(uint first, uint to, out float lines[MOST_STEPS]) {
    float mean[MOST_STEPS], last = values[first + to];
    [[unroll]] for (uint k = 0u; k < MOST_STEPS; ++k) { mean[k] = means[first + k]; }
    [[unroll]] for (uint from = 0u; from < MOST_STEPS; ++from) {
        float rise = (last - values[first + from]) / float(max(int(to) - int(from), 1));
        float left = mean[from], factor = EXPONENTIAL ? exp(-rise) : 1.0, cost = 0.0;
        [[unroll]] for (uint k = 1u; k < MOST_STEPS; ++k) {
            if (k > from) {
                left = EXPONENTIAL ? left * factor : left + rise;
                float off = left - mean[k];
                cost += k < to ? off * off : 0.0;
            }
        }
        lines[from] = cost;
    }
}

// The cost in front of a curve whose first node is at end `to`: up to there a curve lets all light through.
float front_cost(uint first, uint to) {
    float cost = 0.0;
    for (uint k = 0u; k < to; ++k) {
        cost += (1.0 - means[first + k]) * (1.0 - means[first + k]);
    }
    return cost;
}

// Chooses nodes among the ends; the last end is always one. Returns which copy of `chosen` has them.
uint choose_nodes(uint count) {
    uint thread = gl_LocalInvocationIndex, now = 0u;
    uint texel[ENDS_PER_THREAD], end[ENDS_PER_THREAD], best[ENDS_PER_THREAD];
    float lines[ENDS_PER_THREAD][MOST_STEPS], least[ENDS_PER_THREAD];
    [[unroll]] for (uint e = 0u; e < ENDS_PER_THREAD; ++e) {
        uint i = thread + e * LEVEL_THREADS, t = i % count, to = i / count + 1u;
        // Threads without an end, and those of texels without casters, have none.
        texel[e] = t * ENDS;
        end[e] = to <= STEPS && makes_curve(t) ? to : 0u;
        if (end[e] != 0u) {
            line_costs(texel[e], to, lines[e]);
            least[e] = front_cost(texel[e], to);
            best[e] = 1u << to;
            costs[texel[e] + to] = least[e];
            chosen[texel[e] + to] = best[e];
        }
    }
    // In front of the first end nothing costs, however many nodes there are.
    if (thread < 2u * count) {
        uint first = thread / count * MADE * ENDS + thread % count * ENDS;
        costs[first] = 0.0;
        chosen[first] = 1u;
    }
    barrier();
    [[dont_unroll]] for (uint node = 1u; node < uint(NODES); ++node) {
        uint next = MADE * ENDS - now;
        [[unroll]] for (uint e = 0u; e < ENDS_PER_THREAD; ++e) {
            if (end[e] != 0u) {
                uint before = now + texel[e], cheapest = NONE;
                // Another node is added only where it helps.
                [[unroll]] for (uint from = 0u; from < MOST_STEPS; ++from) {
                    float cost = costs[before + from] + lines[e][from];
                    if (from < end[e] && cost < least[e]) {
                        least[e] = cost;
                        cheapest = from;
                    }
                }
                if (cheapest != NONE) {
                    best[e] = chosen[before + cheapest] | 1u << end[e];
                }
                costs[next + texel[e] + end[e]] = least[e];
                chosen[next + texel[e] + end[e]] = best[e];
            }
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
            // Rounding of means may break the order of values.
            value = EXPONENTIAL ? max(value, last.value) : min(value, last.value);
            last = Node(depth_along(range, float(end) / float(STEPS)), value);
        }
        curve[i] = last;
    }
    store_curve(place, curve);
}
