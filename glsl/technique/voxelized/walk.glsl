// Descends a tree from the root towards a voxel, until a node is entirely lit or shadowed, or to a leaf. Source: Sintorn et al. 2014, Kämpe
// et al. 2016. Twin: reference::twin::voxelized::Walk.
#ifndef TECHNIQUE_VOXELIZED_WALK_GLSL
#define TECHNIQUE_VOXELIZED_WALK_GLSL
#include "technique/voxelized/tree.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

// A bake walks the tree that it has just built.
#ifdef TECHNIQUE_VOXELIZED_BUILD_GLSL
#define visibility_trees trees
#define visibility_nodes data
#else
layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityTrees { Tree visibility_trees[]; };
layout(set = GOBO_SET, binding = 1, scalar) readonly buffer VisibilityNodes { uint visibility_nodes[]; };
#endif

// Returns `count` bits, at most 32, from bit `bit` of a word on.
uint node_bits(uint word, uint bit, uint count) {
    word += bit >> 5;
    bit &= 31u;
    uint bits = visibility_nodes[word] >> bit;
    bits |= visibility_nodes[word + 1u] << 1 << (31u - bit);
    return count == 32u ? bits : bits & ((1u << count) - 1u);
}

// A node on the way down, and the kind of its voxels: INTERSECTED as long as the walk continues.
struct Walk {
    uint level;
    uint node;
    uint kind;
};

Walk walk_from_root(uint light) {
    return Walk(visibility_trees[light].levels - 1u, visibility_trees[light].root_at, visibility_trees[light].root);
}

// Returns a walk that begins at the voxel's shortcut cell.
Walk walk_from_cell(uint light, uvec3 voxel) {
    uint levels = visibility_trees[light].levels;
    uint cell = visibility_nodes[visibility_trees[light].shortcuts + shortcut_of(levels, voxel)];
#ifdef LOOK_UP_STEPS
    ++look_up_steps;
#endif
    return Walk(levels - 1u - shortcut_bits(levels), cell >> 2, cell & 3u);
}

// Descends one level towards a voxel, from a node above the leaves.
void walk_down(uint light, uvec3 voxel, inout Walk walk) {
    uint word = visibility_trees[light].at[walk.level] + (HEADER_BITS == 16u ? walk.node >> 1 : walk.node);
    uint bit = HEADER_BITS == 16u ? 16u * (walk.node & 1u) : 0u;
    uint mask = node_bits(word, bit, 16u);
    uvec3 octant = (voxel >> (walk.level + 1u)) & 1u;
    uint child = 2u * (walk.level == 1u ? voxel.z & 7u : octant.x | octant.y << 1 | octant.z << 2);
    walk.kind = (mask >> child) & 3u;
    if (walk.kind == INTERSECTED) {
        uint others = mask & ((1u << child) - 1u), pointer_bits = visibility_trees[light].pointer_bits[walk.level];
        uint before = uint(bitCount(others & (others >> 1) & 0x5555u));
        walk.node = node_bits(word, bit + HEADER_BITS + before * pointer_bits, pointer_bits);
        --walk.level;
    }
#ifdef LOOK_UP_STEPS
    ++look_up_steps;
#endif
}

// Returns the 64 bits of a leaf.
uvec2 walk_leaf(uint light, Walk walk) {
    uint word = visibility_trees[light].at[0] + 2u * walk.node;
    return uvec2(visibility_nodes[word], visibility_nodes[word + 1u]);
}
#endif
