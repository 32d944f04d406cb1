// A transmittance curve of NODES nodes and the streaming insertion of a segment into it.
// Source: seed 000 (compression stage), Salvi et al. 2010. Twin: reference::avsm::Curve.
// Invariants: depths never fall; transmittance never rises with depth; unused nodes have depth EMPTY and the value of
// the last used one, so that attenuating them too keeps the tail equal to the product of all segments.
#ifndef AVSM_CURVE_GLSL
#define AVSM_CURVE_GLSL

layout(constant_id = 0) const int NODES = 8;
// 0: values are transmittances, interpolated linearly (the seed). 1: values are optical depths, interpolated linearly,
// which is exact within a sphere of constant extinction.
layout(constant_id = 1) const uint EXPONENTIAL = 1u;

const float EMPTY = 3e38;

struct Node {
    float depth;  // in the light's range, 0 to 1
    float value;
};

float node_depths[NODES + 2];
float node_values[NODES + 2];

float curve_unshadowed() { return EXPONENTIAL == 1u ? 0.0 : 1.0; }

float curve_transmittance(float value) { return EXPONENTIAL == 1u ? exp(-value) : value; }

void curve_clear() {
    for (int i = 0; i < NODES + 2; ++i) {
        node_depths[i] = EMPTY;
        node_values[i] = curve_unshadowed();
    }
}

// The value just behind `depth`, if there is a step.
float curve_value(float depth) {
    float value = curve_unshadowed();
    for (int i = 0; i < NODES; ++i) {
        float low = node_depths[i], high = node_depths[i + 1];
        if (low <= depth && depth < high) {
            value = mix(node_values[i], node_values[i + 1], (depth - low) / (high - low));
        }
    }
    return value;
}

// Mean of exp(-t) as t goes linearly from 0 to `rise`; a series where the quotient would cancel.
float mean_transmittance(float rise) {
    return rise < 0.02 ? 1.0 - rise * (0.5 - rise * (1.0 / 6.0 - rise / 24.0)) : (1.0 - exp(-rise)) / rise;
}

// Integral of the transmittance between two nodes of optical depth.
float span_integral(float depth_0, float value_0, float depth_1, float value_1) {
    return (depth_1 - depth_0) * exp(-value_0) * mean_transmittance(value_1 - value_0);
}

// How much the area under the transmittance changes if node `i` goes.
float removal_cost(int i) {
    float d0 = node_depths[i - 1], d1 = node_depths[i], d2 = node_depths[i + 1];
    float v0 = node_values[i - 1], v1 = node_values[i], v2 = node_values[i + 1];
    if (EXPONENTIAL == 1u) {
        return abs(span_integral(d0, v0, d1, v1) + span_integral(d1, v1, d2, v2) - span_integral(d0, v0, d2, v2));
    }
    return 0.5 * abs((d1 - d0) * (v2 - v0) - (d2 - d0) * (v1 - v0));
}

// Removes one node if all of 0..last are used; the first and the last are exempt.
void remove_cheapest(int last) {
    if (node_depths[last] >= EMPTY) {
        return;
    }
    int cheapest = 1;
    float least = removal_cost(1);
    for (int i = 2; i < last; ++i) {
        float cost = removal_cost(i);
        if (cost < least) {
            least = cost;
            cheapest = i;
        }
    }
    for (int i = 1; i < last; ++i) {
        if (i >= cheapest) {
            node_depths[i] = node_depths[i + 1];
            node_values[i] = node_values[i + 1];
        }
    }
    node_depths[last] = EMPTY;
}

// Attenuates the curve by a segment from `entry` to `exit`, both in the light's range, entry <= exit.
void curve_insert(float entry, float exit, float optical_depth) {
    if (!(optical_depth > 0.0) || !(entry <= exit)) {
        return;  // nothing to lose, or not a number
    }
    float value_entry = curve_value(entry);
    float value_exit = curve_value(exit);
    value_exit = EXPONENTIAL == 1u ? value_exit + optical_depth : value_exit * exp(-optical_depth);

    // Both new nodes go behind nodes of equal depth: the curve has its step behind them.
    int at_entry = 0, at_exit = 1;
    for (int i = 0; i < NODES; ++i) {
        float depth = node_depths[i];
        // Compared first, so that a segment of no length is a step and not 0/0.
        float ramp = depth <= entry ? 0.0 : depth >= exit ? 1.0 : (depth - entry) / (exit - entry);
        // What the part of the segment in front of the node really takes away: the seed ramps the transmittance
        // linearly instead, which leaves nodes inside a segment off the curve and too bright.
        node_values[i] = EXPONENTIAL == 1u ? node_values[i] + optical_depth * ramp
                                           : node_values[i] * exp(-optical_depth * ramp);
        at_entry += int(depth <= entry);
        at_exit += int(depth <= exit);
    }
    float tail = at_exit == 1 + NODES ? value_exit : node_values[NODES - 1];
    for (int i = NODES + 1; i >= 0; --i) {
        float depth = i < NODES ? node_depths[i] : EMPTY;
        float value = i < NODES ? node_values[i] : tail;
        if (i > at_exit) {
            depth = node_depths[max(i - 2, 0)];
            value = node_values[max(i - 2, 0)];
        } else if (i == at_exit) {
            depth = exit;
            value = value_exit;
        } else if (i > at_entry) {
            depth = node_depths[max(i - 1, 0)];
            value = node_values[max(i - 1, 0)];
        } else if (i == at_entry) {
            depth = entry;
            value = value_entry;
        }
        node_depths[i] = depth;
        node_values[i] = value;
    }
    remove_cheapest(NODES + 1);
    remove_cheapest(NODES);
    node_depths[NODES] = EMPTY;
    node_depths[NODES + 1] = EMPTY;
    node_values[NODES] = node_values[NODES - 1];
    node_values[NODES + 1] = node_values[NODES - 1];
}
#endif
