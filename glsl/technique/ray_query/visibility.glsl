// Ray query look-up: how much of light `light` reaches `position`, 0 to 1. The answer is 0 where a mesh stands between, else the
// transmittance of all smoke and hair on the way. The ray meets their boxes in any order. Source: VK_KHR_ray_query. A point of a surface is
// rounded to either side of it, and a ray that nearly lies in the surface may meet it again at any distance. So a triangle does not count
// if the point is as near to its plane as rounding may bring it, at whatever distance the ray meets the triangle: flat surfaces do not
// shadow themselves at any angle. Nor do triangles count that the ray meets within that distance.
//
//   binding 0  lights (world/light.glsl)
//   binding 1  acceleration structure, one instance of all triangles; the index of a primitive is its place among the triangles
//   binding 2  triangles (world/triangle.glsl)
//   binding 3  the largest coordinate of the meshes, either sign
//   binding 4  acceleration structure, one instance of the boxes about all casters, or any where MEDIA is false; the index of a
//              primitive is its place among the casters
//   binding 5  casters (world/caster.glsl)
// flat: bindings 32, constants 64: MEDIA STRANDS GAUSSIANS
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

// Whether there is smoke or hair.
CONSTANT(bool, MEDIA, false)

// Rounding of the point, as a share of its largest coordinate: some thirty times that of a float, since the caller has
// computed the point.
const float POINT_ROUNDING = 2e-6;

bool passes_by(Triangle triangle, vec3 position, float rounding) {
    return abs(dot(triangle_normal(triangle), position - triangle.corners[0])) <= rounding;
}

bool mesh_between(vec3 position, vec3 direction, float end, float rounding) {
    rayQueryEXT query;
    // Not opaque: each triangle that may be met is looked at here.
    const uint flags = gl_RayFlagsTerminateOnFirstHitEXT | gl_RayFlagsNoOpaqueEXT;
    rayQueryInitializeEXT(query, visibility_meshes, flags, 0xffu, position, rounding, direction, end);
    while (rayQueryProceedEXT(query)) {
        int met = rayQueryGetIntersectionPrimitiveIndexEXT(query, false);
        if (!passes_by(visibility_triangles[met], position, rounding)) {
            rayQueryConfirmIntersectionEXT(query);
        }
    }
    return rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
}

// No box is confirmed, so that the ray goes on to the next.
float optical_depth_between(vec3 position, vec3 direction, float end) {
    Ray ray = Ray(position, direction);
    float ray_length = length(direction), sum = 0.0;
    rayQueryEXT query;
    rayQueryInitializeEXT(query, visibility_boxes, gl_RayFlagsNoOpaqueEXT, 0xffu, position, 0.0, direction, end);
    while (rayQueryProceedEXT(query)) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        float entry;
        int met = rayQueryGetIntersectionPrimitiveIndexEXT(query, false);
        sum += cast_depth(ray, ray_length, visibility_casters[met], end, entry);
    }
    return sum;
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
    return MEDIA ? exp(-optical_depth_between(position, direction, end)) : 1.0;
}
