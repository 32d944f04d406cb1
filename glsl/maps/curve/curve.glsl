// A transmittance curve under construction: streaming insertion of segments into WORK nodes, and reduction to NODES.
// Source: Salvi et al. 2010, Fife and Strugar 2013, Compression stage; nudging and the free first node are ours.
// Twin: reference::twin::avsm::curve.
// Invariants: depths never decrease; transmittance never increases with depth; in front of the first node all light is left; behind
// the last node it is the product of all segments, whatever was removed. Segments that begin behind an optical depth of DARK are
// skipped.
//
// The arrays are meant for registers: loops are unrolled, every index is a constant, and a node chosen at run time is selected
// by comparison.
#ifndef MAPS_CURVE_CURVE_GLSL
#define MAPS_CURVE_CURVE_GLSL
#extension GL_EXT_control_flow_attributes : require
#include "maps/curve/node.glsl"
#include "world/caster.glsl"

// Number of nodes while segments are inserted, >= NODES. More nodes cost more time and give a smaller error.
CONSTANT(int, WORK, 8)
// True: when a node is removed, its neighbours move so that the area under the transmittance stays the same. The first node may be removed
// too, which leaves a step there. False: the other nodes stay as they are, and the first and the last node are never removed (Salvi et al.
// 2010).
CONSTANT(bool, NUDGE, true)

int node_count;
// Unused nodes have depth EMPTY and the value of the last used node.
float node_depths[WORK + 2];
float node_values[WORK + 2];

void curve_clear() {
    node_count = 0;
    [[unroll]] for (int i = 0; i < WORK + 2; ++i) {
        node_depths[i] = EMPTY;
        node_values[i] = curve_unshadowed();
    }
}

// Loads stored node i; nodes must be loaded in order.
void curve_load(int i, Node node) {
    node_depths[i] = node.depth;
    node_values[i] = node.value;
    node_count += int(node.depth < EMPTY);
}

// The curve's value at `depth`; at a step, the value just behind the step.
float curve_value(float depth) {
    float low = depth, high = EMPTY, value_low = curve_unshadowed(), value_high = value_low;
    [[unroll]] for (int i = 0; i < WORK; ++i) {
        if (node_depths[i] <= depth) {
            low = node_depths[i];
            high = node_depths[i + 1];
            value_low = node_values[i];
            value_high = node_values[i + 1];
        }
    }
    // Behind the last node `high` is EMPTY, which makes the interpolation weight 0.
    return high > low ? mix(value_low, value_high, min((depth - low) / (high - low), 1.0)) : value_low;
}

// Mean transmittance between two nodes of optical depth: (T0 − T1) / rise, or a series where that would cancel.
float span_mean(float through_0, float through_1, float rise) {
    float square = rise * rise;
    return rise < 0.25 ? 0.5 * (through_0 + through_1) * (1.0 - square * (1.0 / 12.0 - square / 120.0))
                       : (through_0 - through_1) / rise;
}

// If each insertion removes as many nodes as it adds, areas are approximated by trapezoids. Removing a node then changes the area by the
// area of the triangle between the node and its two neighbours, in depth and optical depth, times the transmittance around them. This saves
// a division per span, takes 0.6 times as many instructions and has about the same error. If WORK is more than NODES, exact areas have up
// to 7 % less error.
bool by_triangles() { return EXPONENTIAL && NUDGE && WORK == NODES; }

// Removes the one of `count` nodes whose removal changes the area under the transmittance least.
void remove_cheapest(int count) {
    bool nudged = EXPONENTIAL && NUDGE;
    // `through`: each node's transmittance. The other arrays describe the span from each node to the next: its extent in depth, the rise of
    // its value, its mean transmittance, and the area under its transmittance.
    float through[WORK + 2], extent[WORK + 1], rise[WORK + 1], mean[WORK + 1], area[WORK + 2];
    through[0] = EXPONENTIAL ? exp(-node_values[0]) : 0.0;
    area[WORK + 1] = 0.0;
    [[unroll]] for (int i = 0; i < WORK + 1; ++i) {
        through[i + 1] = EXPONENTIAL ? exp(-node_values[i + 1]) : 0.0;
        extent[i] = node_depths[i + 1] - node_depths[i];
        rise[i] = node_values[i + 1] - node_values[i];
        mean[i] = by_triangles() ? 0.5 * (through[i] + through[i + 1])
                                 : span_mean(through[i], through[i + 1], rise[i]);
        area[i] = i + 1 < count ? extent[i] * mean[i] : 0.0;
    }
    int cheapest = nudged ? 0 : 1;
    float least = nudged ? extent[0] - area[0] : 1e30;
    // The cheapest node's numbers are kept during the loop: indexing the arrays afterwards would move them from registers to memory.
    float excess = 0.0, weight = 0.0, low = 0.0, high = 0.0;
    [[unroll]] for (int i = 1; i < WORK + 1; ++i) {
        float both = rise[i - 1] + rise[i];
        float triangle = 0.5 * (extent[i] * rise[i - 1] - extent[i - 1] * rise[i]);
        float merged = (extent[i - 1] + extent[i]) * span_mean(through[i - 1], through[i + 1], both);
        float change = by_triangles() ? 0.5 * (mean[i - 1] + mean[i]) * triangle
                       : EXPONENTIAL  ? merged - (area[i - 1] + area[i])
                                      : triangle;
        if (i + 1 < count && abs(change) < least) {
            least = abs(change);
            cheapest = i;
            excess = change;
            // Decrease of the area per unit of optical depth that is added to both neighbours of the removed node. If a neighbour is the
            // first or the last node, which stays, the area decreases less. So the other neighbour moves only about half as far as it
            // should; there, that works better than the full distance.
            weight = 0.5 * (i > 1 ? area[max(i - 2, 0)] : 0.0) + area[i - 1] + area[i] + 0.5 * area[i + 1];
            low = i > 1 ? -rise[max(i - 2, 0)] : -both;
            high = i + 2 < count ? rise[min(i + 1, WORK)] : both;
        }
    }
    // Where no light is left, nodes are not shifted.
    float shift = nudged && weight > 1e-12 ? clamp(excess / weight, low, high) : 0.0;
    if (nudged && cheapest == 0) {
        // The second node's step moves towards the light until the area is the same as before.
        float share = mean[1] < 0.999 ? clamp((mean[0] - mean[1]) / (1.0 - mean[1]), 0.0, 1.0) : 1.0;
        node_depths[1] = node_depths[0] + extent[0] * share;
    }
    [[unroll]] for (int i = 0; i < WORK + 1; ++i) {
        bool behind = i >= cheapest;
        // All nodes but the first and the last.
        bool moves = i > 0 && i + 2 < count && (i + 1 == cheapest || i == cheapest);
        node_depths[i] = behind ? node_depths[i + 1] : node_depths[i];
        node_values[i] = (behind ? node_values[i + 1] : node_values[i]) + (moves ? shift : 0.0);
    }
    node_depths[WORK + 1] = EMPTY;
}

