// Points are drawn as quads or triangles into a depth target that holds all maps, in rows of COLUMNS. Twin:
// technique::ism::raster.
#ifndef TECHNIQUE_ISM_DRAWN_GLSL
#define TECHNIQUE_ISM_DRAWN_GLSL
#include "technique/ism/map.glsl"

// Vertices drawn per point: 6 for a quad, 3 for a triangle.
CONSTANT(uint, DRAWN_VERTICES, 6u)
// Maps per row of the target.
CONSTANT(uint, COLUMNS, 32u)

// True: draws a list of the points that lights see. False: draws all points.
CONSTANT(bool, DRAWN_LISTED, true)

// Distance, in radii of a point, that is stored as a depth of ½.
const float HALF_WAY = 64.0;

float drawn_depth(float distance, float radius) { return distance / (distance + HALF_WAY * radius); }

float drawn_distance(float depth, float radius) { return HALF_WAY * radius * depth / (1.0 - depth); }

uvec2 map_corner(uint map, uint size) { return uvec2(map % COLUMNS, map / COLUMNS) * size; }

// How much wider than its disc a point is drawn. A disc also covers texels whose centres it just misses, but a rasterizer covers only
// texels whose centres are inside the shape.
const float WIDER = 1.2;

// Returns a point in the target: its centre and radius, in texels, and its depth. `offset`: the point's offset from the light, in world
// axes; `usual`: the radius used to encode depths.
vec4 drawn_point(uint light, Axes axes, vec3 offset, float radius, float usual) {
    vec3 way = into_axes(axes, offset);
    float distance = length(way), ahead = distance + way.z;
    // Kept off the border, where the next map begins.
    vec2 middle = clamp((way.xy / ahead * 0.5 + 0.5) * float(ISM_SIZE), vec2(0.0), vec2(float(ISM_SIZE) - 0.01));
    // At least half a texel, so that the point covers the texel that contains it.
    float reach = max(WIDER * radius / ahead * (0.5 * float(ISM_SIZE)), 0.57);
    return vec4(middle + vec2(map_corner(light, ISM_SIZE)), reach, drawn_depth(distance, usual));
}
#endif
