// A transmittance curve being built: streaming insertion of segments into WORK nodes, and reduction to NODES.
// Source: seed 000 (compression stage), Salvi et al. 2010; nudging and the free first node are ours.
// Twin: reference::avsm::Curve.
// Invariants: depths never fall; transmittance never rises with depth; in front of the first node the light is whole,
// behind the last it is the product of all segments, whatever was removed.
#ifndef AVSM_CURVE_GLSL
#define AVSM_CURVE_GLSL
#include "avsm/node.glsl"

// Nodes while segments are inserted, >= NODES. More cost time and lose less.
layout(constant_id = 2) const int WORK = 8;
// 1: a removal moves its neighbours so that the area under the transmittance is kept, and the first node may go too,
// which leaves a step there. 0: the survivors stay as they are, the first and last are exempt (the seed).
layout(constant_id = 3) const uint NUDGE = 1u;

int node_count;
float node_depths[WORK + 2];
float node_values[WORK + 2];

void curve_clear() {
    node_count = 0;
}

// The value just behind `depth`, if there is a step.
float curve_value(float depth) {
    float value = curve_unshadowed();
    for (int i = 0; i < WORK; ++i) {
        if (i < node_count && node_depths[i] <= depth) {
            bool last = i + 1 == node_count;
            float length = last ? 1.0 : node_depths[i + 1] - node_depths[i];
            float along = last || length <= 0.0 ? 0.0 : min((depth - node_depths[i]) / length, 1.0);
            value = last ? node_values[i] : mix(node_values[i], node_values[i + 1], along);
        }
    }
    return value;
}

// A piece of an exponential curve.
struct Span {
    float extent;
    float start;  // transmittance
    float end;
    float rise;   // of the optical depth
    float mean;   // transmittance
};

Span span_of(float depth_0, float value_0, float depth_1, float value_1) {
    Span span;
    span.extent = depth_1 - depth_0;
    span.start = exp(-value_0);
    span.end = exp(-value_1);
    span.rise = value_1 - value_0;
    float square = span.rise * span.rise;
    // A series where the quotient would cancel.
    span.mean = span.rise < 0.25 ? 0.5 * (span.start + span.end) * (1.0 - square * (1.0 / 12.0 - square / 120.0))
                                 : (span.start - span.end) / span.rise;
    return span;
}

float span_area(Span span) { return span.extent * span.mean; }

// Change of the area when the optical depth of the start, of the end grows.
float span_by_start(Span span) {
    float slope = span.rise < 0.05 ? -span.start * (0.5 - span.rise / 6.0) : (span.mean - span.start) / span.rise;
    return span.extent * slope;
}

float span_by_end(Span span) {
    float slope = span.rise < 0.05 ? -span.start * (0.5 - span.rise / 3.0) : (span.end - span.mean) / span.rise;
    return span.extent * slope;
}

// How much the area under the transmittance changes if node `i` goes.
float removal_cost(int i) {
    float d1 = node_depths[i], v1 = node_values[i];
    float d2 = node_depths[i + 1], v2 = node_values[i + 1];
    if (i == 0) {
        return d2 - d1 - span_area(span_of(d1, v1, d2, v2));
    }
    float d0 = node_depths[i - 1], v0 = node_values[i - 1];
    if (EXPONENTIAL == 1u) {
        return abs(span_area(span_of(d0, v0, d1, v1)) + span_area(span_of(d1, v1, d2, v2)) -
                   span_area(span_of(d0, v0, d2, v2)));
    }
    return 0.5 * abs((d1 - d0) * (v2 - v0) - (d2 - d0) * (v1 - v0));
}

// After the first node went: the step moves towards the light until the area is what it was.
void nudge_first(float gone_depth, float gone_value) {
    float d1 = node_depths[0], v1 = node_values[0], d2 = node_depths[1], v2 = node_values[1];
    Span next = span_of(d1, v1, d2, v2);
    float area = span_area(span_of(gone_depth, gone_value, d1, v1)) + span_area(next);
    if (next.mean < 0.999) {
        node_depths[0] = clamp((area + gone_depth - d2 * next.mean) / (1.0 - next.mean), gone_depth, d1);
    }
}

