// Optical depth of smoke and hair along a segment through a grid that lists them. The march visits every voxel on the segment that has a
// list, and tests the list's casters. A caster listed in many voxels counts once: in the voxel in which the segment enters the caster, or
// begins if it begins inside the caster. This works since all voxels compute positions along the segment in the same float arithmetic, and
// each voxel ends where the next begins. Casters that are listed for all voxels are tested first. Needs visibility_cast_bits,
// visibility_cast_lists (glsl/grid/lists/place.glsl), visibility_casters and GRID_SIZE. Source: ours. Twin: the truth, in f64.
#ifndef GRID_MARCH_CASTERS_GLSL
#define GRID_MARCH_CASTERS_GLSL
#include "grid/lists/place.glsl"
#include "grid/walk.glsl"
#include "world/cast_depth.glsl"

uvec2 cast_bits(uint level, uvec3 word) {
    uint side = grid_side(GRID_SIZE, level);
    uint at = 2u * (grid_level_at(GRID_SIZE, level) + (word.z * side + word.y) * side + word.x);
    return uvec2(visibility_cast_bits[at], visibility_cast_bits[at + 1u]);
}

// `from` and `way` are in voxels; `ray` is the same segment in world units. For both, the segment ends at parameter 1.
float march_casters(vec3 from, vec3 way, Ray ray) {
    March march;
    ivec3 voxel;
    if (!march_begin(from, way, GRID_SIZE, march, voxel)) {
        return 0.0;
    }
    uvec3 block = uvec3(~0u), brick = uvec3(~0u);
    uvec2 bricks = uvec2(0u), voxels = uvec2(0u);
    uint first = 0u, side = grid_side(GRID_SIZE, 0u);
    float begin = -FARTHEST, ray_length = length(ray.direction), entry, sum = 0.0;
    // The list that all voxels share: every ray tests it.
    uint all = visibility_cast_lists[lists_of_all(GRID_SIZE)], behind = visibility_cast_lists[all + LIST_WORDS];
    for (uint i = visibility_cast_lists[all]; i < behind && sum < MAX_OPTICAL_DEPTH; i += LIST_WORDS) {
        sum += cast_depth(ray, ray_length, visibility_casters[visibility_cast_lists[i + 1u]], 1.0, entry);
    }
    for (uint turn = 0u; turn < 3u * GRID_SIZE + 3u; ++turn) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        uvec3 at = uvec3(voxel) ^ march.mirror;
        if (at >> 4u != block) {
            block = at >> 4u;
            bricks = cast_bits(1u, block);
        }
        uint shift = 0u;
        bool used = false;
        if (grid_is_empty(bricks)) {
            shift = grid_is_empty(cast_bits(2u, at >> 6u)) ? 6u : 4u;
        } else if (!grid_has(bricks, at >> 2u)) {
            shift = 2u;
        } else {
            if (at >> 2u != brick) {
                brick = at >> 2u;
                voxels = cast_bits(0u, brick);
                first = visibility_cast_lists[(brick.z * side + brick.y) * side + brick.x];
            }
            used = grid_has(voxels, at);
            shift = grid_octant_is_empty(voxels, at) ? 1u : 0u;
        }
        vec3 planes = march_planes(march, voxel, shift);
        float nearest = min(planes.x, min(planes.y, planes.z));
        bool last = nearest >= march.range.y;
        if (used) {
            uint list = first + LIST_WORDS * used_before(voxels, grid_bit(0u, at));
            behind = visibility_cast_lists[list + LIST_WORDS];
            vec2 between = vec2(begin, last ? FARTHEST : nearest);
            for (uint i = visibility_cast_lists[list]; i < behind; i += LIST_WORDS) {
                Caster caster = visibility_casters[visibility_cast_lists[i + 1u]];
                float taken = cast_depth(ray, ray_length, caster, 1.0, entry);
                sum += entry >= between.x && entry < between.y ? taken : 0.0;
            }
        }
        if (last || sum >= MAX_OPTICAL_DEPTH) {
            break;
        }
        begin = max(begin, nearest);
        if (!march_on(march, planes, nearest, shift, voxel)) {
            break;
        }
    }
    return sum;
}
#endif
