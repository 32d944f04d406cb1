// A light's tree: where its voxels are, and where its nodes are stored. Source: Sintorn et al. 2014, Kämpe et al. 2016.
// Twin: technique::voxelized::TreeData.
#ifndef TECHNIQUE_VOXELIZED_TREE_GLSL
#define TECHNIQUE_VOXELIZED_TREE_GLSL
#extension GL_EXT_scalar_block_layout : require

// Kind of a child, two bits in its parent's mask.
const uint LIT = 1u;
const uint SHADOWED = 2u;
const uint INTERSECTED = 3u;

// There are at most 15 levels: leaves, bricks, and nodes of up to 65,536 voxels per side. The voxels of a directional light form a cube: a
// position's offset from the corner, along right, up and forward, gives its voxel. The voxels of a light with a position form a pyramid
// with the light at its tip, whose columns all have the same number of voxels. In a pyramid, the offset from the light along right and up,
// divided by the offset along forward, is the column, counted from the middle column.
struct Tree {
    vec3 origin;   // the corner of the cube, or the light
    uint size;     // voxels per side
    vec3 right;    // voxels per world unit along x, y and z of the cube; light travels along z
    uint levels;   // the root's level, plus 1
    vec3 up;
    uint root;     // LIT, SHADOWED, or INTERSECTED if there are nodes
    vec3 forward;
    uint root_at;  // the root, encoded like a pointer
    uint shortcuts;  // where the cells' words begin
    uint at[15];            // where each level's nodes begin, in words
    uint pointer_bits[15];  // bits per pointer of each level
    uint perspective;  // 1 for a pyramid
    uint first;        // of the light with the same index as this tree: its first tree,
    uint faces;        // and the number of its trees: 1, or one per face of a cube; 0 if there is no such light
};

// Number of bits in a node's header, and in the unit that pointers count in: a graph is packed, a tree consists of whole words.
CONSTANT(uint, HEADER_BITS, 16u)

// Whether a triangle that touches a column's square anywhere shadows the column; else only one that covers its centre does.
CONSTANT(bool, CONSERVATIVE, false)

// A look-up begins not at the root but at a cell of a coarse grid. A cell is one word: two bits for its kind, and its node, encoded as in
// pointers. The cells are as large as the nodes of one level of the tree, and there are at most 2^SHORTCUT_BITS cells per side.
const uint SHORTCUT_BITS = 4u;

// Returns the bits of the shortcut into a tree with `levels` levels; a cell is never a leaf.
uint shortcut_bits(uint levels) { return min(SHORTCUT_BITS, levels - 2u); }

// Returns the cell that contains a voxel.
uint shortcut_of(uint levels, uvec3 voxel) {
    uint bits = shortcut_bits(levels);
    uvec3 cell = voxel >> (levels + 1u - bits);
    return cell.x | (cell.y | cell.z << bits) << bits;
}
#endif
