// Weights of the texels that a look-up averages, separable in x and y. Twin: reference::twin::filter.
//   bilinear: the four texels about the position;
//   box:      a square that extends FILTER_RADIUS texels from the position, each texel weighted by the fraction of it inside;
//   gaussian: the same texels, each times exp(-d²/(2 s²)), where d is its centre's distance and s = FILTER_RADIUS / 2.
// Invariants: weights are continuous in the position and sum to 1. The Gaussian is also multiplied by the box's weights, so that its
// outermost texels fade in and out; a hard cutoff would make its weights jump.
#ifndef MAPS_FILTER_GLSL
#define MAPS_FILTER_GLSL
#include "world/view.glsl"

CONSTANT(uint, FILTER, 0u)         // the filter: 0 bilinear, 1 box, 2 gaussian
CONSTANT(uint, FILTER_RADIUS, 2u)  // radius of the box and gaussian filters, in texels

const uint FILTER_BILINEAR = 0u;
const uint FILTER_BOX = 1u;

struct Filter {
    Footprint near;  // bilinear
    ivec2 corner;    // box, gaussian: the first texel,
    vec2 rest;       // and the fraction of the position within that texel, 0 to 1
    float total;     // sum of the weights before they are divided by it
};

// Number of texels per side.
int filter_side() { return FILTER == FILTER_BILINEAR ? 2 : 2 * int(FILTER_RADIUS) + 1; }

// Weights in x and in y of the texels `i` places after the first.
vec2 filter_axis(vec2 rest, int i) {
    float radius = float(FILTER_RADIUS);
    vec2 distance = abs(float(i) + 0.5 - radius - rest);
    vec2 share = clamp(radius + 0.5 - distance, 0.0, 1.0);
    return FILTER == FILTER_BOX ? share : share * exp(-2.0 * distance * distance / (radius * radius));
}

// The filter about a point given in texels.
Filter filter_at(View view, vec2 at) {
    Filter f;
    f.near = view_footprint(view, at);
    // Clamped so that the conversion to integers is defined: that far outside, all texels are outside anyway.
    float radius = float(FILTER_RADIUS);
    at = clamp(at, vec2(-radius - 2.0), vec2(view.width, view.height) + radius + 2.0) - radius;
    f.corner = ivec2(floor(at));
    f.rest = at - floor(at);
    vec2 total = vec2(0.0);
    for (int i = 0; i < filter_side(); ++i) {
        total += filter_axis(f.rest, i);
    }
    f.total = total.x * total.y;
    return f;
}

// Texels i < filter_side()², row by row, and their weights.
ivec2 filter_texel(Filter f, int i) {
    ivec2 corner = FILTER == FILTER_BILINEAR ? f.near.corner : f.corner;
    return corner + ivec2(i % filter_side(), i / filter_side());
}

float filter_weight(Filter f, int i) {
    if (FILTER == FILTER_BILINEAR) {
        return f.near.weights[i];
    }
    return filter_axis(f.rest, i % filter_side()).x * filter_axis(f.rest, i / filter_side()).y / f.total;
}
#endif
