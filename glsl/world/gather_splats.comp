#version 460
// Turns splats in the caller's buffer into casters, packed as in scene::Splat, in f32; one thread per splat. Elements past the count, and
// elements whose position, size, axes or opacity is invalid in any scene, become casters of radius 0, which cast no shadow. Source:
// docs/notebook/splats.md. Inputs: the buffer of the splats, the buffer of their count. Outputs: casters from `first` on, the counts of
// splats. Twin: reference::twin::gather::splats.
layout(local_size_x = 64) in;
#include "world/gather_set.glsl"
#include "world/caster.glsl"

layout(push_constant, scalar) uniform SplatsPush {
    uint first;
    uint slots;     // number of casters to write
    uint most;      // largest number of the caller's splats to read
    uint count_at;  // word of `counts` that holds the count; NOWHERE: `most` is the count
    uint start;     // word of the first splat
    uint stride;
    uint position;  // offset within a splat, in words
    uint deviations;
    uint rotation;
    uint opacity;  // NOWHERE: all have the opacity opacity_is
    float opacity_is;
};

// −ln(1 − o), at most 80; a series for small opacities, where 1 − o would round them away.
float depth_of(float o) {
    float little = o * (1.0 + o * (1.0 / 2.0 + o * (1.0 / 3.0 + o * (1.0 / 4.0))));
    return o < 0.03 ? little : o < 1.0 ? min(-log(1.0 - o), MAX_OPTICAL_DEPTH) : MAX_OPTICAL_DEPTH;
}

// Base-2 logarithm of the ratio of the longest deviation to `other`, in 4095ths of SPLAT_OCTAVES.
uint octaves_of(float longest, float other) {
    return uint(clamp(log2(longest / other) * (4095.0 / SPLAT_OCTAVES), 0.0, 4095.0) + 0.5);
}

// Unit axis vectors of a quaternion of length 1.
mat3 axes_of(vec4 q) {
    vec3 two = q.xyz + q.xyz, square = q.xyz * two, by = q.w * two;
    float xy = q.x * two.y, xz = q.x * two.z, yz = q.y * two.z;
    return mat3(1.0 - (square.y + square.z), xy + by.z, xz - by.y, xy - by.z, 1.0 - (square.x + square.z), yz + by.x,
                xz + by.y, yz - by.x, 1.0 - (square.x + square.y));
}

void main() {
    uint i = 64u * (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) + gl_LocalInvocationIndex;
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
        uvec3 place = three(at + position), sizes = three(at + deviations), turn = three(at + rotation);
        uint last = theirs[at + rotation + 3u];
        uint share = opacity == NOWHERE ? floatBitsToUint(opacity_is) : theirs[at + opacity];
        vec4 q = uintBitsToFloat(uvec4(turn, last));
        float square = dot(q, q);
        bool stands = is_finite(place) && is_positive(sizes.x) && is_positive(sizes.y) && is_positive(sizes.z) &&
                      is_finite(turn) && is_finite(uvec3(last)) && is_positive(floatBitsToUint(square)) &&
                      is_not_negative(share) && uintBitsToFloat(share) <= 1.0;
        if (stands) {
            mat3 axes = axes_of(q * inversesqrt(square));
            vec3 sigma = uintBitsToFloat(sizes);
            // Orders the axes from the longest to the shortest; axes of equal length keep their order.
            uint longest = sigma.y > sigma.x ? (sigma.z > sigma.y ? 2u : 1u) : (sigma.z > sigma.x ? 2u : 0u);
            uint shortest = sigma.z <= sigma.y ? (sigma.z <= sigma.x ? 2u : 0u) : (sigma.y <= sigma.x ? 1u : 0u);
            uint middle = 3u - longest - shortest;
            uint short_by = octaves_of(sigma[longest], sigma[shortest]);
            uint octaves = octaves_of(sigma[longest], sigma[middle]) | short_by << 12u;
            uvec3 bytes = uvec3(octaves, octaves >> 8u, octaves >> 16u) & 255u;
            uvec3 axis = splat_packed(axes[shortest], axes[longest]);
            float radius = SPLAT_REACH * sigma[longest];
            float thick = radius * (1.0 / SPLAT_REACH) * exp2(float(short_by) * (-SPLAT_OCTAVES / 4095.0));
            float extinction = depth_of(uintBitsToFloat(share)) / (ROOT_TWO_PI * thick);
            low = uvec4(place, floatBitsToUint(radius));
            high = uvec4((bytes & 128u) << 24u | SPLAT_MARK | (bytes & 127u) << 16u | axis, floatBitsToUint(extinction));
            stands = is_finite(uvec3(low.w, high.w, 0u));
        }
        if (!stands) {
            low = high = uvec4(0u);
            atomicAdd(counted.refused, 1u);
        }
    }
    casters[2u * (first + i)] = low;
    casters[2u * (first + i) + 1u] = high;
}
