// Normals in 10 bits per coordinate, used to tell surfaces apart. Everything is computed in integers or `precise`, so that the twin finds
// the same edges. Twin: reference::twin::packed_normal.
#ifndef CONSUME_PACKED_NORMAL_GLSL
#define CONSUME_PACKED_NORMAL_GLSL

// Length of a packed normal; and smallest dot product of two packed normals that count as the same surface, 0.9 · NORMAL_UNIT²: they are at
// most 26° apart.
const int NORMAL_UNIT = 511;
const int SAME_NORMAL = 235009;

uint pack_normal(vec3 normal) {
    precise vec3 whole = clamp(floor(normal * float(NORMAL_UNIT) + (float(NORMAL_UNIT) + 0.5)), 0.0, 1022.0);
    return uint(whole.x) | uint(whole.y) << 10 | uint(whole.z) << 20;
}

ivec3 unpack_normal(uint packed) { return (ivec3(packed, packed >> 10, packed >> 20) & 1023) - NORMAL_UNIT; }

bool same_normal(uint a, uint b) {
    ivec3 first = unpack_normal(a), second = unpack_normal(b);
    return first.x * second.x + first.y * second.y + first.z * second.z >= SAME_NORMAL;
}

// The component of a vector along a packed normal, times NORMAL_UNIT.
float along_normal(uint packed, vec3 vector) {
    vec3 normal = vec3(unpack_normal(packed));
    precise float sum = normal.x * vector.x + normal.y * vector.y + normal.z * vector.z;
    return sum;
}
#endif
