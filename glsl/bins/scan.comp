#version 460
// Where each tile's entries begin: the exclusive prefix sum of the counts. One workgroup, a run of tiles a thread.
// Inputs: counts. Outputs: offsets, cursors (a copy that scatter advances), the total, the number of tiles in use.
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x = 256) in;

layout(set = 1, binding = 0, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 1, binding = 1, scalar) writeonly buffer Offsets { uint offsets[]; };
layout(set = 1, binding = 2, scalar) writeonly buffer Cursors { uint cursors[]; };
layout(set = 1, binding = 3, scalar) buffer Totals {
    uint entry_total;
    uint culled;
    uint tiles_used;
};

layout(push_constant, scalar) uniform Push { uint tile_total; };

shared uint sums[256];
shared uint used[256];

void main() {
    uint thread = gl_LocalInvocationID.x;
    uint run = (tile_total + 255u) / 256u;
    uint begin = min(thread * run, tile_total), end = min(begin + run, tile_total);
    uint sum = 0u, in_use = 0u;
    for (uint i = begin; i < end; ++i) {
        sum += counts[i];
        in_use += uint(counts[i] > 0u);
    }
    sums[thread] = sum;
    used[thread] = in_use;
    barrier();
    for (uint step = 1u; step < 256u; step <<= 1u) {
        uint left = thread >= step ? sums[thread - step] : 0u;
        uint left_used = thread >= step ? used[thread - step] : 0u;
        barrier();
        sums[thread] += left;
        used[thread] += left_used;
        barrier();
    }
    uint offset = sums[thread] - sum;
    for (uint i = begin; i < end; ++i) {
        offsets[i] = offset;
        cursors[i] = offset;
        offset += counts[i];
    }
    if (thread == 255u) {
        entry_total = sums[thread];
        tiles_used = used[thread];
    }
}
