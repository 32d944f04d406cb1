// Finds the block of a candidate. Twin: reference::twin::voxelized, which loops over the blocks.
#ifndef TECHNIQUE_VOXELIZED_FIND_GLSL
#define TECHNIQUE_VOXELIZED_FIND_GLSL

// Returns the block of a node, among `blocks` blocks whose counts begin at `region`, and the node's index within that block.
uvec2 find_block(uint region, uint blocks, uint node) {
    uint start = before(region), low = 0u, high = blocks;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (before(region + middle) - start <= node) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return uvec2(low, node - (before(region + low) - start));
}
#endif
