#version 460
// Culls the triangle list part by part: the rasterizer draws a part into a map only if the map may see at least one of the part's
// triangles. One thread per triangle; the workgroup's z is the map. Inputs: maps, triangles. Output: draws, whose instance counts are 0
// beforehand. Invariant: a triangle that covers a texel's centre is in a part that is drawn, since the test allows for the rounding of
// corners.
layout(local_size_x = 64) in;
#include "maps/scene.glsl"

// VkDrawIndirectCommand. Twin: maps::OpaqueDraw.
struct OpaqueDraw {
    uint vertex_count;
    uint instance_count;
    uint first_vertex;
    uint first_instance;
};

// set 1: maps_opaque_cull
layout(set = 1, binding = 0, scalar) buffer Draws { OpaqueDraw draws[]; };

layout(push_constant, scalar) uniform CullPush {
    uint triangle_count;
    uint part_triangles;
    uint first_map;  // the map of workgroups at z = 0
};

// Number of parts per map. Twin: maps::OPAQUE_PARTS.
const uint OPAQUE_PARTS = 16u;
// Error bound of a rounded corner, as a fraction of the corner's and the view's coordinates.
const float OPAQUE_ROUNDING = 1e-5;

// False if all corners are on the outer side of one plane that bounds the map's volume.
bool may_see(View view, Triangle triangle) {
    vec3 x, y, z, off;
    for (uint c = 0u; c < 3u; ++c) {
        vec3 offset = triangle.corners[c] - view.origin;
        x[c] = dot(offset, view.right) * view.scale_x;
        y[c] = dot(offset, view.up) * view.scale_y;
        z[c] = dot(offset, view.forward);
        off[c] = OPAQUE_ROUNDING * (dot(abs(triangle.corners[c]) + abs(view.origin), vec3(1.0)) + view.far);
    }
    vec3 off_across = off * max(1.0, max(view.scale_x, view.scale_y));
    vec3 w = (view.projection == VIEW_PARALLEL ? vec3(1.0) : z) + off_across;
    return !(all(lessThan(z + off, vec3(view.near))) || all(greaterThan(z - off, vec3(view.far))) ||
             all(greaterThan(x, w)) || all(lessThan(x, -w)) || all(greaterThan(y, w)) || all(lessThan(y, -w)));
}

void main() {
    uint map = first_map + gl_WorkGroupID.z;
    uint triangle = 64u * (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) + gl_LocalInvocationIndex;
    if (triangle >= triangle_count || !may_see(maps[map].opaque, triangles[triangle])) {
        return;
    }
    uint part = map * OPAQUE_PARTS + triangle / part_triangles;
    if (draws[part].instance_count == 0u) {
        atomicMax(draws[part].instance_count, 1u);
    }
}
