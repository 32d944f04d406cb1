#version 460
// Turns particles or strands in the caller's buffer into casters, one thread per caster. Elements past the count, and elements whose
// position, size or extinction is invalid in any scene, become casters of radius 0, which cast no shadow. Source: ours. Inputs: the buffer
// of the elements, the buffer of their count. Outputs: casters from `first` on, the counts of elements.
// Twin: reference::twin::gather::casters.
layout(local_size_x = 64) in;
#include "world/gather_set.glsl"

layout(push_constant, scalar) uniform CastersPush {
    uint first;
    uint slots;     // number of casters to write
    uint most;      // largest number of the caller's elements to read
    uint count_at;  // word of `counts` that holds the count; NOWHERE: `most` is the count
    uint start;     // word of the first element
    uint stride;
    uint position;  // offset within an element, in words
    uint end;       // offset of a strand's end; NOWHERE for spheres
    uint radius;    // NOWHERE: all have the radius radius_is
    float radius_is;
    uint density;
    float density_is;
};

// MAX_OPTICAL_DEPTH of glsl/world/caster.glsl, 80, as the bits of a float.
const uint MOST_DEPTH = 0x42A00000u;

void main() {
    uint i = 64u * (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) + gl_LocalInvocationIndex;
    bool strands = end != NOWHERE;
    uint asked = count_at == NOWHERE ? most : counts[count_at];
    if (i == 0u) {
        counted.asked = asked;
    }
    if (i >= slots) {
        return;
    }
    uvec4 low = uvec4(0u), high = uvec4(0u);
    if (i < min(asked, most)) {
        uint at = start + i * stride;
        uvec3 place = three(at + position);
        uint size = radius == NOWHERE ? floatBitsToUint(radius_is) : theirs[at + radius];
        uint thick = density == NOWHERE ? floatBitsToUint(density_is) : theirs[at + density];
        uvec3 axis = uvec3(0u);
        bool stands = is_finite(place) && is_positive(size) && is_not_negative(thick);
        if (strands) {
            uvec3 tip = three(at + end);
            vec3 between = uintBitsToFloat(tip) - uintBitsToFloat(place);
            axis = floatBitsToUint(between);
            stands = stands && is_finite(tip) && is_finite(axis) && any(notEqual(between, vec3(0.0)));
            thick = thick == 0x80000000u ? thick : min(thick, MOST_DEPTH);
        }
        if (stands) {
            low = uvec4(place, size);
            high = uvec4(axis, thick);
        } else {
            atomicAdd(counted.refused, 1u);
        }
    }
    casters[2u * (first + i)] = low;
    casters[2u * (first + i) + 1u] = high;
}
