// A transmittance curve being built: streaming insertion of segments into WORK nodes, and reduction to NODES.
// Source: Salvi et al. 2010, Fife and Strugar 2013, Compression stage; nudging and the free first node are ours.
// Twin: reference::twin::avsm::curve.
// Invariants: depths never fall; transmittance never rises with depth; in front of the first node the light is whole,
// behind the last it is the product of all segments, whatever was removed.
//
// The arrays are meant for registers: loops are unrolled, every index is a constant, and a node that is picked at run
// time is picked by comparison.
#ifndef AVSM_CURVE_GLSL
#define AVSM_CURVE_GLSL
#extension GL_EXT_control_flow_attributes : require
#include "avsm/node.glsl"

// Nodes while segments are inserted, >= NODES. More cost time and lose less.
CONSTANT(int, WORK, 8)
// True: a removal moves its neighbours so that the area under the transmittance is kept, and the first node may go too,
// which leaves a step there. False: the survivors stay as they are, the first and last are exempt (Salvi et al. 2010).
CONSTANT(bool, NUDGE, true)

int node_count;
// Unused nodes have depth EMPTY.
float node_depths[WORK + 2];
float node_values[WORK + 2];
// Transmittance of each node, kept beside its value since every removal needs it.
float node_transmittance[WORK + 2];

void curve_clear() {
    node_count = 0;
    [[unroll]] for (int i = 0; i < WORK + 2; ++i) {
        node_depths[i] = EMPTY;
        node_values[i] = curve_unshadowed();
        node_transmittance[i] = 1.0;
    }
}

// Appends a stored node; insertion finds its transmittance.
void curve_load(int i, Node node) {
    node_depths[i] = node.depth;
    node_values[i] = node.value;
    node_count += int(node.depth < EMPTY);
}

// The value just behind `depth`, if there is a step.
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
    // Behind the last node `high` is EMPTY, whose share is 0.
    return high > low ? mix(value_low, value_high, min((depth - low) / (high - low), 1.0)) : value_low;
}

// Mean transmittance between two nodes of optical depth: (T0 − T1) / rise, by a series where that would cancel.
float span_mean(float through_0, float through_1, float rise) {
    float square = rise * rise;
    return rise < 0.25 ? 0.5 * (through_0 + through_1) * (1.0 - square * (1.0 / 12.0 - square / 120.0))
                       : (through_0 - through_1) / rise;
}

float span_area(int i, int k) {
    return (node_depths[k] - node_depths[i]) *
           span_mean(node_transmittance[i], node_transmittance[k], node_values[k] - node_values[i]);
}

// Change of a span's mean when the optical depth of its start, of its end grows.
float span_by_start(float through_0, float mean, float rise) {
    return rise < 0.05 ? -through_0 * (0.5 - rise / 6.0) : (mean - through_0) / rise;
}

float span_by_end(float through_0, float through_1, float mean, float rise) {
    return rise < 0.05 ? -through_0 * (0.5 - rise / 3.0) : (through_1 - mean) / rise;
}

float area_between(vec3 a, vec3 b) {
    return (b.x - a.x) * span_mean(a.z, b.z, b.y - a.y);
}

// A node and its neighbours, each (depth, value, transmittance): p, a before it, c, q behind it.
struct Neighbours {
    vec3 p, a, gone, c, q;
};

vec3 node_at(int i) {
    return vec3(node_depths[i], node_values[i], node_transmittance[i]);
}

// After the first node went: where its successor's step must move, towards the light, for the area to be what it was.
float nudged_depth(Neighbours n) {
    float mean = span_mean(n.c.z, n.q.z, n.q.y - n.c.y);
    float area = area_between(n.gone, n.c) + (n.q.x - n.c.x) * mean;
    return mean < 0.999 ? clamp((area + n.gone.x - n.q.x * mean) / (1.0 - mean), n.gone.x, n.c.x) : n.c.x;
}

