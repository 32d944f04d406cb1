// Stores a triangle's depth or index at each texel that it covers. SEEN 0: the least depth of an opaque map. Other values: in the camera's
// view, the index of the nearest triangle and its z; among triangles at the same z the smallest index. SEEN 1: both, in a 64-bit atomic.
// Without 64-bit atomics triangles are drawn twice: SEEN 2 finds each pixel's least z, SEEN 3 the index. Twin: reference::twin::opaque.
#ifndef MAPS_OPAQUE_STORE_GLSL
#define MAPS_OPAQUE_STORE_GLSL
#include "maps/stored.glsl"

// set 2: maps_seen
#if SEEN == 1
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
// The same buffer as below, two words at once.
layout(set = 2, binding = 1, scalar) buffer SeenPairs { uint64_t seen_pairs[]; };
#elif SEEN > 1
// Index of each pixel's triangle, then its z as float bits, which compare like z.
layout(set = 2, binding = 0, scalar) buffer SeenWords { uint seen_words[]; };
#endif

// Stores a triangle that covers a texel at z.
void store(View view, Ray ray, ivec2 texel, float z, uint number) {
#if SEEN == 0
    float depth = stored_depth(view, ray, z);
    if (depth < 1.0) {
        imageAtomicMin(depths, texel, floatBitsToUint(max(depth, 0.0)));
    }
#else
    uint pixel = uint(texel.y) * view.width + uint(texel.x), bits = floatBitsToUint(z);
    if (z < view.far) {
#if SEEN == 1
        atomicMin(seen_pairs[pixel], packUint2x32(uvec2(number, bits)));
#elif SEEN == 2
        atomicMin(seen_words[2u * pixel + 1u], bits);
#else
        if (seen_words[2u * pixel + 1u] == bits) {
            atomicMin(seen_words[2u * pixel], number);
        }
#endif
    }
#endif
}
#endif
