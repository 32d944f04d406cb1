#version 460
// Draws casters into their slices; this shader builds the quads and chooses the layer (route=geometry). Source: Bavoil and Jansen 2013,
// Step 2. Inputs: maps, casters. Outputs: position, layer, viewport, the caster in the view's axes. Invariant: draws the same bytes as
// voxelize.vert.
#include "maps/scene.glsl"
#include "technique/psm/push.glsl"
#include "technique/psm/quad.glsl"

layout(points) in;
layout(triangle_strip, max_vertices = 12) out;

layout(location = 0) flat in uint point_caster[];
layout(location = 1) flat in uint point_instance[];
layout(location = 0) flat out vec4 ball;
layout(location = 1) flat out vec4 rest;
layout(location = 2) flat out vec4 shares;
layout(location = 3) flat out uint instance;

// The strip's corners, as indices for quad_corner.
const uint STRIP[4] = uint[](0u, 1u, 5u, 2u);

void main() {
    uint map = drawn_map(point_instance[0]);
    View view = maps[map].caster_view;
    Caster caster = casters[map_casters(map) + point_caster[0]], in_axes = view_caster(view, caster);
    for (uint index = 0u; index < quad_count(); ++index) {
        Quad quad;
        if (!caster_quad(view, map, caster, index, quad)) {
            continue;
        }
        for (uint i = 0u; i < 4u; ++i) {
            ball = vec4(in_axes.position, in_axes.radius);
            rest = vec4(in_axes.axis, in_axes.density);
            instance = point_instance[0];
            shares = quad.shares;
            gl_Position = quad_corner(quad, STRIP[i]);
            gl_Layer = int(quad.layer);
            gl_ViewportIndex = int(quad.viewport);
            EmitVertex();
        }
        EndPrimitive();
    }
}
