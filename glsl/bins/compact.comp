#version 460
// The casters of each map that meet some tile, in their drawing order, and how many vertices they have. One workgroup a
// map, a run of casters a thread. Inputs: met, order. Outputs: drawn, the draw's command.
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x = 256) in;

layout(set = 0, binding = 5, scalar) readonly buffer Met { uint met[]; };
layout(set = 1, binding = 0, scalar) readonly buffer Order { uint order[]; };
layout(set = 1, binding = 1, scalar) writeonly buffer Drawn { uint drawn[]; };
// VkDrawIndirectCommand: vertices, instances, first vertex, first instance.
layout(set = 1, binding = 2, scalar) writeonly buffer Draws { uint draws[]; };

layout(push_constant, scalar) uniform CompactPush {
    uint caster_count;
    uint capacity;  // of the orders of a map
};

shared uint sums[256];

void main() {
    uint map = gl_WorkGroupID.z, thread = gl_LocalInvocationID.x, met_first = map * caster_count, first = map * capacity;
    uint run = (caster_count + 255u) / 256u;
    uint begin = min(thread * run, caster_count), end = min(begin + run, caster_count);
    uint sum = 0u;
    for (uint i = begin; i < end; ++i) {
        sum += met[met_first + order[first + i]];
    }
    sums[thread] = sum;
    barrier();
    for (uint step = 1u; step < 256u; step <<= 1u) {
        uint left = thread >= step ? sums[thread - step] : 0u;
        barrier();
        sums[thread] += left;
        barrier();
    }
    uint place = first + sums[thread] - sum;
    for (uint i = begin; i < end; ++i) {
        uint caster = order[first + i];
        if (met[met_first + caster] == 1u) {
            drawn[place] = caster;
            ++place;
        }
    }
    if (thread == 255u) {
        draws[4u * map] = 6u * sums[255];
        draws[4u * map + 1u] = 1u;
        draws[4u * map + 2u] = draws[4u * map + 3u] = 0u;
    }
}
