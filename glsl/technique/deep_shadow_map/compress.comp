#version 460
// Sweeps along each texel's curve in the order of its events, and keeps the fewest nodes that stay within the error. One workgroup per
// tile. Inputs: heads, events, counters. Twin: reference::twin::deep_shadow_map. Invariants: optical depth is summed in integers, so that a
// slope that has ended leaves no rounding error behind and casters may come in any order; a texel without casters has no nodes.

// The first run counts nodes. Outputs: starts, within the tile; tile_starts, the number of nodes of each tile. A second run, with
// is_written in the push constants, writes them. Input: tile_starts, from scan. Outputs: nodes; starts, from the first tile on. One
// pipeline does both, since drivers that compile for the CPU take long to build it.
#include "technique/deep_shadow_map/maps.glsl"
#include "technique/deep_shadow_map/node.glsl"
#include "technique/deep_shadow_map/wide.glsl"
#include "maps/rounds.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// set 1: list
layout(set = 1, binding = 0, r32ui) uniform readonly uimage2D heads;
layout(set = 1, binding = 2, scalar) buffer Counters { uint counters[]; };
// set 2: deep_shadow_map
layout(set = 2, binding = 0, scalar) readonly buffer Events { Segment events[]; };
layout(set = 2, binding = 1, scalar) writeonly buffer Nodes { uint nodes[]; };
layout(set = 2, binding = 2, scalar) buffer Starts { uint starts[]; };
layout(set = 2, binding = 3, scalar) buffer TileStarts { uint tile_starts[]; };
layout(set = 2, binding = 4, scalar) buffer State { DeepState state; };

// Index of the texel's first node.
uint first;

// Number of final nodes, and the last of them.
uint kept;
Node last_kept;

void keep_node(Node node) {
    if (is_written > 0u && first + kept < node_room) {
        uint place = (first + kept) * stored_words;
        if (stored_words == 1u) {
            nodes[place] = pack_node(node);
        } else {
            nodes[place] = floatBitsToUint(node.depth);
            nodes[place + 1u] = floatBitsToUint(node.value);
        }
    }
    last_kept = node;
    ++kept;
}

#include "technique/deep_shadow_map/area.glsl"
#include "technique/deep_shadow_map/bound.glsl"

// False: a node is removed if the lines without it stay within the error. True: a node is removed if that changes the area under the curve
// by at most 4 times the squared error.
CONSTANT(bool, BY_AREA, false)

void curve_point(Node point, bool is_last) {
    if (BY_AREA) {
        window_point(point);
    } else {
        line_point(point, is_last);
    }
}

// Number of depth steps in the light's range: a step is the spacing of floats just below 1.
const float DEPTH_STEPS = 16777216.0;
// Bits of a texel's optical depth as an integer, out of 64: two are reserved for rounding.
const int SUM_BITS = 62;

uint depth_steps(float depth) { return uint(clamp(depth, 0.0, 1.0) * DEPTH_STEPS); }

float power_of_two(int exponent) { return uintBitsToFloat(uint(127 + exponent) << 23); }

