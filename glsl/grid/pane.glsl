// A sheet in a grid, as points on its triangle: grid/blob.glsl says how a point's amount is shared. Its silhouette is its area times
// |cos a|, a being the angle between its normal and the ray; |cos a| is replaced by its mean over all directions, 1/2. A sheet smaller than
// a voxel adds the share of light that it absorbs, as other small casters do; a larger one, which no ray in the voxel avoids, adds τ.
// Source: ours. Twin: reference::twin::sheet, bit for bit unless alpha comes from a texture, whose logarithm devices round as they
// like.
#ifndef GRID_PANE_GLSL
#define GRID_PANE_GLSL
#include "grid/blob.glsl"
#define ALPHA_TRIANGLES triangles
#include "world/sheet.glsl"

// Largest number of points along a side.
const uint MOST_PANE_POINTS = 1024u;

struct Pane {
    vec3 first;   // voxels
    vec3 b;       // from the first corner to the others
    vec3 c;
    uint side;    // points along a side: a power of two
    float amount; // of a point with an optical depth of 1
    bool large;
};

Pane pane_of(Caster sheet) {
    Triangle triangle = triangles[sheet_triangle(sheet)];
    precise vec3 a = (triangle.corners[0] - grid.origin) * grid.per_unit;
    precise vec3 b = (triangle.corners[1] - triangle.corners[0]) * grid.per_unit;
    precise vec3 c = (triangle.corners[2] - triangle.corners[0]) * grid.per_unit;
    precise float radius = sheet.radius * grid.per_unit;
    vec3 far = max(max(abs(b), abs(c)), abs(b - c));
    float widest = max(far.x, max(far.y, far.z));
    uint side = 2u;
    float each = 0.25;
    for (; float(side) < 2.0 * widest && side < MOST_PANE_POINTS; side *= 2u) {
        each *= 0.25;
    }
    precise vec3 normal = vec3(b.y * c.z - b.z * c.y, b.z * c.x - b.x * c.z, b.x * c.y - b.y * c.x);
    precise float square = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
    // Half of the cross product's length is the area, and a half of that its mean silhouette.
    precise float amount = 0.25 * root(square) * each;
    return Pane(a, b, c, side, amount, radius >= 1.0);
}

uint pane_count(Pane pane) { return pane.side * pane.side; }

// Weights of the triangle's second and third corners at point i. The points are those of a parallelogram, folded over its diagonal.
vec2 pane_weights(Pane pane, uint i) {
    vec2 at = (vec2(i % pane.side, i / pane.side) + 0.5) / float(pane.side);
    return at.x + at.y > 1.0 ? 1.0 - at : at;
}

vec3 pane_place(Pane pane, vec2 at) {
    precise vec3 place = pane.first + pane.b * at.x + pane.c * at.y;
    return place;
}

uint pane_amount(Pane pane, Caster sheet, vec2 at) {
    precise float optical_depth = sheet.density * sheet_share(sheet, at);
    precise float amount = pane.amount * (pane.large ? optical_depth : light_taken(optical_depth));
    return media_units(amount);
}
#endif
