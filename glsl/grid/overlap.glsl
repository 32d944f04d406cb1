// Whether a triangle overlaps a voxel. Source: Schwarz and Seidel 2010, section 3. Twin: reference::twin::grid::Facet, bit for bit: nothing
// here may be fused or reordered, and there is no division.
#ifndef GRID_OVERLAP_GLSL
#define GRID_OVERLAP_GLSL

// Cells per side of a voxel, a power of two; a triangle's coordinates are in these cells.
#ifndef FACET_CELLS
#define FACET_CELLS 1
#endif

// Voxels and cells are enlarged by this share of a voxel on each side, as a margin for rounding.
#ifndef GRID_SLACK
#define GRID_SLACK (1e-4 * float(FACET_CELLS))
#endif

struct Facet {
    vec3 corners[3];  // voxels
    vec3 edges[3];    // edges[i] starts at corners[i]
    vec3 normal;
    ivec3 first;      // first voxel of the triangle's box
    ivec3 last;
    uint number;      // index of the triangle
};

// Ends of the triangle's box, enlarged by the slack.
vec3 low_of(Facet facet) {
    precise vec3 low = min(facet.corners[0], min(facet.corners[1], facet.corners[2])) - GRID_SLACK;
    return low;
}

vec3 high_of(Facet facet) {
    precise vec3 high = max(facet.corners[0], max(facet.corners[1], facet.corners[2])) + GRID_SLACK;
    return high;
}

Facet facet_of(vec3 a, vec3 b, vec3 c, uint size) {
    Facet facet;
    facet.corners = vec3[3](a, b, c);
    precise vec3 ab = b - a, bc = c - b, ca = a - c;
    facet.edges = vec3[3](ab, bc, ca);
    precise float x = ab.y * bc.z - ab.z * bc.y;
    precise float y = ab.z * bc.x - ab.x * bc.z;
    precise float z = ab.x * bc.y - ab.y * bc.x;
    facet.normal = vec3(x, y, z);
    facet.first = ivec3(clamp(floor(low_of(facet)), vec3(0.0), vec3(size - 1u)));
    facet.last = ivec3(clamp(floor(high_of(facet)), vec3(0.0), vec3(size - 1u)));
    return facet;
}

// Whether a triangle is a single point, which casts no shadow. Triangles beyond a count that only the device knows are unused, and are such
// points.
bool facet_is_point(Facet facet) {
    return facet.edges[0] == vec3(0.0) && facet.edges[1] == vec3(0.0) && facet.edges[2] == vec3(0.0);
}

// Whether the voxel's square, seen along an axis, reaches the inner side of an edge. `from`: the edge's corner, relative to the
// voxel's corner.
bool inside_edge(vec2 from, vec2 edge, float turn) {
    float x = edge.y * turn, y = edge.x * turn;
    precise float at = x * from.x - y * from.y;
    precise float reach = max(-x, 0.0) + max(y, 0.0);
    precise float slack = GRID_SLACK * (abs(x) + abs(y));
    precise float inner = at + reach + slack;
    return inner >= 0.0;
}

// Whether the voxel's square overlaps the triangle, seen along each axis.
bool facet_meets_sides(Facet facet, ivec3 voxel) {
    vec3 corner = vec3(voxel), normal = facet.normal;
    vec3 turn = vec3(normal.x >= 0.0 ? 1.0 : -1.0, normal.y >= 0.0 ? 1.0 : -1.0, normal.z >= 0.0 ? 1.0 : -1.0);
    for (uint i = 0u; i < 3u; ++i) {
        precise vec3 from = facet.corners[i] - corner;
        vec3 edge = facet.edges[i];
        if (!inside_edge(from.xy, edge.xy, turn.z) || !inside_edge(from.yz, edge.yz, turn.x) ||
            !inside_edge(from.zx, edge.zx, turn.y)) {
            return false;
        }
    }
    return true;
}

// Whether a triangle overlaps a voxel of its box.
bool facet_meets(Facet facet, ivec3 voxel) {
    vec3 corner = vec3(voxel), normal = facet.normal;
    precise vec3 a = facet.corners[0] - corner;
    // Tests whether the plane passes between the voxel's two extreme corners along the normal.
    precise float plane = normal.x * a.x + normal.y * a.y + normal.z * a.z;
    precise float most = max(normal.x, 0.0) + max(normal.y, 0.0) + max(normal.z, 0.0);
    precise float least = min(normal.x, 0.0) + min(normal.y, 0.0) + min(normal.z, 0.0);
    precise float slack = GRID_SLACK * (abs(normal.x) + abs(normal.y) + abs(normal.z));
    precise float above = most + slack - plane, below = plane - least + slack;
    return !(above < 0.0 || below < 0.0) && facet_meets_sides(facet, voxel);
}
#endif