// After the node between a and c went: by how much the optical depths of both, save the first and the last node, must
// change alike for the area from p to q to be what it was (one Newton step).
float nudged_shift(Neighbours n, bool move_a, bool move_c) {
    float rise = n.c.y - n.a.y, extent = n.c.x - n.a.x;
    float mean = span_mean(n.a.z, n.c.z, rise);
    float excess = extent * mean - area_between(n.a, n.gone) - area_between(n.gone, n.c);
    float rise_p = n.a.y - n.p.y, rise_q = n.q.y - n.c.y;
    float mean_p = span_mean(n.p.z, n.a.z, rise_p), mean_q = span_mean(n.c.z, n.q.z, rise_q);
    float slope_a = extent * span_by_start(n.a.z, mean, rise) +
                    (n.a.x - n.p.x) * span_by_end(n.p.z, n.a.z, mean_p, rise_p);
    float slope_c = extent * span_by_end(n.a.z, n.c.z, mean, rise) +
                    (n.q.x - n.c.x) * span_by_start(n.c.z, mean_q, rise_q);
    float slope = (move_a ? slope_a : 0.0) + (move_c ? slope_c : 0.0);
    float low = max(move_a ? -rise_p : -1e30, move_a || !move_c ? -1e30 : -rise);
    float high = min(move_c ? rise_q : 1e30, move_c || !move_a ? 1e30 : rise);
    // Nothing to move, or dark: no change.
    return slope > -1e-12 ? 0.0 : clamp(-excess / slope, low, high);
}

// Removes the node whose going changes the area under the transmittance least.
void remove_cheapest() {
    bool nudged = EXPONENTIAL && NUDGE;
    int cheapest = nudged ? 0 : 1;
    float least = 1e30;
    float last_area = 0.0;
    Neighbours n;
    n.p = n.a = n.gone = n.c = n.q = vec3(0.0);
    [[unroll]] for (int i = 0; i < WORK + 1; ++i) {
        float cost = 1e30;
        if (EXPONENTIAL) {
            float area = span_area(i, i + 1);
            if (i > 0) {
                cost = abs(last_area + area - span_area(max(i - 1, 0), i + 1));
            } else if (nudged) {
                cost = node_depths[1] - node_depths[0] - area;
            }
            last_area = area;
        } else if (i > 0) {
            float d0 = node_depths[max(i - 1, 0)], v0 = node_values[max(i - 1, 0)];
            cost = 0.5 * abs((node_depths[i] - d0) * (node_values[i + 1] - v0) -
                             (node_depths[i + 1] - d0) * (node_values[i] - v0));
        }
        if (i < node_count - 1 && cost < least) {
            least = cost;
            cheapest = i;
            // Kept along the way: to look them up afterwards would put the arrays into memory.
            n.p = node_at(max(i - 2, 0));
            n.a = node_at(max(i - 1, 0));
            n.gone = node_at(i);
            n.c = node_at(i + 1);
            n.q = node_at(min(i + 2, WORK + 1));
        }
    }
    bool move_a = nudged && cheapest > 1, move_c = nudged && cheapest > 0 && cheapest + 2 < node_count;
    float shift = move_a || move_c ? nudged_shift(n, move_a, move_c) : 0.0;
    float moved_a = exp(-n.a.y - shift), moved_c = exp(-n.c.y - shift);
    if (nudged && cheapest == 0) {
        node_depths[1] = nudged_depth(n);
    }
    [[unroll]] for (int i = 0; i < WORK + 1; ++i) {
        bool behind = i >= cheapest, is_a = move_a && i + 1 == cheapest, is_c = move_c && i == cheapest;
        node_depths[i] = behind ? node_depths[i + 1] : node_depths[i];
        node_values[i] = (behind ? node_values[i + 1] : node_values[i]) + (is_a || is_c ? shift : 0.0);
        node_transmittance[i] = is_a   ? moved_a
                                : is_c ? moved_c
                                : behind ? node_transmittance[i + 1]
                                         : node_transmittance[i];
    }
    node_depths[WORK + 1] = EMPTY;
    node_count -= 1;
}

