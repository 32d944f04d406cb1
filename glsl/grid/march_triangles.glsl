// Whether a ray hits a triangle, in a grid that lists triangles. The march visits every voxel on the segment, as march_exact does
// (glsl/grid/march.glsl), and in an occupied voxel tests the listed triangles whose boxes the ray crosses. A hit beyond the voxel counts
// too. Needs visibility_triangles, and visibility_cells with the lists (glsl/grid/lists/place.glsl). Source: Woop et al. 2013, Watertight
// ray/triangle intersection; boxes and bounds are ours. Twin: the truth, in f64.
#ifndef GRID_MARCH_TRIANGLES_GLSL
#define GRID_MARCH_TRIANGLES_GLSL
#include "grid/lists/box.glsl"
#include "grid/lists/place.glsl"
#include "grid/occupied.glsl"
#include "grid/walk.glsl"
#include "maps/float_order.glsl"
#include "world/shear.glsl"
#include "world/triangle_rows.glsl"
#define ALPHA_TRIANGLES visibility_triangles
#define ALPHA_ROWS
#include "world/alpha.glsl"

// Error bound of a rounded ray or triangle side along each axis, in world units: ROUNDING_OF_WAY times the longest segment plus
// ROUNDING_OF_PLACE times the largest coordinate in a grid. docs/notebook/voxel-grid.md derives both factors. Twin: Stood::rounding in
// src/grid/placement.rs.
const float ROUNDING_OF_WAY = 1.0 / 524288.0;
const float ROUNDING_OF_PLACE = 1.0 / 2097152.0;

// The largest absolute coordinate of a grid.
float grid_farthest(Grid grid) {
    vec3 far = max(abs(grid.origin), abs(grid.origin + float(grid.size) * grid.voxel));
    return max(far.x, max(far.y, far.z));
}

float grid_rounding(Grid grid) {
    return float(grid.size) * grid.voxel * ROUNDING_OF_WAY + grid_farthest(grid) * ROUNDING_OF_PLACE;
}

// Error bound of the distance between a rounded point and the plane of the triangle that contains it: ROUNDING_OF_POINT times the grid's
// largest coordinate, for rounding the point itself, plus ROUNDING_OF_PLANE times the point's distance from a corner of the triangle.
// docs/notebook/voxel-grid.md derives both factors.
const float ROUNDING_OF_POINT = 1.0 / 2097152.0;
const float ROUNDING_OF_PLANE = 3.0 / 4194304.0;

// Whether the ray begins in a triangle's plane, within the error bound.
bool begins_in_plane(vec3 origin, vec3 corners[3], float farthest) {
    vec3 ab = corners[1] - corners[0], ac = corners[2] - corners[0], from = origin - corners[0], normal = cross(ab, ac);
    float place = farthest * ROUNDING_OF_POINT * length(normal);
    float plane = ROUNDING_OF_PLANE * length(ab) * length(ac) * length(from);
    return abs(dot(normal, from)) <= place + plane;
}

// Whether the ray hits triangle `number` before `end`, in lengths of the ray's direction, and not in a hole. If the ray begins in the
// triangle's plane, the triangle is the surface that the ray leaves, and does not count.
bool shear_meets(Shear shear, uint number, float end, float farthest) {
    vec3 corners[3] = triangle_corners(visibility_triangles[number]);
    vec3 a = sheared(shear, corners[0]), b = sheared(shear, corners[1]), c = sheared(shear, corners[2]);
    vec3 low = min(a, min(b, c)), high = max(a, max(b, c));
    // Tests bounds first: if a sliver is far from the ray, the areas below are mostly rounding error.
    if (!(all(lessThanEqual(low.xy, vec2(0.0))) && all(greaterThanEqual(high, vec3(0.0))) && low.z <= end)) {
        return false;
    }
    float u = side_area(c.xy, b.xy), v = side_area(a.xy, c.xy), w = side_area(b.xy, a.xy);
    if (min(u, min(v, w)) < 0.0 && max(u, max(v, w)) > 0.0) {
        return false;
    }
    // Seen edge-on, the triangle has no area and hides nothing.
    float area = u + v + w, at = (u * a.z + v * b.z + w * c.z) / area;
    if (area == 0.0 || !(at > 0.0 && at < end)) {
        return false;
    }
    return !begins_in_plane(shear.origin, corners, farthest) && alpha_blocks(number, vec2(v, w) / area);
}

// Number of list entries to load at a time, so as to wait once for all of them.
const uint ASKED_AT_ONCE = 4u;

// The part of a segment inside a voxel, as a box around each half of that part (glsl/grid/lists/box.glsl).
uvec2 boxes_of_way(vec3 from, vec3 way, uvec3 voxel, float begin, float end) {
    vec3 corner = (from - vec3(voxel)) * float(BOX_PLACES), along = way * float(BOX_PLACES);
    vec3 first = corner + along * begin, last = corner + along * end;
    uvec3 middle = box_place(0.5 * (first + last));
    return uvec2(box_between(box_place(first), middle), box_between(middle, box_place(last)));
}

