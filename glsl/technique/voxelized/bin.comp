#version 460
// Counts the triangles that may overlap each bin of columns, or lists them. One thread per triangle; triangles that overlap many bins go
// into a separate list, and in the variants with LARGE one workgroup processes each of them. Source: ours. Inputs: projected. Outputs:
// values from bins_at or placed_at on, the list of large triangles, entries. Twin: reference::twin::voxelized::columns, which has no bins.
// Entries of a bin come in any order: later passes do not depend on it.
// variants: STEP 0 1 2 3
#define PLACE (STEP >= 2)
#define LARGE (STEP == 1 || STEP == 3)
layout(local_size_x = 64) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/projected.glsl"
#include "technique/voxelized/facet.glsl"
#include "technique/voxelized/moves.glsl"

// Adds triangle `i` to a bin, which is the same square of columns as a block.
void meet(uint i, uint bin) {
    if (!block_moves(bin)) {
        return;
    }
    uint place = atomicAdd(values[(PLACE ? placed_at : bins_at) + bin], 1u);
    if (PLACE) {
        place += before(bins_at + bin);
        if (place < entry_capacity) {
            bin_entries[large_capacity + place] = i;
        }
    }
}

void main() {
    ivec2 first, end;
    uint across = bins_across();
    if (LARGE) {
        for (uint l = build_group(); l < min(large, large_capacity); l += gl_NumWorkGroups.x * gl_NumWorkGroups.y) {
            uint i = bin_entries[l];
            projected_bins(i, first, end);
            uint columns_met = uint(end.x - first.x), met = columns_met * uint(end.y - first.y);
            for (uint b = gl_LocalInvocationIndex; b < met; b += 64u) {
                uvec2 at_bin = uvec2(first) + uvec2(b % columns_met, b / columns_met);
                Facet facet;
                // The bounding box of a long, slanted triangle is nearly empty, so the triangle itself is tested, against the bin's block.
                if (facet_at(i, uvec2(tile_x, tile_y) + BIN_COLUMNS * at_bin, CONSERVATIVE, facet)) {
                    meet(i, at_bin.y * across + at_bin.x);
                }
            }
        }
        return;
    }
    uint i = 64u * build_group() + gl_LocalInvocationIndex;
    if (i >= triangle_count + min(pieces, piece_capacity)) {
        return;
    }
    projected_bins(i, first, end);
    if (uint((end.x - first.x) * (end.y - first.y)) > MANY_BINS) {
        if (!PLACE) {
            uint l = atomicAdd(large, 1u);
            if (l < large_capacity) {
                bin_entries[l] = i;
            }
        }
        return;
    }
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            meet(i, uint(y) * across + uint(x));
        }
    }
}