// Attenuates the curve by a segment from `entry` to `exit`, both in the light's range, entry <= exit.
void curve_insert(float entry, float exit, float optical_depth) {
    if (!(optical_depth > 0.0) || !(entry <= exit)) {
        return;  // nothing to lose, or not a number
    }
    float value_entry = curve_value(entry);
    float value_exit = curve_value(exit);
    value_exit = EXPONENTIAL ? value_exit + optical_depth : value_exit * exp(-optical_depth);

    // Both new nodes go behind nodes of equal depth: the curve has its step behind them.
    int at_entry = 0, at_exit = 1;
    float per_depth = 1.0 / (exit - entry);
    [[unroll]] for (int i = 0; i < WORK; ++i) {
        float depth = node_depths[i];
        // Compared first, so that a segment of no length is a step and not 0/0.
        float ramp = depth <= entry ? 0.0 : depth >= exit ? 1.0 : (depth - entry) * per_depth;
        // What the part of the segment in front of the node really takes away: the sample ramps the transmittance
        // linearly instead, which leaves nodes inside a segment off the curve and too bright.
        float taken = optical_depth * ramp;
        node_values[i] = EXPONENTIAL ? node_values[i] + taken : node_values[i] * exp(-taken);
        node_transmittance[i] = curve_transmittance(node_values[i]);
        at_entry += int(depth <= entry);
        at_exit += int(depth <= exit);
    }
    [[unroll]] for (int i = WORK + 1; i >= 0; --i) {
        if (i > at_exit) {
            node_depths[i] = node_depths[max(i - 2, 0)];
            node_values[i] = node_values[max(i - 2, 0)];
            node_transmittance[i] = node_transmittance[max(i - 2, 0)];
        } else if (i == at_exit) {
            node_depths[i] = exit;
            node_values[i] = value_exit;
            node_transmittance[i] = curve_transmittance(value_exit);
        } else if (i > at_entry) {
            node_depths[i] = node_depths[max(i - 1, 0)];
            node_values[i] = node_values[max(i - 1, 0)];
            node_transmittance[i] = node_transmittance[max(i - 1, 0)];
        } else if (i == at_entry) {
            node_depths[i] = entry;
            node_values[i] = value_entry;
            node_transmittance[i] = curve_transmittance(value_entry);
        }
    }
    node_count += 2;
    // A loop, since code for two removals is twice as long; one that goes round twice, since drivers count (maps/rounds.glsl).
    int removed = 0;
    [[dont_unroll]] do {
        if (node_count > WORK) {
            remove_cheapest();
        }
    } while (++removed < 2);
}

// Appends a node behind all others, of the optical depth up to there.
void curve_append(float depth, float optical_depth) {
    float value = EXPONENTIAL ? optical_depth : exp(-optical_depth);
    [[unroll]] for (int i = 0; i < WORK + 1; ++i) {
        if (i == node_count) {
            node_depths[i] = depth;
            node_values[i] = value;
            node_transmittance[i] = curve_transmittance(value);
        }
    }
    node_count += 1;
    if (node_count > WORK) {
        remove_cheapest();
    }
}

// Down to the nodes that are stored.
void curve_reduce() {
    [[dont_unroll]] for (int i = 0; i < WORK - NODES; ++i) {
        if (node_count > NODES) {
            remove_cheapest();
        }
    }
}

// Node i < NODES as it is stored; unused ones carry the last value on.
Node curve_node(int i) {
    float tail = curve_unshadowed();
    [[unroll]] for (int k = 0; k < NODES; ++k) {
        tail = k + 1 == node_count ? node_values[k] : tail;
    }
    return i < node_count ? Node(node_depths[i], node_values[i]) : Node(EMPTY, tail);
}
#endif
