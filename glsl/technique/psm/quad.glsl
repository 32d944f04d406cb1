// The quads that draw a caster. One quad is in the layer of the caster's slice. With SPLIT, a second quad is in the layer of the next
// slice, if that is a different layer. With COVERAGE_VIEWPORT, one more quad is in the coverage image, which has one texel per block of 8×8
// rays.
#ifndef TECHNIQUE_PSM_QUAD_GLSL
#define TECHNIQUE_PSM_QUAD_GLSL
#include "technique/psm/place.glsl"

struct Quad {
    vec2 low;      // corners in NDC
    vec2 high;
    uint layer;    // layer of the 3D image
    uint viewport;
    vec4 shares;   // share of the optical depth per channel; negative: a coverage quad
};

uint slice_quads() { return SPLIT ? 2u : 1u; }

uint quad_count() { return slice_quads() + (COVERAGE == COVERAGE_VIEWPORT ? 1u : 0u); }

// Computes quad `index` < quad_count() of the caster; returns false if there is none.
bool caster_quad(View view, uint map, Caster caster, uint index, out Quad quad) {
    quad = Quad(vec2(2.0), vec2(2.0), 0u, 0u, vec4(0.0));
    vec2 low, high;
    if (!caster_bounds(view, caster, low, high)) {
        return false;
    }
    quad.layer = map * LAYERS;
    if (index >= slice_quads()) {
        // Converts NDC of the map to NDC of the coverage image, whose last texels may reach past the map. The quad is half a
        // coverage texel larger on each side, so that it covers the centre of each coverage texel that the bounds touch.
        vec2 size = vec2(view.width, view.height), tiles = ceil(size / 8.0);
        vec2 scale = size / (8.0 * tiles);
        quad.low = (clamp(low, -1.1, 1.1) + 1.0) * scale - 1.0 - 1.0 / tiles;
        quad.high = (clamp(high, -1.1, 1.1) + 1.0) * scale - 1.0 + 1.0 / tiles;
        quad.layer += LAYERS - 1u;
        quad.viewport = 1u;
        quad.shares = vec4(-1.0);
        return true;
    }
    quad.low = clamp(low, -1.1, 1.1);
    quad.high = clamp(high, -1.1, 1.1);
    Place place = caster_place(view, caster);
    uint channel = place.slice % 4u;
    quad.layer += place.slice / 4u + index;
    if (index == 1u) {
        quad.shares.x = place.share;
        return channel == 3u && place.share > 0.0;
    }
    quad.shares[channel] = 1.0 - place.share;
    if (channel < 3u) {
        quad.shares[channel + 1u] = place.share;
    }
    return true;
}

vec4 quad_corner(Quad quad, uint corner) {
    vec2 select = vec2(corner == 1u || corner == 2u || corner == 4u, corner == 2u || corner == 4u || corner == 5u);
    return vec4(mix(quad.low, quad.high, select), 0.5, 1.0);
}
#endif
