#version 460
// Orders sorted casters at the same distance by their values, so that the order in which they are listed does not matter: one thread per
// place finds the run of equal distances around it, and counts the casters of the run that come before its own. Longer runs keep the order
// of their indices. Inputs: casters, sorted. Output: order. Twin: reference::twin::far_to_near.
#include "shading/far_to_near.glsl"

layout(local_size_x = 64) in;

// set 0: far_to_near_ties
layout(set = 0, binding = 0, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Sorted { uint sorted[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Order { uint order[]; };

// Length of the longest run that is ordered. Twin: LONGEST_RUN.
const uint LONGEST_RUN = 256u;

void main() {
    uint at = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (at >= count) {
        return;
    }
    uint mine = sorted[at], start = at, end = at + 1u;
    Caster caster = casters[mine];
    uint key = far_to_near(caster);
    while (start > 0u && end - start <= LONGEST_RUN && far_to_near(casters[sorted[start - 1u]]) == key) {
        --start;
    }
    while (end < count && end - start <= LONGEST_RUN && far_to_near(casters[sorted[end]]) == key) {
        ++end;
    }
    uint place = at;
    if (end - start > 1u && end - start <= LONGEST_RUN) {
        place = start;
        for (uint i = start; i < end; ++i) {
            Caster other = casters[sorted[i]];
            bool is_before = caster_after(caster, other) || i < at && !caster_after(other, caster);
            place += uint(is_before);
        }
    }
    order[place] = mine;
}
