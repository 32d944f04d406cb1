#version 460
// Turns triangles in the caller's buffers into the world's triangles, one thread per triangle. A triangle past the count, or with an
// invalid corner, gets three equal corners, at a corner of another triangle. So it has no area, casts no shadow and does not enlarge any
// bounds. Source: ours. Inputs: the buffers of vertices and indices, the buffer of the count. Outputs: triangles, the counts of triangles.
// Twin: reference::twin::gather::triangles.
layout(local_size_x = 64) in;
#include "world/gather.glsl"

layout(push_constant, scalar) uniform TrianglesPush {
    uint slots;     // number of triangles to write
    uint most;      // largest number of the caller's triangles to read
    uint count_at;  // word of `counts` that holds the count; NOWHERE: `most` is the count
    uint start;     // word of the first vertex
    uint stride;
    uint vertices;    // number of vertices
    uint indices_at;  // word of the first index; NOWHERE: no indices, every three vertices are a triangle
    vec3 albedo;
    vec3 place;  // position for the corners of an invalid triangle if no valid triangle is found
};

// set 0: gather_triangles
layout(set = 0, binding = 0, scalar) readonly buffer GatherVertices { uint theirs[]; };
layout(set = 0, binding = 1, scalar) readonly buffer GatherIndices { uint indices[]; };
layout(set = 0, binding = 2, scalar) readonly buffer GatherCounts { uint counts[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer GatherTriangles { uint triangles[]; };
layout(set = 0, binding = 4, scalar) buffer GatherCounted { GatherTotals counted; };

// Number of consecutive triangles to try in search of a valid one.
const uint TRIES = 16u;
const uint WORDS = 12u;

// Reads the bits of a corner; false if its index is out of range or its position is not finite.
bool corner_at(uint i, out uvec3 bits) {
    uint vertex = indices_at == NOWHERE ? i : indices[indices_at + i];
    bits = uvec3(0u);
    if (vertex >= vertices) {
        return false;
    }
    uint at = start + vertex * stride;
    bits = uvec3(theirs[at], theirs[at + 1u], theirs[at + 2u]);
    return is_finite(bits);
}

bool triangle_at(uint i, out uvec3 corners[3]) {
    bool stands = corner_at(3u * i, corners[0]);
    stands = corner_at(3u * i + 1u, corners[1]) && stands;
    return corner_at(3u * i + 2u, corners[2]) && stands;
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
    uint count = min(asked, most);
    uvec3 corners[3];
    bool stands = i < count && triangle_at(i, corners);
    if (!stands) {
        if (i < count) {
            atomicAdd(counted.refused, 1u);
        }
        bool found = false;
        for (uint t = 0u; t < min(TRIES, count) && !found; ++t) {
            found = triangle_at((i + t) % count, corners);
        }
        uvec3 point = found ? corners[0] : floatBitsToUint(place);
        corners = uvec3[3](point, point, point);
    }
    for (uint c = 0u; c < 3u; ++c) {
        for (uint axis = 0u; axis < 3u; ++axis) {
            triangles[WORDS * i + 3u * c + axis] = corners[c][axis];
        }
    }
    for (uint channel = 0u; channel < 3u; ++channel) {
        triangles[WORDS * i + 9u + channel] = floatBitsToUint(albedo[channel]);
    }
}
