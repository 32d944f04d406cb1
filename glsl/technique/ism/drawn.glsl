// How points are drawn: a quad or a triangle each, into the depth target of all maps, which stand in rows of COLUMNS. Twin:
// technique::ism::raster.
#ifndef TECHNIQUE_ISM_DRAWN_GLSL
#define TECHNIQUE_ISM_DRAWN_GLSL
#include "technique/ism/map.glsl"

// Vertices drawn per point: 6 for a quad, 3 for a triangle.
CONSTANT(uint, DRAWN_VERTICES, 6u)
// Maps next to each other.
CONSTANT(uint, COLUMNS, 32u)

// Points that lights see are listed; else all are drawn.
CONSTANT(bool, DRAWN_LISTED, true)

// A distance of so many radii of a point is stored as a depth of ½.
const float HALF_WAY = 64.0;

float drawn_depth(float distance, float radius) { return distance / (distance + HALF_WAY * radius); }

float drawn_distance(float depth, float radius) { return HALF_WAY * radius * depth / (1.0 - depth); }

uvec2 map_corner(uint map, uint size) { return uvec2(map % COLUMNS, map / COLUMNS) * size; }

// How much wider than the disc a point's shape is drawn. A disc also covers texels whose middles it just misses, but a rasterizer covers
// only texels whose middles are inside the shape.
const float WIDER = 1.2;

// A point in the target: its middle and its radius, texels, and its depth. `offset`: from the light, world axes; `usual`: the radius
// that depths are stored by.
vec4 drawn_point(uint light, Axes axes, vec3 offset, float radius, float usual) {
    vec3 way = into_axes(axes, offset);
    float distance = length(way), ahead = distance + way.z;
    // Never on the border, where the next map begins.
    vec2 middle = clamp((way.xy / ahead * 0.5 + 0.5) * float(ISM_SIZE), vec2(0.0), vec2(float(ISM_SIZE) - 0.01));
    // At least half a texel, so that the point covers the texel that it is in.
    float reach = max(WIDER * radius / ahead * (0.5 * float(ISM_SIZE)), 0.57);
    return vec4(middle + vec2(map_corner(light, ISM_SIZE)), reach, drawn_depth(distance, usual));
}
#endif
