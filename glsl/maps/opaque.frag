#version 460
// Writes the depth that an opaque map stores for a triangle, except where it has a hole. Inputs: map, z, the triangle and its plane.
// Output: depth.
#include "maps/scene.glsl"
#include "maps/stored.glsl"
#define ALPHA_TRIANGLES triangles
#include "maps/alpha_level.glsl"

layout(push_constant, scalar) uniform MapPush {
    uint map;
    uvec2 corner;  // the map's corner in the image, texels
};

layout(location = 0) in float interpolated_z;
layout(location = 1) flat in vec3 normal;
layout(location = 2) flat in vec2 cut;
layout(location = 3) flat in uint number;
layout(location = 4) flat in uint record;
layout(location = 5) flat in uint level;
layout(location = 6) flat in vec3 plane[3];

void main() {
    View view = maps[map].opaque;
    Ray ray = view_ray(view, gl_FragCoord.xy - vec2(corner));
    // If a corner is at the eye or behind it, SwiftShader may interpolate an arbitrary z, so z is taken from the triangle's plane. A
    // sliver's plane is uncertain, so z is clamped to between the near plane and the farthest corner.
    float z = cut.y > 0.0 ? clamp(cut.x / dot(normal, ray.direction), view.near, cut.y) : interpolated_z;
    if (ALPHA_FIRST != 0u && record != 0u) {
        vec2 at = alpha_weights(AlphaPlane(plane[0], plane[1], plane[2]), ray.origin + z * ray.direction);
        if (!alpha_stands(alpha_at_level(alpha_record(record), level), number, at)) {
            discard;
        }
    }
    gl_FragDepth = stored_depth(view, ray, z);
}