// Inserts a node behind all nodes of no greater depth. The last, unused element of the array drops out.
void place_node(float depth, float value) {
    bool ahead = true;
    [[unroll]] for (int i = WORK + 1; i >= 0; --i) {
        bool moves = i > 0 && node_depths[max(i - 1, 0)] > depth;
        if (moves) {
            node_depths[i] = node_depths[max(i - 1, 0)];
            node_values[i] = node_values[max(i - 1, 0)];
        } else if (ahead) {
            node_depths[i] = depth;
            node_values[i] = value;
        }
        ahead = moves;
    }
}

bool is_dark(float value) { return EXPONENTIAL ? value >= DARK : value <= exp(-DARK); }

// Whether no light reaches `depth`. The last node is tested first: most curves are dark nowhere.
bool curve_dark(float depth) { return is_dark(node_values[WORK - 1]) && is_dark(curve_value(depth)); }

// Attenuates the curve by a segment from `entry` to `exit`, both in the light's range, entry <= exit. Returns false if that changes
// nothing.
bool curve_insert(float entry, float exit, float optical_depth) {
    if (!(optical_depth > 0.0) || !(entry <= exit) || curve_dark(entry)) {
        return false;  // no optical depth, NaN, or no light left
    }
    float value_entry = curve_value(entry);
    float value_exit = curve_value(exit);
    value_exit = EXPONENTIAL ? value_exit + optical_depth : value_exit * exp(-optical_depth);
    float per_depth = 1.0 / (exit - entry);
    [[unroll]] for (int i = 0; i < WORK; ++i) {
        float depth = node_depths[i];
        // Compared first, so that a segment of zero length is a step and not 0/0.
        float ramp = depth <= entry ? 0.0 : depth >= exit ? 1.0 : (depth - entry) * per_depth;
        // Optical depth of the segment's part in front of the node. Fife and Strugar's sample ramps the transmittance linearly instead,
        // which leaves nodes inside a segment off the curve and too bright.
        float taken = optical_depth * ramp;
        node_values[i] = EXPONENTIAL ? node_values[i] + taken : node_values[i] * exp(-taken);
    }
    // Both nodes go behind existing nodes of equal depth, so that the curve steps there.
    place_node(entry, value_entry);
    place_node(exit, value_exit);
    node_count = min(node_count + 2, WORK);
    // Two tests instead of a counted loop, so that remove_cheapest gets constants.
    if (node_depths[WORK + 1] < EMPTY) {
        remove_cheapest(WORK + 2);
    }
    if (node_depths[WORK] < EMPTY) {
        remove_cheapest(WORK + 1);
    }
    return true;
}

// Appends a node behind all existing ones; `optical_depth`: the curve's total up to there.
void curve_append(float depth, float optical_depth) {
    float value = EXPONENTIAL ? optical_depth : exp(-optical_depth);
    [[unroll]] for (int i = 0; i < WORK + 1; ++i) {
        node_depths[i] = i == node_count ? depth : node_depths[i];
        node_values[i] = i >= node_count ? value : node_values[i];
    }
    node_count = min(node_count + 1, WORK);
    if (node_depths[WORK] < EMPTY) {
        remove_cheapest(WORK + 1);
    }
}

// Removes nodes until no more are left than can be stored.
void curve_reduce() {
    [[dont_unroll]] for (int i = 0; i < WORK - NODES; ++i) {
        if (node_count > NODES) {
            remove_cheapest(node_count);
            node_count -= 1;
        }
    }
}

// Node i < NODES, as stored.
Node curve_node(int i) {
    return Node(node_depths[i], node_values[i]);
}
#endif
