// Shared by the passes that gather casters, triangles and lights from the caller's buffers. Twin: reference::twin::gather.
#ifndef WORLD_GATHER_GLSL
#define WORLD_GATHER_GLSL
#extension GL_EXT_scalar_block_layout : require

// Marks an absent word of a buffer.
const uint NOWHERE = 0xFFFFFFFFu;

// Counts of elements. Twin: GatherTotals in src/world/gather.rs.
struct GatherTotals {
    uint asked;    // number of elements according to the caller's count
    uint refused;  // number of elements within the capacity whose position or size is invalid
};

// Numbers are tested and copied as bits, since a device may flush small floats to 0.
bool is_finite(uvec3 bits) { return all(notEqual(bits & 0x7F800000u, uvec3(0x7F800000u))); }

bool is_positive(uint bits) { return bits - 1u < 0x7F7FFFFFu; }

// Negative zero passes.
bool is_not_negative(uint bits) { return bits < 0x7F800000u || bits == 0x80000000u; }
#endif
