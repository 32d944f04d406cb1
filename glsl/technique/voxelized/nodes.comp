#version 460
// Builds nodes. A node is a mask with the kind of each of its eight children, and the indices of those children that have children of their
// own or are leaves. The children of a brick are its eight slices of 8 × 8 voxels; the children of any other node are its octants. One
// thread per node. Source: Kämpe et al. 2016. Inputs: ranges, values, slots and table of the level below. Output: candidates, nine words
// each. Twin: reference::twin::voxelized::node.
layout(local_size_x = 64) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/find.glsl"

// Returns the index under which a node of the level below is kept.
uint kept(uint child) {
    uint slot = slots[child_slots_at + child];
    return MERGE ? table[child_table_at + slot] - 1u : slot;
}

void main() {
    uint node = 64u * build_group() + gl_LocalInvocationIndex;
    if (node >= levels[level].candidates) {
        return;
    }
    uvec2 found = find_block(at, width * width, node);
    uint side = level_side(level), child_side = level == 1u ? 1u : side / 2u;
    uint z = ranges[at + found.x].x / side + found.y;
    uvec2 block = uvec2(found.x % width, found.x / width);
    uint mask = 0u, pointers = 0u, place = NODE_WORDS * node;
    for (uint c = 0u; c < 8u; ++c) {
        uint child = found.x, child_z = 8u * z + c, child_region = at;
        if (level > 1u) {
            child = (2u * block.y + (c >> 1 & 1u)) * 2u * width + 2u * block.x + (c & 1u);
            child_z = 2u * z + (c >> 2);
            child_region = child_at;
        }
        uvec2 range = ranges[child_region + child];
        uint kind = INTERSECTED;
        // A child may lie both in front of every exit and behind every entry, so that its voxels may count as either lit or shadowed. It
        // becomes SHADOWED, which makes a few more nodes equal, so that they merge.
        if (child_z * child_side >= range.y) {
            kind = SHADOWED;
        } else if ((child_z + 1u) * child_side <= range.x) {
            kind = LIT;
        } else {
            uint number = child_stride > 0u ? child * child_stride : before(child_at + child) - before(child_at);
            candidates[place + 1u + pointers] = kept(number + child_z - range.x / child_side);
            ++pointers;
        }
        mask |= kind << (2u * c);
    }
    candidates[place] = mask;
    for (uint p = pointers; p < 8u; ++p) {
        candidates[place + 1u + p] = 0u;
    }
}
