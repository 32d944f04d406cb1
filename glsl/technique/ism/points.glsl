// Points on the meshes, SUBSETS times as many as a light takes: `points` per subset, stratified by area, subset by subset.
// Twins: technique::PointData, reference::twin::ism::points.
#ifndef TECHNIQUE_ISM_POINTS_GLSL
#define TECHNIQUE_ISM_POINTS_GLSL
#extension GL_EXT_scalar_block_layout : require

struct IsmPoint {
    vec3 position;
    uint normal;  // see unpack_normal; the lowest bit is set if the mesh is closed and the normal points outwards
};

// Totals over all points. Twin: technique::PointsData.
struct IsmPoints {
    float scale;   // weight per unit of area: a power of two
    uint total;    // weight of all triangles
    float radius;  // radius of the disc that a point represents, world units
    float area;    // area of all triangles
};

const uint SUBSETS = 16u;

// Number of consecutive strata for which a light uses the same subset, so that neighbouring threads read neighbouring points.
const uint RUN = 32u;

// Source: Jarzynski and Olano 2020, Hash functions for GPU rendering: pcg.
uint ism_hash(uint value) {
    uint state = value * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// Returns the index of the point that a light takes from a stratum; each light mixes the subsets in its own way.
uint point_of(uint light, uint stratum, uint points) {
    uint subset = ism_hash(ism_hash(light) + stratum / RUN) % SUBSETS;
    return subset * points + stratum;
}

// Octahedral encoding of a normal, in 15 and 16 bits. Source: Cigolle et al. 2014.
const float NORMAL_X = 32767.0;
const float NORMAL_Y = 65535.0;

uint pack_normal(vec3 normal, bool closed) {
    vec2 folded = normal.xy / (abs(normal.x) + abs(normal.y) + abs(normal.z));
    if (normal.z < 0.0) {
        vec2 sides = vec2(folded.x >= 0.0 ? 1.0 : -1.0, folded.y >= 0.0 ? 1.0 : -1.0);
        folded = (1.0 - abs(folded.yx)) * sides;
    }
    uvec2 codes = uvec2(round(clamp(folded * 0.5 + 0.5, 0.0, 1.0) * vec2(NORMAL_X, NORMAL_Y)));
    return codes.x << 17u | codes.y << 1u | uint(closed);
}

vec3 unpack_normal(uint code) {
    precise vec2 folded = vec2(code >> 17u, code >> 1u & 0xffffu) / vec2(NORMAL_X, NORMAL_Y) * 2.0 - 1.0;
    precise vec3 normal = vec3(folded, 1.0 - abs(folded.x) - abs(folded.y));
    if (normal.z < 0.0) {
        vec2 sides = vec2(folded.x >= 0.0 ? 1.0 : -1.0, folded.y >= 0.0 ? 1.0 : -1.0);
        normal.xy = (1.0 - abs(folded.yx)) * sides;
    }
    return normalize(normal);
}

bool point_closed(uint code) { return (code & 1u) != 0u; }
#endif
