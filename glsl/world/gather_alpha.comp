#version 460
// Writes the alpha of triangles from the caller's buffers, one thread per triangle, and copies the texture's alpha. A triangle with an
// invalid vertex index, or with a place in the texture that is not finite, blocks nothing. Source: ours. Inputs: the buffers of vertices,
// indices and texels. Output: what follows the triangles (glsl/world/alpha.glsl). Twin: world::alpha::words.
layout(local_size_x = 64) in;
#include "world/gather.glsl"

layout(push_constant, scalar) uniform AlphaPush {
    uint slots;     // the buffer's capacity in triangles
    uint most;      // largest number of the caller's triangles to read
    uint start;     // word of the first vertex
    uint stride;
    uint vertices;    // number of vertices
    uint indices_at;  // word of the first index; NOWHERE: no indices, every three vertices are a triangle
    uint uv;          // word of a vertex's place in the texture, from the vertex's start
    uint factor;      // word of a vertex's factor; NOWHERE: `factor_is` for all
    float factor_is;
    float cutoff;
    uint texels_at;    // word of the caller's first texels
    uint texel_words;  // 0 without a texture
    uint size;         // of the texture, as in Alpha
};

// set 0: gather_alpha
layout(set = 0, binding = 0, scalar) readonly buffer GatherVertices { uint theirs[]; };
layout(set = 0, binding = 1, scalar) readonly buffer GatherIndices { uint indices[]; };
layout(set = 0, binding = 2, scalar) readonly buffer GatherTexels { uint texels[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer GatherTriangles { uint triangles[]; };

const uint WORDS = 12u;
// ALPHA_SEE_THROUGH in glsl/world/alpha.glsl.
const float SEE_THROUGH = 2.0;

void main() {
    uint i = 64u * (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) + gl_LocalInvocationIndex;
    uint numbers = WORDS * slots, records = numbers + (slots + WORDS - 1u) / WORDS * WORDS, texels_to = records + WORDS * slots;
    uint threads = 64u * gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    for (uint word = i; word < texel_words; word += threads) {
        triangles[texels_to + word] = texels[texels_at + word];
    }
    if (i >= slots) {
        return;
    }
    if (i >= most || vertices == 0u) {
        triangles[numbers + i] = 0u;
        return;
    }
    bool stands = true;
    uint record = records + WORDS * i;
    for (uint c = 0u; c < 3u; ++c) {
        uint vertex = indices_at == NOWHERE ? 3u * i + c : indices[indices_at + 3u * i + c];
        stands = stands && vertex < vertices;
        uint at = start + (vertex < vertices ? vertex : 0u) * stride;
        uvec2 place = texel_words == 0u ? uvec2(0u) : uvec2(theirs[at + uv], theirs[at + uv + 1u]);
        stands = stands && is_finite(uvec3(place, 0u));
        triangles[record + 2u * c] = place.x;
        triangles[record + 2u * c + 1u] = place.y;
        triangles[record + 6u + c] = factor == NOWHERE ? floatBitsToUint(factor_is) : theirs[at + factor];
    }
    triangles[record + 9u] = floatBitsToUint(stands ? cutoff : SEE_THROUGH);
    triangles[record + 10u] = texel_words == 0u ? 0u : texels_to;
    triangles[record + 11u] = size;
    triangles[numbers + i] = i + 1u;
}