bool way_meets(uvec2 way, uint box) { return box_is_met(box, way.x) || box_is_met(box, way.y); }

// One bit for each of ASKED_AT_ONCE triangles of a list, from `entry` on: whether the segment crosses its box.
uint boxes_met(uvec2 way, uint entry, uint behind) {
    uint met = 0u;
    for (uint i = 0u; i < ASKED_AT_ONCE; ++i) {
        uint at = entry + LIST_WORDS * i;
        bool is_met = way_meets(way, visibility_cells[min(at, behind - LIST_WORDS)]);
        met |= at < behind && is_met ? 1u << i : 0u;
    }
    return met;
}

// Boxes are enlarged by this share of a voxel on each side: GRID_SLACK in glsl/grid/lists/meets.glsl.
const float BOX_SLACK = 1.0 / 512.0;

// The part of a segment inside the box around all casters, in lengths of the segment.
vec2 cast_clip(vec3 from, vec3 way) {
    vec3 low, high;
    for (uint axis = 0u; axis < 3u; ++axis) {
        low[axis] = float_of_order(visibility_grid.low[axis]);
        high[axis] = float_of_order(visibility_grid.high[axis]);
    }
    low = (low - visibility_grid.origin) * visibility_grid.per_unit - BOX_SLACK;
    high = (high - visibility_grid.origin) * visibility_grid.per_unit + BOX_SLACK;
    return box_clip(from, way, low, high);
}

// `from` and `way` are in voxels; `origin` and `direction` are the same ray in world units. No loop contains a break or a return, so that
// neighbouring threads reconverge after each loop.
bool march_triangles(vec3 from, vec3 way, vec3 origin, vec3 direction, float end) {
    March march;
    ivec3 voxel;
    bool goes_on = march_within(from, way, cast_clip(from, way), GRID_SIZE, march, voxel), hit = false;
    Shear shear = shear_of(origin, direction);
    float farthest = grid_farthest(visibility_grid), begin = march.range.x;
    // Words of the current block and brick; both are loaded when the segment enters another one.
    uint block = ~0u, brick = ~0u, side = grid_side(GRID_SIZE, 0u), first = 0u;
    uvec2 blocks = uvec2(0u), bricks = uvec2(0u), voxels = uvec2(0u);
    // The entries of the current list that are not tested yet.
    uint entry = 0u, behind = 0u, turn = 0u;
    uvec2 seen = uvec2(0u);
    while (goes_on && !hit) {
        // Continues to the next voxel whose list's box is crossed, so that neighbouring threads test triangles at the same time.
        while (goes_on && entry >= behind) {
#ifdef LOOK_UP_STEPS
            ++look_up_steps;
#endif
            uvec3 at = uvec3(voxel) ^ march.mirror, word = at >> 2u;
            uint place = (word.z * side + word.y) * side + word.x;
            if (place != brick) {
                brick = place;
                voxels = grid_bits(0u, word);
                first = visibility_cells[place];
                place = grid_word(GRID_SIZE, 1u, at);
                if (place != block) {
                    block = place;
                    bricks = grid_bits(1u, at >> 4u);
                    blocks = grid_bits(2u, at >> 6u);
                }
            }
            // The largest empty cube around the voxel, 2^shift voxels per side: taken from the finest level whose word is not empty, and
            // from the octant there.
            bool is_brick = !grid_is_empty(voxels), is_block = !grid_is_empty(bricks);
            uvec2 bits = is_brick ? voxels : is_block ? bricks : blocks;
            uint shift = is_brick ? 0u : is_block ? 2u : 4u;
            shift = grid_is_empty(bits) ? 6u : grid_octant_is_empty(bits, at >> shift) ? shift + 1u : shift;
            vec3 planes = march_planes(march, voxel, shift);
            float nearest = min(planes.x, min(planes.y, planes.z));
            if (is_brick && grid_has(voxels, at)) {
                uint list = first + LIST_WORDS * used_before(voxels, grid_bit(0u, at)), box = visibility_cells[list + 1u];
                entry = visibility_cells[list];
                behind = visibility_cells[list + LIST_WORDS];
                seen = boxes_of_way(from, way, at, begin, min(nearest, march.range.y));
                behind = way_meets(seen, box) ? behind : entry;
            }
            begin = nearest;
            ++turn;
            goes_on = nearest < march.range.y && march_on(march, planes, nearest, shift, voxel) && turn < 3u * GRID_SIZE + 3u;
        }
        while (entry < behind && !hit) {
            uint met = boxes_met(seen, entry, behind);
            for (; met != 0u && !hit; met &= met - 1u) {
                uint number = visibility_cells[entry + LIST_WORDS * uint(findLSB(met)) + 1u];
                hit = shear_meets(shear, number, end, farthest);
            }
            entry += ASKED_AT_ONCE * LIST_WORDS;
        }
    }
    return hit;
}
#endif
