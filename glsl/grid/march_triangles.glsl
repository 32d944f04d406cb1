// Whether a ray meets a triangle of a grid that lists them: every voxel on the way as march_exact goes (glsl/grid/march.glsl), and in
// an occupied one its triangles. A hit counts wherever on the ray it is. Needs visibility_triangles, and visibility_cells with the
// lists (glsl/grid/lists/place.glsl). Source: Woop et al. 2013, Watertight ray/triangle intersection; the box about the triangle and
// the bound are ours. Twin: the truth, in f64.
#ifndef GRID_MARCH_TRIANGLES_GLSL
#define GRID_MARCH_TRIANGLES_GLSL
#include "grid/lists/place.glsl"
#include "grid/occupied.glsl"
#include "grid/walk.glsl"
#include "world/triangle.glsl"

// How far from where it is a ray or a side may be taken to be along each axis, world units: by the longest way and the largest
// coordinate of a grid. docs/notebook/voxel-grid.md derives it. Twin: Stood::rounding in src/grid/stood.rs.
const float ROUNDING_OF_WAY = 1.0 / 524288.0;
const float ROUNDING_OF_PLACE = 1.0 / 2097152.0;

float grid_rounding(Grid grid) {
    float side = float(grid.size) * grid.voxel;
    vec3 far = max(abs(grid.origin), abs(grid.origin + side));
    return side * ROUNDING_OF_WAY + max(far.x, max(far.y, far.z)) * ROUNDING_OF_PLACE;
}

// A ray that looks along z from the origin: the axis along which it goes most, and what of it goes along the two others.
struct Shear {
    vec3 origin;
    uint axis;
    vec3 by;  // across and up of one along; lengths of the ray
};

vec3 shear_turned(vec3 v, uint axis) { return axis == 0u ? v.yzx : axis == 1u ? v.zxy : v; }

Shear shear_of(vec3 origin, vec3 direction) {
    vec3 far = abs(direction);
    uint axis = far.x >= far.y && far.x >= far.z ? 0u : far.y >= far.z ? 1u : 2u;
    vec3 turned = shear_turned(direction, axis);
    return Shear(origin, axis, vec3(turned.xy / turned.z, 1.0 / turned.z));
}

// x and y: how far beside the ray; z: where along it, in lengths of its direction.
vec3 sheared(Shear shear, vec3 corner) {
    precise vec3 v = shear_turned(corner - shear.origin, shear.axis);
    precise vec2 beside = v.xy - shear.by.xy * v.z;
    return vec3(beside, v.z * shear.by.z);
}

// Twice the area between the ray and a side. From the other triangle at that side it is the same with the other sign, to the bit,
// so that no ray goes between the two.
float side_area(vec2 from, vec2 to) {
    precise float area = from.x * to.y - from.y * to.x;
    return area;
}

// Whether the ray meets it before `end`, in lengths of its direction. One in whose plane it begins, up to `rounding`, is the surface that it
// leaves, and is not in its way.
bool shear_meets(Shear shear, Triangle triangle, float end, float rounding) {
    vec3 a = sheared(shear, triangle.corners[0]), b = sheared(shear, triangle.corners[1]);
    vec3 c = sheared(shear, triangle.corners[2]);
    vec3 low = min(a, min(b, c)), high = max(a, max(b, c));
    // Areas say nothing of a sliver that the ray passes far from.
    if (!(all(lessThanEqual(low.xy, vec2(0.0))) && all(greaterThanEqual(high, vec3(0.0))) && low.z <= end)) {
        return false;
    }
    float u = side_area(c.xy, b.xy), v = side_area(a.xy, c.xy), w = side_area(b.xy, a.xy);
    if (min(u, min(v, w)) < 0.0 && max(u, max(v, w)) > 0.0) {
        return false;
    }
    // Seen edge on it has no area, and hides nothing.
    float area = u + v + w, at = (u * a.z + v * b.z + w * c.z) / area;
    if (area == 0.0 || !(at > 0.0 && at < end)) {
        return false;
    }
    return abs(dot(triangle_normal(triangle), shear.origin - triangle.corners[0])) > rounding;
}

// `from` and `way` are voxels; the ray is that of `origin` and `direction`, world units.
bool march_triangles(vec3 from, vec3 way, vec3 origin, vec3 direction, float end) {
    March march;
    ivec3 voxel;
    if (!march_begin(from, way, GRID_SIZE, march, voxel)) {
        return false;
    }
    Shear shear = shear_of(origin, direction);
    float rounding = grid_rounding(visibility_grid);
    uvec3 block = uvec3(~0u), brick = uvec3(~0u);
    uvec2 bricks = uvec2(0u), voxels = uvec2(0u);
    uint first = 0u, list = 0u, side = grid_side(GRID_SIZE, 0u), shift = 0u;
    bool is_first = true;
    for (uint turn = 0u; turn < 3u * GRID_SIZE + 3u;) {
        // On to the next used voxel, so that neighbours test triangles at the same time.
        bool used = false;
        for (; turn < 3u * GRID_SIZE + 3u && !used; ++turn) {
#ifdef LOOK_UP_STEPS
            ++look_up_steps;
#endif
            if (!is_first) {
                vec3 planes = march_planes(march, voxel, shift);
                float nearest = min(planes.x, min(planes.y, planes.z));
                if (nearest >= march.range.y || !march_on(march, planes, nearest, shift, voxel)) {
                    return false;
                }
            }
            is_first = false;
            uvec3 at = uvec3(voxel) ^ march.mirror;
            if (at >> 4u != block) {
                block = at >> 4u;
                bricks = grid_bits(1u, block);
            }
            if (grid_is_empty(bricks)) {
                shift = grid_is_empty(grid_bits(2u, at >> 6u)) ? 6u : 4u;
            } else if (!grid_has(bricks, at >> 2u)) {
                shift = 2u;
            } else {
                if (at >> 2u != brick) {
                    brick = at >> 2u;
                    voxels = grid_bits(0u, brick);
                    first = visibility_cells[(brick.z * side + brick.y) * side + brick.x];
                }
                used = grid_has(voxels, at);
                shift = grid_octant_is_empty(voxels, at) ? 1u : 0u;
                list = first + used_before(voxels, grid_bit(0u, at));
            }
        }
        if (!used) {
            return false;
        }
        uint behind = visibility_cells[list + 1u];
        for (uint i = visibility_cells[list]; i < behind; ++i) {
            if (shear_meets(shear, visibility_triangles[visibility_cells[i]], end, rounding)) {
                return true;
            }
        }
    }
    return false;
}
#endif
