// A tree of a light: where its voxels are and where its nodes stand. Source: Sintorn et al. 2014, Kämpe et al. 2016.
// Twin: technique::voxelized::TreeData.
#ifndef TECHNIQUE_VOXELIZED_TREE_GLSL
#define TECHNIQUE_VOXELIZED_TREE_GLSL
#extension GL_EXT_scalar_block_layout : require

// The kind of a child, two bits of its parent's mask.
const uint LIT = 1u;
const uint SHADOWED = 2u;
const uint INTERSECTED = 3u;

// Levels are leaves, bricks, and nodes of up to 65,536 voxels per side: 15. The voxels of a directional light are a cube: a position's
// offset from the corner, along right, up and forward, is its place among them. The voxels of a light with a place are a pyramid with the
// light at its tip, and all of its columns have the same number of voxels. In a pyramid, the offset from the light along right and up,
// divided by the offset along forward, is the column, counted from the middle column.
struct Tree {
    vec3 origin;   // the corner of the cube, or the light
    uint size;     // voxels per side
    vec3 right;    // voxels per world unit along x, y and z of the cube; light travels along z
    uint levels;   // the root's level, plus 1
    vec3 up;
    uint root;     // LIT, SHADOWED, or INTERSECTED where there are nodes
    vec3 forward;
    uint root_at;  // the root, as pointers say it
    uint shortcuts;  // where the words of the cells begin
    uint at[15];            // where each level's nodes begin, words
    uint pointer_bits[15];  // bits of their pointers
    uint perspective;  // 1 for a pyramid
    uint first;        // of the light that has this tree's number: its first tree,
    uint faces;        // and how many: 1, or one for each face of a cube; 0 where there is no such light
};

// Bits of a node before its pointers, and of the units that pointers count: a graph is packed, a tree is of whole words.
CONSTANT(uint, HEADER_BITS, 16u)

// Whether a triangle that touches a column's square anywhere shadows it; else only one that covers its middle.
CONSTANT(bool, CONSERVATIVE, false)

// A look-up does not begin at the root but at a cell of a coarse grid. A cell is one word: its kind, two bits, and its node, coded as in
// pointers. The cells are as large as the nodes of one level of the tree, and there are at most 2^SHORTCUT_BITS cells per side.
const uint SHORTCUT_BITS = 4u;

// Bits of the shortcut into a tree with so many levels; a cell is no leaf.
uint shortcut_bits(uint levels) { return min(SHORTCUT_BITS, levels - 2u); }

// Which cell a voxel is in.
uint shortcut_of(uint levels, uvec3 voxel) {
    uint bits = shortcut_bits(levels);
    uvec3 cell = voxel >> (levels + 1u - bits);
    return cell.x | (cell.y | cell.z << bits) << bits;
}
#endif