// After the node between a = `before` and c = before + 1 went: both, save the first and the last node, change their
// optical depth alike until the area from the node before a to the node behind c is what it was (one Newton step).
void nudge(int before, float gone_depth, float gone_value) {
    float da = 0.0, va = 0.0, dc = 0.0, vc = 0.0, dp = 0.0, vp = 0.0, dq = 0.0, vq = 0.0;
    for (int i = 0; i < WORK + 2; ++i) {
        if (i == before - 1) { dp = node_depths[i]; vp = node_values[i]; }
        if (i == before) { da = node_depths[i]; va = node_values[i]; }
        if (i == before + 1) { dc = node_depths[i]; vc = node_values[i]; }
        if (i == before + 2) { dq = node_depths[i]; vq = node_values[i]; }
    }
    bool move_a = before > 0, move_c = before + 2 < node_count;
    Span merged = span_of(da, va, dc, vc);
    float excess = span_area(merged) - span_area(span_of(da, va, gone_depth, gone_value)) -
                   span_area(span_of(gone_depth, gone_value, dc, vc));
    float slope = (move_a ? span_by_start(merged) + span_by_end(span_of(dp, vp, da, va)) : 0.0) +
                  (move_c ? span_by_end(merged) + span_by_start(span_of(dc, vc, dq, vq)) : 0.0);
    if (slope > -1e-12) {
        return;  // nothing to move, or dark
    }
    float low = max(move_a ? vp - va : -1e30, move_a || !move_c ? -1e30 : va - vc);
    float high = min(move_c ? vq - vc : 1e30, move_c || !move_a ? 1e30 : vc - va);
    float shift = clamp(-excess / slope, low, high);
    for (int i = 0; i < WORK + 2; ++i) {
        if ((i == before && move_a) || (i == before + 1 && move_c)) {
            node_values[i] += shift;
        }
    }
}

// Removes the node that changes the area least.
void remove_cheapest() {
    bool nudged = EXPONENTIAL == 1u && NUDGE == 1u;
    int cheapest = nudged ? 0 : 1;
    float least = removal_cost(cheapest);
    for (int i = 1; i < WORK + 1; ++i) {
        if (i < node_count - 1) {
            float cost = removal_cost(i);
            if (cost < least) {
                least = cost;
                cheapest = i;
            }
        }
    }
    float gone_depth = 0.0, gone_value = 0.0;
    for (int i = 0; i < WORK + 1; ++i) {
        if (i == cheapest) {
            gone_depth = node_depths[i];
            gone_value = node_values[i];
        }
        if (i >= cheapest) {
            node_depths[i] = node_depths[i + 1];
            node_values[i] = node_values[i + 1];
        }
    }
    node_count -= 1;
    if (nudged && cheapest == 0) {
        nudge_first(gone_depth, gone_value);
    } else if (nudged) {
        nudge(cheapest - 1, gone_depth, gone_value);
    }
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
    for (int i = 0; i < WORK; ++i) {
        float depth = node_depths[i];
        // Compared first, so that a segment of no length is a step and not 0/0.
        float ramp = depth <= entry ? 0.0 : depth >= exit ? 1.0 : (depth - entry) / (exit - entry);
        // What the part of the segment in front of the node really takes away: the seed ramps the transmittance
        // linearly instead, which leaves nodes inside a segment off the curve and too bright.
        node_values[i] = EXPONENTIAL == 1u ? node_values[i] + optical_depth * ramp
                                           : node_values[i] * exp(-optical_depth * ramp);
        at_entry += int(i < node_count && depth <= entry);
        at_exit += int(i < node_count && depth <= exit);
    }
    for (int i = WORK + 1; i >= 0; --i) {
        if (i > at_exit) {
            node_depths[i] = node_depths[max(i - 2, 0)];
            node_values[i] = node_values[max(i - 2, 0)];
        } else if (i == at_exit) {
            node_depths[i] = exit;
            node_values[i] = value_exit;
        } else if (i > at_entry) {
            node_depths[i] = node_depths[max(i - 1, 0)];
            node_values[i] = node_values[max(i - 1, 0)];
        } else if (i == at_entry) {
            node_depths[i] = entry;
            node_values[i] = value_entry;
        }
    }
    node_count += 2;
    for (int i = 0; i < 2; ++i) {
        if (node_count > WORK) {
            remove_cheapest();
        }
    }
}

// Down to the nodes that are stored.
void curve_reduce() {
    for (int i = 0; i < WORK - NODES; ++i) {
        if (node_count > NODES) {
            remove_cheapest();
        }
    }
}

// Node i < NODES as it is stored; unused ones carry the last value on.
Node curve_node(int i) {
    float tail = curve_unshadowed();
    for (int k = 0; k < NODES; ++k) {
        tail = k + 1 == node_count ? node_values[k] : tail;
    }
    return i < node_count ? Node(node_depths[i], node_values[i]) : Node(EMPTY, tail);
}
#endif
