#version 460
// Writes the depth that is stored of a triangle. Inputs: map, z, the triangle's plane. Output: depth.
#include "maps/scene.glsl"
#include "maps/stored.glsl"

layout(push_constant, scalar) uniform MapPush {
    uint map;
    uvec2 corner;  // where it stands
};

layout(location = 0) in float interpolated_z;
layout(location = 1) flat in vec3 normal;
layout(location = 2) flat in vec2 cut;

void main() {
    View view = maps[map].opaque;
    Ray ray = view_ray(view, gl_FragCoord.xy - vec2(corner));
    // Where a corner is at the eye or behind it, SwiftShader interpolates what it may: the plane has the z too. A sliver's plane is
    // known badly, and its z between those of its corners.
    float z = cut.y > 0.0 ? clamp(cut.x / dot(normal, ray.direction), view.near, cut.y) : interpolated_z;
    gl_FragDepth = stored_depth(view, ray, z);
}
