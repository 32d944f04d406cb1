#version 460
// Draws casters into their slices; this shader chooses the layer (route=vertex). Six vertices a quad, quad_count() quads
// a caster. Source: seed 002, which needs a geometry shader. Inputs: maps, casters. Outputs: position, layer, viewport.
// Invariant: the same bytes as voxelize.geom.
#extension GL_ARB_shader_viewport_layer_array : require
#include "psm/quad.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Casters { Caster casters[]; };

layout(push_constant, scalar) uniform Push { uint map; };

layout(location = 0) flat out uint caster_index;
layout(location = 1) flat out vec4 shares;

void main() {
    uint index = gl_VertexIndex / 6u;
    caster_index = index / quad_count();
    Quad quad;
    bool drawn = caster_quad(maps[map].volume, map, casters[caster_index], index % quad_count(), quad);
    shares = quad.shares;
    gl_Position = drawn ? quad_corner(quad, gl_VertexIndex % 6u) : vec4(2.0, 2.0, 0.5, 1.0);
    gl_Layer = int(quad.layer);
    gl_ViewportIndex = int(quad.viewport);
}
