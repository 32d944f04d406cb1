// A triangle over an 8 × 8 block of columns: three edge functions in integer arithmetic, and the plane of its depths. Source: ours, after
// Pineda 1988. Twin: reference::twin::voxelized::Facet.
#ifndef TECHNIQUE_VOXELIZED_FACET_GLSL
#define TECHNIQUE_VOXELIZED_FACET_GLSL

#include "maps/edge.glsl"

// The plane of a triangle's depths.
struct Plane {
    float z;     // depth at the first column, in voxels; with PERSPECTIVE 1 over the depth
    vec2 slope;  // change per column
    vec2 range;  // least and greatest z of the corners, voxels
    int faces;   // 1: into a closed mesh, -1: out of one, 0: open
};

struct Facet {
    ivec3 edge;   // value at the block's first column: not negative inside
    ivec3 right;  // change per column to the right
    ivec3 up;     // change per column up
    ivec2 first;  // first column of the block whose square the bounding box overlaps
    ivec2 end;    // one past the last such column; both are set only for squares
    Plane plane;
};

float projected_float(uint i, uint word) { return intBitsToFloat(projected[PROJECTED_WORDS * i + word]); }

// Returns the value, in columns, of the edge that begins at `from` and runs along `edge`: at the origin, or with `squares` at the corner of
// the square around the origin that is farthest inside the edge. Values whose sign no column of the block changes are clamped.
int edge_value(ivec2 from, ivec2 edge, bool squares) {
    ivec2 corner = squares ? 128 * ivec2(edge.y < 0 ? 1 : -1, edge.x > 0 ? 1 : -1) : ivec2(0);
    Wide value = wide_cross(edge, corner - from);
    int columns = value.high < -64 ? -0x40000000 : value.high > 63 ? 0x40000000
                                                 : int((uint(value.high) << 24) | (value.low >> 8));
    // A column's centre may lie exactly on the edge, where the value is 0, which counts as inside. One of the two triangles that share the
    // edge keeps this value; the value of the other is lowered, so that only one of them covers the column. With `squares`, both triangles
    // may touch the same square.
    return !squares && (value.low & 255u) == 0u && !owns_edge(edge) ? columns - 1 : columns;
}

// Sets up triangle `i` for the block whose first column is `corner`; returns false if no column of the block hits it. A column hits a
// triangle that covers the column's centre, or with `squares` one that touches the column's square anywhere. With `squares`, a column's
// depth is the depth at the corner of its square that is farthest from the light, so that no depth lies in front of the triangle.
bool facet_at(uint i, uvec2 corner, bool squares, out Facet facet) {
    ivec2 middle = 256 * ivec2(corner) + 128;
    ivec2 a = projected_corner(i, 0u) - middle, b = projected_corner(i, 1u) - middle, c = projected_corner(i, 2u) - middle;
    vec3 z = vec3(projected_float(i, PROJECTED_DEPTHS), projected_float(i, PROJECTED_DEPTHS + 1u),
                  projected_float(i, PROJECTED_DEPTHS + 2u));
    vec3 plane = z;
    Wide area = wide_cross(b - a, c - a);
    bool turned = area.high < 0;
    if (turned) {
        ivec2 corner_b = b;
        b = c;
        c = corner_b;
        z = z.xzy;
        area = wide_cross(b - a, c - a);
    }
    // Not negative inside; a degenerate triangle has no inside.
    facet.edge = ivec3(edge_value(a, b - a, squares), edge_value(b, c - b, squares), edge_value(c, a - c, squares));
    facet.right = -ivec3((b - a).y, (c - b).y, (a - c).y);
    facet.up = ivec3((b - a).x, (c - b).x, (a - c).x);
    if (squares) {
        facet.first = (min(a, min(b, c)) + 127) >> 8;
        facet.end = ((max(a, max(b, c)) + 128) >> 8) + 1;
    }
    ivec3 most = facet.edge + 7 * (max(facet.right, ivec3(0)) + max(facet.up, ivec3(0)));
    float scale = 1.0 / (float(area.high) * 4294967296.0 + float(area.low));
    vec2 ab = vec2(b - a), ac = vec2(c - a);
    float to_b = z.y - z.x, to_c = z.z - z.x;
    vec2 slope = vec2(to_b * ac.y - to_c * ab.y, to_c * ab.x - to_b * ac.x) * scale;
    facet.plane.z = z.x - slope.x * float(a.x) - slope.y * float(a.y);
    facet.plane.slope = slope * SUB_VOXELS;
    facet.plane.range = vec2(min(z.x, min(z.y, z.z)), max(z.x, max(z.y, z.z)));
    if (PERSPECTIVE) {
        vec2 first = vec2(corner) + 0.5 - 0.5 * float(trees[light].size);
        facet.plane.z = plane.x + plane.y * first.x + plane.z * first.y;
        facet.plane.slope = plane.yz;
        facet.plane.range = vec2(projected_float(i, PROJECTED_RANGE), projected_float(i, PROJECTED_RANGE + 1u));
    }
    if (squares) {
        float farther = 0.5 * (abs(facet.plane.slope.x) + abs(facet.plane.slope.y));
        facet.plane.z += PERSPECTIVE ? -farther : farther;
    }
    // The outside of a closed mesh is visible where the triangle runs counter-clockwise as seen from the light.
    int side = projected_side(i);
    facet.plane.faces = turned ? -side : side;
    return (area.high | int(area.low)) != 0 && all(greaterThanEqual(most, ivec3(0)));
}

// Returns which of `count` columns from `first` on hit the triangle, one bit each.
uint facet_columns(Facet facet, uint first, uint count) {
    uint met = 0u;
    for (uint c = 0u; c < count; ++c) {
        ivec2 column = ivec2((first + c) & 7u, (first + c) >> 3);
        ivec3 edge = facet.edge + facet.right * column.x + facet.up * column.y;
        // One negative value makes the combined value negative.
        met |= uint((~(edge.x | edge.y | edge.z) >> 31) & 1) << c;
    }
    return met;
}

float plane_depth(Plane plane, ivec2 column) {
    float z = plane.z + plane.slope.x * float(column.x) + plane.slope.y * float(column.y);
    if (PERSPECTIVE) {
        z = z > 0.0 ? 1.0 / z : plane.range.y;
    }
    return clamp(z, plane.range.x, plane.range.y);
}
#endif
