// Which block a candidate stands in. Twin: reference::twin::voxelized, which goes through the blocks.
#ifndef TECHNIQUE_VOXELIZED_FIND_GLSL
#define TECHNIQUE_VOXELIZED_FIND_GLSL

// Finds the block in which a node stands, of `blocks` blocks whose counts begin at `region`, and which of the block's
// nodes it is.
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
