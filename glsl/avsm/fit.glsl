// Moves the nodes of a compressed curve off the true curve, to where the sums in cells want them: a node's two lines, to the
// node before and to the node behind, are each turned about their other ends into the best fit of the cells' ends that they
// pass, and the node goes to where the two meet. Squares of transmittance are made least, with a step of Gauss and Newton.
// Needs, declared before: CELLS and TEXELS, and cells[], each the bits of the optical depth up to a cell's end. All threads of a
// workgroup take part: nodes of odd and of even number take turns, since a node asks for its neighbours alone.
// Invariants: depths never fall; nor do optical depths; the last node's stays; nodes from `dark_from` on stay where they are.
// Source: ours. Twin: reference::twin::avsm::fit.
#ifndef AVSM_FIT_GLSL
#define AVSM_FIT_GLSL
#include "avsm/curve.glsl"

// Rounds over all nodes; 0: they stay on the curve.
CONSTANT(int, ROUNDS, 0)

// Of the way to its neighbours, how far a node moves at a time. Half: it meets none that moves too.
const float REACH = 0.5;
// Weights, squares of transmittance, that count for nothing.
const float DIM = 1e-7;
// The square of a bend, in optical depth a cell, that says nothing about where it is.
const float STRAIGHT = 1e-10;

// (depth, value) of node i of texel t at i · TEXELS + t.
shared vec2 fitted[(ROUNDS > 0 ? NODES : 1) * TEXELS];

// What node i is moved to. Places are in cells behind `low`.
vec2 fitted_node(uint t, uint i, float low, float per_cell, float dark_from) {
    vec2 node = fitted[i * TEXELS + t];
    bool is_first = i == 0u;
    bool is_last = i + 1u == NODES || fitted[(i + 1u) * TEXELS + t].x == EMPTY;
    if ((is_first && is_last) || node.x >= dark_from) {
        return node;
    }
    vec2 p = is_first ? node : fitted[(i - 1u) * TEXELS + t];
    vec2 q = is_last ? node : fitted[(i + 1u) * TEXELS + t];
    float at_p = (p.x - low) * per_cell, at = (node.x - low) * per_cell, at_q = (q.x - low) * per_cell;
    float per_p = 1.0 / max(at - at_p, 1e-6), per_q = 1.0 / max(at_q - at, 1e-6);
    float rise_p = node.y - p.y, rise_q = q.y - node.y;
    float slope_p = rise_p * per_p, slope_q = rise_q * per_q;
    float until = min(at_q, (dark_from - low) * per_cell);
    // Weights, and weighted distances from the line to the curve.
    vec2 sums_p = vec2(0.0), sums_q = vec2(0.0);
    for (uint cell = uint(at_p); cell < uint(CELLS); ++cell) {
        float end = float(cell + 1u);
        if (end > until) {
            break;
        }
        bool before = end <= at;
        float share = before ? (end - at_p) * per_p : (at_q - end) * per_q;
        float line = before ? p.y + rise_p * share : q.y - rise_q * share;
        float optical_depth = uintBitsToFloat(cells[cell * TEXELS + t]);
        float weight = exp(-2.0 * optical_depth) * share;
        vec2 sums = weight * vec2(share, optical_depth - line);
        sums_p += before ? sums : vec2(0.0);
        sums_q += before ? vec2(0.0) : sums;
    }
    // By how much each line alone should rise at the node.
    float wish_p = sums_p.y / (sums_p.x + DIM), wish_q = sums_q.y / (sums_q.x + DIM);
    float nearest = at - REACH * (at - at_p);
    float farthest = at + REACH * ((is_last ? float(CELLS) : at_q) - at);
    float moved, value;
    if (is_first) {
        // In front of it the light is whole: its line ends in a step, or where it comes to nothing.
        float wanted = node.y + wish_q;
        float slope = (q.y - wanted) * per_q;
        moved = wanted < 0.0 ? min(at - wanted / slope, farthest) : at;
        value = min(max(wanted, 0.0), q.y);
    } else if (is_last) {
        moved = min(max(at - wish_p * slope_p / (slope_p * slope_p + STRAIGHT), nearest), farthest);
        value = node.y;
    } else {
        float bend = slope_p - slope_q;
        moved = min(max(at + (wish_q - wish_p) * bend / (bend * bend + STRAIGHT), nearest), farthest);
        float by = moved - at;
        float both = sums_p.x * (wish_p + slope_p * by) + sums_q.x * (wish_q + slope_q * by);
        value = min(max(node.y + both / (sums_p.x + sums_q.x + DIM), p.y), q.y);
    }
    float end = is_last ? max(node.x, low + float(CELLS) / per_cell) : q.x;
    return vec2(min(max(low + moved / per_cell, p.x), end), value);
}

// The curve in avsm/curve.glsl, which thread `group` 0 of the texel has and keeps, by all its `groups` threads.
void curve_fit(uint t, uint group, uint groups, float low, float per_cell, float dark_from) {
    if (group == 0u) {
        [[unroll]] for (int i = 0; i < NODES; ++i) {
            fitted[uint(i) * TEXELS + t] = vec2(node_depths[i], node_values[i]);
        }
    }
    barrier();
    [[dont_unroll]] for (int turn = 0; turn < 2 * ROUNDS; ++turn) {
        // Odd ones first.
        uint parity = uint(turn + 1) % 2u;
        [[dont_unroll]] for (uint i = parity + 2u * group; i < NODES; i += 2u * groups) {
            if (fitted[i * TEXELS + t].x < EMPTY) {
                fitted[i * TEXELS + t] = fitted_node(t, i, low, per_cell, dark_from);
            }
        }
        barrier();
    }
    if (group == 0u) {
        [[unroll]] for (int i = 0; i < NODES; ++i) {
            node_depths[i] = fitted[uint(i) * TEXELS + t].x;
            node_values[i] = fitted[uint(i) * TEXELS + t].y;
        }
    }
}
#endif
