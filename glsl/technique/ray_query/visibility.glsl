// Ray query look-up: how much of light `light` reaches `position`, 0 to 1. The result is 0 if a mesh blocks the ray, else the transmittance
// of all smoke and hair along it. The ray visits their boxes in any order. Source: VK_KHR_ray_query. Rounding may put a surface point on
// either side of its surface, and a ray almost parallel to the surface may hit it again at any distance. A triangle is therefore ignored if
// the point is within the rounding error of its plane, however far along the ray the hit is: flat surfaces do not shadow themselves at any
// angle. Hits closer to the point than that error are ignored as well.
//
//   binding 0  lights (world/light.glsl)
//   binding 1  acceleration structure, one instance of all triangles; primitive indices are triangle indices
//   binding 2  triangles (world/triangle.glsl)
//   binding 3  the largest absolute coordinate of the meshes
//   binding 4  acceleration structure, one instance of the boxes around all casters, or any if MEDIA is false; primitive indices are caster
//              indices
//   binding 5  casters (world/caster.glsl)
// With HITS_RANDOM, a caster that is hit ends the ray at random, with the probability that it absorbs the light: a result is 0 or 1, and
// the mean of many is the transmittance. The order of hits does not matter, since a caster's index decides. Sources: Enderton et al. 2010
// (random ends); O'Neill 2014 (PCG), Jarzynski and Olano 2020 (the hash). Twin: reference::twin::ray_query.
// flat: bindings 32, constants 64: MEDIA STRANDS SPLATS_OR_CELLS HITS_RANDOM ALPHA_FIRST SHEETS
#extension GL_EXT_ray_query : require
#include "world/colors.glsl"
#include "world/cast_depth.glsl"
#include "world/light.glsl"
#include "world/triangle.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1) uniform accelerationStructureEXT visibility_meshes;
layout(set = GOBO_SET, binding = 2, scalar) readonly buffer VisibilityTriangles { Triangle visibility_triangles[]; };
layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityExtent { float visibility_extent; };
layout(set = GOBO_SET, binding = 4) uniform accelerationStructureEXT visibility_boxes;
layout(set = GOBO_SET, binding = 5, scalar) readonly buffer VisibilityCasters { Caster visibility_casters[]; };

#define ALPHA_TRIANGLES visibility_triangles
#include "world/alpha.glsl"
#include "world/sheet.glsl"

// Whether there is smoke or hair.
CONSTANT(bool, MEDIA, false)
// Whether a caster that is hit ends the ray at random.
CONSTANT(bool, HITS_RANDOM, false)

// Set by a shader that dithers: numbers from 0 to 1 that change the random numbers; below 0, these depend only on the point that is looked
// up.
#define TECHNIQUE_DITHERS
vec3 look_up_dither = vec3(-1.0);

// Error bound of the rounded point, as a share of its largest coordinate: about thirty times a single float rounding, since the caller's
// arithmetic also rounds.
const float POINT_ROUNDING = 2e-6;

bool passes_by(Triangle triangle, vec3 position, float rounding) {
    return abs(dot(triangle_normal(triangle), position - triangle.corners[0])) <= rounding;
}

bool mesh_between(vec3 position, vec3 direction, float end, float rounding) {
    rayQueryEXT query;
    // Not opaque: each candidate triangle is tested here.
    const uint flags = gl_RayFlagsTerminateOnFirstHitEXT | gl_RayFlagsNoOpaqueEXT;
    rayQueryInitializeEXT(query, visibility_meshes, flags, 0xffu, position, rounding, direction, end);
    while (rayQueryProceedEXT(query)) {
        int met = rayQueryGetIntersectionPrimitiveIndexEXT(query, false);
        vec2 at = rayQueryGetIntersectionBarycentricsEXT(query, false);
        if (!passes_by(visibility_triangles[met], position, rounding) && alpha_blocks(uint(met), at)) {
            rayQueryConfirmIntersectionEXT(query);
        }
    }
    return rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
}

uint hit_hash(uint bits) {
    uint state = bits * 747796405u + 2891336453u;
    uint word = (state >> ((state >> 28) + 4u) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

// Returns a seed from the point, the light and the shader's dither.
uint hit_seed(uint light, vec3 position) {
    uvec3 bits = floatBitsToUint(position), dither = floatBitsToUint(look_up_dither);
    uint seed = hit_hash(bits.x ^ hit_hash(bits.y ^ hit_hash(bits.z ^ hit_hash(light))));
    return hit_hash(seed ^ dither.x ^ hit_hash(dither.y ^ hit_hash(dither.z)));
}

// Returns whether a caster of this optical depth ends the ray: a share of exp(-optical_depth) of all rays passes. The caster's own index
// decides.
bool hit_ends(uint seed, uint caster, float optical_depth) {
    precise float share = (float(hit_hash(seed ^ hit_hash(caster)) >> 9) + 0.5) / 8388608.0;
    return share >= exp(-optical_depth);
}

// Confirms no box, so that the ray continues to the next one.
float media_left(vec3 position, vec3 direction, float end, uint light) {
    Ray ray = Ray(position, direction);
    float ray_length = length(direction), sum = 0.0;
    uint seed = HITS_RANDOM ? hit_seed(light, position) : 0u;
    rayQueryEXT query;
    rayQueryInitializeEXT(query, visibility_boxes, gl_RayFlagsNoOpaqueEXT, 0xffu, position, 0.0, direction, end);
    while (rayQueryProceedEXT(query)) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        float entry;
        int met = rayQueryGetIntersectionPrimitiveIndexEXT(query, false);
        float optical_depth = cast_depth(ray, ray_length, visibility_casters[met], end, entry);
        if (!HITS_RANDOM) {
            sum += optical_depth;
        } else if (optical_depth > 0.0 && hit_ends(seed, uint(met), optical_depth)) {
            return 0.0;
        }
    }
    return exp(-sum);
}

float light_visibility(uint light, vec3 position) {
    look_up_meshes = 1.0;
    Light l = visibility_lights[light];
    vec3 far = abs(position), direction = light_direction(l, position);
    float rounding = POINT_ROUNDING * max(visibility_extent, max(far.x, max(far.y, far.z)));
    float end = l.kind == LIGHT_DIRECTIONAL ? FARTHEST : distance(l.position, position);
    if (l.has_opaque != 0u && end > rounding && mesh_between(position, direction, end, rounding)) {
        look_up_meshes = 0.0;
        return 0.0;
    }
    return MEDIA ? media_left(position, direction, end, light) : 1.0;
}
