#version 460
// Multiplies a caster's transmittance into the light's buffer. Source: Kniss et al. 2003; Green 2008. Skipping casters behind meshes is
// ours. Inputs: maps, casters, the opaque map. Output: transmittance. Twin: reference::twin::half_angle::light. Invariant: order affects
// only the rounding of the blending, and primitives blend in drawing order.
#define QUADS_FRAGMENT
#include "maps/opaque.glsl"
#include "maps/caster_quads.glsl"

layout(location = 0) out float transmittance;

// Whether casters behind the first mesh on a texel's ray are skipped. The buffer can then light surfaces, since light that reaches a
// surface has passed no caster behind that surface.
CONSTANT(bool, ENDS_AT_MESHES, false)

// Returns where a texel's ray in the volume view hits the first mesh, as a depth in that view's range. Both views have the same rays.
float mesh_depth(View view) {
    View opaque = maps[map].opaque;
    Ray ray = view_ray(view, vec2(quad_texel(view)) + 0.5);
    ivec2 texel = ivec2(clamp(floor(view_project(opaque, ray.origin + ray.direction).xy), vec2(-1.0),
                              vec2(opaque.width, opaque.height)));
    float depth = view_has(opaque, texel) ? texelFetch(opaque_map, opaque_corner(opaque, map, opaque_map) + texel, 0).r
                                          : 1.0;
    float z = opaque.near + depth * (opaque.far - opaque.near) + dot(opaque.origin - view.origin, view.forward);
    return depth < 1.0 ? view_depth(view, z) : FARTHEST;
}

void main() {
    View view = maps[map].caster_view;
    vec2 depth;
    float optical_depth;
    if (!quad_segment(view, depth, optical_depth)) {
        discard;
    }
    float end = ENDS_AT_MESHES ? mesh_depth(view) : FARTHEST;
    if (depth.x >= end) {
        discard;
    }
    // Share of a sphere's segment in front of the mesh.
    float share = depth.y > end ? (end - depth.x) / (depth.y - depth.x) : 1.0;
    transmittance = exp(-optical_depth * share);
}
