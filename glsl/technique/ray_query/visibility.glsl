// Ray query look-up: 1 where no mesh stands between `position` and light `light`, else 0. Source: VK_KHR_ray_query.
// A point comes rounded, and lies on either side of the surface that it is meant to lie on; how far along its ray it meets
// that surface again has no bound when the ray is nearly in the surface. So a triangle whose plane passes the point as
// closely as it may have been rounded does not count, at whatever distance the ray meets it: what is flat does not shadow
// itself at any angle. Nor does what is so near along the ray.
//
//   binding 0  lights (world/light.glsl)
//   binding 1  an instance of all triangles; the index of a primitive is its place in
//   binding 2  triangles (world/triangle.glsl)
//   binding 3  the largest coordinate of the meshes, either sign
// flat: bindings 32, constants 64:
#extension GL_EXT_ray_query : require
#include "world/light.glsl"
#include "world/triangle.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1) uniform accelerationStructureEXT visibility_meshes;
layout(set = GOBO_SET, binding = 2, scalar) readonly buffer VisibilityTriangles { Triangle visibility_triangles[]; };
layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityExtent { float visibility_extent; };

// Of the largest coordinate: some thirty times the rounding of a float, since whoever asks has computed the point.
const float POINT_ROUNDING = 2e-6;

bool passes_by(Triangle triangle, vec3 position, float rounding) {
    return abs(dot(triangle_normal(triangle), position - triangle.corners[0])) <= rounding;
}

float light_visibility(uint light, vec3 position) {
    Light l = visibility_lights[light];
    vec3 far = abs(position);
    float rounding = POINT_ROUNDING * max(visibility_extent, max(far.x, max(far.y, far.z)));
    float end = l.kind == LIGHT_DIRECTIONAL ? FARTHEST : distance(l.position, position);
    if (l.has_opaque == 0u || end <= rounding) {
        return 1.0;
    }
    rayQueryEXT query;
    // Not opaque: each triangle that may be met is looked at here.
    const uint flags = gl_RayFlagsTerminateOnFirstHitEXT | gl_RayFlagsNoOpaqueEXT;
    rayQueryInitializeEXT(query, visibility_meshes, flags, 0xffu, position, rounding, light_direction(l, position), end);
    while (rayQueryProceedEXT(query)) {
        int met = rayQueryGetIntersectionPrimitiveIndexEXT(query, false);
        if (!passes_by(visibility_triangles[met], position, rounding)) {
            rayQueryConfirmIntersectionEXT(query);
        }
    }
    return rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT ? 1.0 : 0.0;
}