// Sweeps along a curve with a total optical depth of `total`. Long rises get intermediate points, up to the optical depth `dark`.
// curve_point has only one call site: it is large, and drivers inline it into every call.
void sweep(uint index, float total, float dark) {
    // Bits of the integer part of the total optical depth, at least as many as for 1.
    int whole_bits = int(floatBitsToUint(max(total, 1.0)) >> 23) - 127 + 2;
    float scale = power_of_two(SUM_BITS - whole_bits), unit = power_of_two(whole_bits - SUM_BITS);
    uvec2 value = uvec2(0u), rate = uvec2(0u);
    uint at = depth_steps(events[index].entry);
    // Each round emits points `from` to `last`. Point 0 is at `depth` and point `last` at `end`; the remaining points lie between these
    // two. The first round emits the curve's first point.
    float depth = float(at) / DEPTH_STEPS, end = depth, before = 0.0, after = 0.0, along = 0.0, rise = 0.0;
    uint from = 0u, last = 0u;
    bool is_over = false, is_last = false;
    for (;;) {
        for (uint i = from; i <= last; ++i) {
            bool is_end = i == last && last > 0u;
            curve_point(Node(is_end ? end : depth + float(i) * along, is_end ? after : before + float(i) * rise), is_last);
        }
        if (is_last) {
            break;
        }
        from = 1u;
        last = 0u;
        if (is_over || index == NO_SEGMENT) {
            from = 0u;
            depth = float(at) / DEPTH_STEPS;
            before = wide_float(value) * unit;
            is_last = true;
            continue;
        }
        Segment event = events[index];
        uint here = depth_steps(event.entry);
        if (here > at) {
            depth = float(at) / DEPTH_STEPS;
            end = float(here) / DEPTH_STEPS;
            before = wide_float(value) * unit;
            from = before != after ? 0u : 1u;
            is_over = before >= DARK;
            if (is_over) {
                continue;
            }
            value = wide_plus(value, wide_times(rate, here - at));
            after = wide_float(value) * unit;
            float top = max(min(after, dark), before);
            float pieces = max(ceil((top - before) / RISE), 1.0);
            along = (end - depth) * ((top - before) / max(after - before, 1e-30)) / pieces;
            rise = (top - before) / pieces;
            last = uint(after > dark && top > before ? pieces : pieces - 1.0) + 1u;
            at = here;
        }
        index = event.next;
        uint other = depth_steps(event.exit);
        float takes = event.optical_depth * scale;
        if (other > here) {
            rate = wide_plus(rate, wide_of(takes / float(other - here)));
        } else if (other < here) {
            // Where a segment ends, removes the rounding error that its rate has accumulated.
            uint extent = here - other;
            uvec2 its = wide_of(takes / float(extent));
            rate = wide_minus(rate, its);
            value = wide_plus(value, wide_minus(wide_of(takes), wide_times(its, extent)));
        } else if (event.exit >= event.entry) {
            value = wide_plus(value, wide_of(takes));
        }
    }
}

// Number of the tile's texels that have nodes.
shared uint covered;
shared uint prefix[64];

void main() {
    uvec2 size = map_size(), texel = gl_GlobalInvocationID.xy;
    uint t = gl_LocalInvocationIndex, tile = group_tile(), place = tile * 64u + t;
    uint index = NO_SEGMENT;
    if (all(lessThan(texel, size))) {
        // The maps of the group are stacked vertically.
        index = imageLoad(heads, ivec2(texel + uvec2(0u, gl_WorkGroupID.z * size.y))).r;
    }
    float error = node_error > 0.0 ? node_error : state.error;
    kept = 0u;
    last_kept = Node(-1.0, 0.0);
    if (t == 0u) {
        covered = 0u;
    }
    first = is_written > 0u ? tile_starts[tile] + starts[place] : 0u;
    barrier();
    if (index != NO_SEGMENT) {
        // Summed in the order of depth, so that the sum depends on the casters alone. Each segment is counted where it begins.
        float total = 0.0;
        for (uint i = index; i != NO_SEGMENT; i = events[i].next) {
            total += events[i].exit >= events[i].entry ? events[i].optical_depth : 0.0;
        }
        if (BY_AREA) {
            window_begin(4.0 * error * error);
            sweep(index, total, 0.0);
            window_finish();
        } else {
            line_begin(error, total);
            sweep(index, total, dark_from(error));
            line_finish();
        }
    }
    uint count = kept;
    if (rounds_ran_out(count)) {
        counters[CUT_SHORT] = 1u;
    }
    if (count > 0u) {
        atomicAdd(covered, 1u);
    }
    prefix[t] = count;
    barrier();
    if (is_written > 0u) {
        starts[place] = min(first, node_room);
        uvec2 tiles = map_tiles();
        if (t == 63u && tile + 1u == (first_map + map_count) * tiles.x * tiles.y) {
            starts[place + 1u] = min(first + count, node_room);
        }
        if (t == 0u && covered > 0u) {
            atomicAdd(state.covered, covered);
        }
        return;
    }
    for (uint by = 1u; by < 64u; by *= 2u) {
        uint more = t >= by ? prefix[t - by] : 0u;
        barrier();
        prefix[t] += more;
        barrier();
    }
    starts[place] = prefix[t] - count;
    if (t == 63u) {
        tile_starts[tile] = prefix[t];
    }
}
