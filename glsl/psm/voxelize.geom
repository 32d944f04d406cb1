#version 460
// Draws casters into their slices; this shader makes the quads and chooses the layer (route=geometry). Source: Bavoil and
// Jansen 2013, Step 2. Inputs: maps, casters. Outputs: position, layer, viewport. Invariant: the same bytes as voxelize.vert.
#include "maps/scene.glsl"
#include "psm/push.glsl"
#include "psm/quad.glsl"

layout(points) in;
layout(triangle_strip, max_vertices = 12) out;

layout(location = 0) flat in uint point_caster[];
layout(location = 1) flat in uint point_instance[];
layout(location = 0) flat out uint caster_index;
layout(location = 1) flat out vec4 shares;
layout(location = 2) flat out uint instance;

// The strip's corners among the six of quad_corner.
const uint STRIP[4] = uint[](0u, 1u, 5u, 2u);

void main() {
    uint map = drawn_map(point_instance[0]);
    for (uint index = 0u; index < quad_count(); ++index) {
        Quad quad;
        if (!caster_quad(maps[map].volume, map, casters[point_caster[0]], index, quad)) {
            continue;
        }
        for (uint i = 0u; i < 4u; ++i) {
            caster_index = point_caster[0];
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
