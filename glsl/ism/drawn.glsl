// How points are drawn: a quad or a triangle each, into the depth target of all maps, which stand in rows of COLUMNS. Twin:
// technique::ism::raster.
#ifndef ISM_DRAWN_GLSL
#define ISM_DRAWN_GLSL

// Of a point: 6 for a quad, 3 for a triangle.
CONSTANT(uint, DRAWN_VERTICES, 6u)
// Maps next to each other.
CONSTANT(uint, COLUMNS, 32u)

// Points that lights see are listed; else all are drawn.
CONSTANT(bool, DRAWN_LISTED, true)

const uint UNKEPT = 0xffffffffu;

// A distance that is as large as many points are wide is stored as a half.
const float HALF_WAY = 64.0;

float drawn_depth(float distance, float radius) { return distance / (distance + HALF_WAY * radius); }

float drawn_distance(float depth, float radius) { return HALF_WAY * radius * depth / (1.0 - depth); }

uvec2 map_corner(uint map, uint size) { return uvec2(map % COLUMNS, map / COLUMNS) * size; }
#endif
