// Voxelized shadows look-up: how much of light `light` reaches `position`, 0 to 1, as the share of the PCF × PCF columns around the
// position whose voxel at the position's depth is lit. The look-up first descends through the nodes that all these columns share
// (shared_way). Below them it counts columns leaf by leaf, in at most four leaves. Source: Sintorn et al. 2014, section 5. Twin:
// reference::twin::voxelized::look_up.
//   binding 0  the trees of all lights (technique/voxelized/tree.glsl)
//   binding 1  nodes of all trees, and the words of their cells
// flat: bindings 72, constants 144: HEADER_BITS CONSERVATIVE PCF NORMAL_BIAS
#include "technique/voxelized/walk.glsl"
#include "technique/voxelized/place.glsl"

// Side of the filter, in columns.
CONSTANT(uint, PCF, 1u)

// Share of the normal offset by which a surface point is moved; 1 keeps a flat surface out of its own shadow.
CONSTANT(float, NORMAL_BIAS, 1.0)

// Rounding tolerance, in voxels: corners are rounded to 256ths, and depths and positions among 65,536 voxels to 128ths.
const float ROUNDING = 1.0 / 32.0;

// Returns a mask for one of a leaf's two words, which holds the four rows from row `first` on. The mask has the bits of `row` in each of
// the rows `rows.x` to `rows.y`.
uint leaf_rows(uint row, ivec2 rows, int first) {
    int low = max(rows.x - first, 0), high = min(rows.y - first, 3);
    return low > high ? 0u : (row * 0x01010101u) & (0xffffffffu >> (8 * (3 - high))) & (0xffffffffu << (8 * low));
}

// Returns whether a voxel is shadowed.
bool shadowed_voxel(uint light, uvec3 voxel) {
    Walk walk = walk_from_cell(light, voxel);
    while (walk.kind == INTERSECTED && walk.level > 0u) {
        walk_down(light, voxel, walk);
    }
    if (walk.kind != INTERSECTED) {
        return walk.kind == SHADOWED;
    }
    uint bit = 8u * (voxel.y & 7u) + (voxel.x & 7u);
    uint word = visibility_trees[light].at[0] + 2u * walk.node + (bit >> 5);
    return (visibility_nodes[word] >> (bit & 31u) & 1u) == 1u;
}

// Returns how many of the columns low to high are shadowed at z.
uint shadowed_columns(uint light, ivec2 low, ivec2 high, uint z) {
    uint levels = visibility_trees[light].levels;
    bool one_cell = shortcut_of(levels, uvec3(low, z)) == shortcut_of(levels, uvec3(high, z));
    Walk shared_way = walk_from_cell(light, uvec3(low, z));
    // Descends once for all columns, as long as they lie in the same child.
    while (one_cell && shared_way.kind == INTERSECTED && shared_way.level > 1u &&
           all(equal(low >> int(shared_way.level + 1u), high >> int(shared_way.level + 1u)))) {
        walk_down(light, uvec3(low, z), shared_way);
    }
    uint shadowed = 0u;
    for (int y = low.y >> 3; y <= high.y >> 3; ++y) {
        for (int x = low.x >> 3; x <= high.x >> 3; ++x) {
            Walk walk = one_cell ? shared_way : walk_from_cell(light, uvec3(8 * x, 8 * y, z));
            while (walk.kind == INTERSECTED && walk.level > 0u) {
                walk_down(light, uvec3(8 * x, 8 * y, z), walk);
            }
            ivec2 first = max(low - 8 * ivec2(x, y), 0), last = min(high - 8 * ivec2(x, y), 7);
            uint row = ((2u << last.x) - 1u) & ~((1u << first.x) - 1u);
            uvec2 mask = uvec2(leaf_rows(row, ivec2(first.y, last.y), 0), leaf_rows(row, ivec2(first.y, last.y), 4));
            uvec2 bits = walk.kind == SHADOWED ? mask : uvec2(0u);
            if (walk.kind == INTERSECTED) {
                bits = walk_leaf(light, walk) & mask;
            }
            shadowed += uint(bitCount(bits.x) + bitCount(bits.y));
        }
    }
    return shadowed;
}

// Moves a point off its surface along the normal, far enough that the surface lies behind the point in every column that the look-up reads.
// In a column, the surface has the depth of its plane at the column's centre, rounded by half a voxel; the centre is up to PCF / 2 voxels
// beside the point. With CONSERVATIVE, the depth may instead be that of the farthest corner of the column's square, half a voxel farther
// out. ROUNDING allows for the rounding of corners and depths.
#define TECHNIQUE_RECEIVERS
vec3 light_receiver(uint light, vec3 position, vec3 normal) {
    float reach = 0.5 * float(PCF) + (CONSERVATIVE ? 0.5 : 0.0);
    vec3 by = NORMAL_BIAS * vec3(reach, 0.5, ROUNDING);
    uint tree = tree_of(light, position);
    float way = receiver_way(tree, position, normal, by.x, by.y, by.z);
    // The moved point may be looked up in another face of the cube, which has different columns.
    uint other = tree_of(light, position + normal * way);
    if (other != tree) {
        way = max(way, receiver_way(other, position, normal, by.x, by.y, by.z));
    }
    return position + normal * way;
}

float light_visibility(uint light, vec3 position) {
    uint tree = tree_of(light, position);
    vec3 voxel = tree_voxel(tree, position);
    float size = float(visibility_trees[tree].size), reach = float(PCF / 2u);
    bool perspective = visibility_trees[tree].perspective != 0u;
    float beyond = perspective ? size : reach;
    // Tested as floats: a position outside, or NaN, has no voxel. Everything behind the cube is in the shadow of the meshes.
    if (!(voxel.z >= 0.0 && all(greaterThan(voxel.xy, vec2(-beyond))) && all(lessThan(voxel.xy, vec2(size + beyond))))) {
        return 1.0;
    }
    // A light with a position also lights points outside its pyramid. A point that was moved out of the pyramid, or a filter that extends
    // beyond it, is clamped to the pyramid's edge.
    voxel.xy = perspective ? clamp(voxel.xy, vec2(reach), vec2(size - reach - 0.5)) : voxel.xy;
    ivec2 column = ivec2(floor(voxel.xy)), last = ivec2(int(visibility_trees[tree].size) - 1);
    if (PCF == 1u) {
        return shadowed_voxel(tree, uvec3(column, min(voxel.z, size - 1.0))) ? 0.0 : 1.0;
    }
    ivec2 low = max(column - int(PCF / 2u), ivec2(0)), high = min(column + int(PCF / 2u), last);
    uint shadowed = shadowed_columns(tree, low, high, uint(min(voxel.z, size - 1.0)));
    // Exact if none or all are shadowed, even if a device divides by multiplying.
    return shadowed == 0u ? 1.0 : float(PCF * PCF - shadowed) / float(PCF * PCF);
}
