#version 460
// Where each column of voxels enters the first thing and leaves it, the least exit and the greatest entry of each block of 8 × 8
// columns, and where each column's shadow begins. A column enters at its nearest surface. If that is the outside of something
// closed, it leaves where as many faces have been left as entered, so that closed things that overlap are one; between the two
// voxels are free. One workgroup a block, one thread a column. Source: Sintorn et al. 2014 (closed objects), Scandolo et al. 2016
// (counting faces). Inputs: projected, entries. Outputs: boundaries, ranges, values (nodes of each block), columns.
// Twin: reference::twin::voxelized::columns. Invariant: entry <= boundary <= exit.
layout(local_size_x = 64) in;
#include "voxelized/build.glsl"
#include "voxelized/projected.glsl"
#include "voxelized/facet.glsl"
#include "world/view.glsl"

// Where a free boundary is put: EXIT, ENTRY or SHARED.
CONSTANT(uint, FREE, 2u)
const uint FREE_EXIT = 0u;
const uint FREE_SHARED = 2u;

// Whether closed things have insides.
CONSTANT(bool, CLOSED, true)

// Whether entries and exits are written down too.
CONSTANT(bool, KEEP_COLUMNS, false)

shared Facet facets[64];
shared uint facet_count;
shared uint busy;
shared uint least;
shared uint most;

// The number in [low, high] with the most trailing zeros.
uint roundest(uint low, uint high) {
    if (low == 0u) {
        return 0u;
    }
    // High bits that the two have in common, then high's first one that low has not.
    uint differ = (low - 1u) ^ high;
    return high & ~((1u << findMSB(differ)) - 1u);
}

void main() {
    uint block = build_group(), thread = gl_LocalInvocationIndex;
    if (block >= width * width) {
        return;
    }
    uvec2 block_at = uvec2(block % width, block / width);
    uvec2 corner = uvec2(tile_x, tile_y) + 8u * block_at;
    ivec2 column = ivec2(thread & 7u, thread >> 3);
    uint bin = (8u * block_at.y / BIN_COLUMNS) * bins_across() + 8u * block_at.x / BIN_COLUMNS;
    uint first = min(before(at + bin), entry_capacity), end = min(before(at + bin + 1u), entry_capacity);

    float nearest = FARTHEST, leaves = FARTHEST;
    int enters = 0, inside = 0;
    bool open = true, searching = true;
    for (uint round = 0u;; ++round) {
        // In the first round the nearest surface, and the nearest back of anything; in each further one whether all that was
        // entered has been left at the back found before, and the next back behind it.
        float next = FARTHEST;
        inside = 0;
        for (uint batch = first; batch < end; batch += 64u) {
            if (thread == 0u) {
                facet_count = 0u;
            }
            barrier();
            Facet facet;
            if (batch + thread < end && facet_at(bin_entries[large_capacity + batch + thread], corner, facet)) {
                facets[atomicAdd(facet_count, 1u)] = facet;
            }
            barrier();
            for (uint f = 0u; f < facet_count && searching; ++f) {
                if (!facet_meets(facets[f], column)) {
                    continue;
                }
                float z = facet_depth(facets[f], column);
                int faces = CLOSED ? facets[f].faces : 0;
                if (round == 0u) {
                    enters = z < nearest ? faces : z == nearest ? max(enters, faces) : enters;
                    nearest = min(nearest, z);
                    next = faces < 0 ? min(next, z) : next;
                } else {
                    inside += z <= leaves ? faces : 0;
                    next = faces < 0 && z > leaves ? min(next, z) : next;
                }
            }
            barrier();
        }
        // Left where it was thought to be; else perhaps at the next back, or never: a ground has no back.
        open = round == 0u ? enters <= 0 : open;
        if (searching) {
            bool left = round == 0u ? open : inside <= 0;
            leaves = left ? leaves : next;
            searching = !left && leaves < FARTHEST;
        }
        if (thread == 0u) {
            busy = 0u;
        }
        barrier();
        if (searching) {
            busy = 1u;
        }
        barrier();
        if (busy == 0u) {
            break;
        }
    }
    // What is entered in a voxel is lit in all of it, and what is left in a voxel is behind it: where the thing is thick
    // enough for both, nothing is rounded.
    float size = float(trees[light].size);
    float middle = clamp(floor(nearest + 0.5), 0.0, size);
    float entry = clamp(ceil(nearest), 0.0, size), exit = clamp(floor(leaves), 0.0, size);
    bool thin = open || exit < entry;
    uvec2 range = nearest == FARTHEST ? uvec2(size) : thin ? uvec2(middle) : uvec2(entry, exit);

    if (thread == 0u) {
        least = 0xffffffffu;
        most = 0u;
    }
    barrier();
    atomicMin(least, range.y);
    atomicMax(most, range.x);
    barrier();
    if (thread == 0u) {
        uvec2 of_block = uvec2(least, most);
        ranges[child_at + block] = of_block;
        values[slots_at + block] = most > least ? most - least : 0u;
        values[child_at + block] = node_range(of_block, 8u).y;
    }
    uint boundary = FREE == FREE_EXIT ? range.y : range.x;
    if (FREE == FREE_SHARED) {
        // As few boundaries as the block's columns allow: the least exit stands for all columns that have entered by then, and
        // so on; each where its z has the most trailing zeros, so that blocks meet at the same ones.
        bool placed = false;
        for (uint placing = 0u; placing < 64u; ++placing) {
            barrier();
            if (thread == 0u) {
                least = 0xffffffffu;
                most = 0u;
            }
            barrier();
            if (!placed) {
                atomicMin(least, range.y);
            }
            barrier();
            uint stop = least;
            if (stop == 0xffffffffu) {
                break;
            }
            bool here = !placed && range.x <= stop;
            if (here) {
                atomicMax(most, range.x);
            }
            barrier();
            boundary = here ? roundest(most, stop) : boundary;
            placed = placed || here;
        }
    }
    uint row = 8u * width;
    uint place = (8u * block_at.y + uint(column.y)) * row + 8u * block_at.x + uint(column.x);
    boundaries[place] = boundary;
    if (KEEP_COLUMNS) {
        columns[place] = range;
    }
}
