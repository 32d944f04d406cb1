#version 460
// Draws casters into their slices; this shader chooses the layer (route=vertex). Six vertices per quad, quad_count() quads per caster.
// Source: Bavoil and Jansen 2013, whose method needs a geometry shader. Inputs: maps, casters. Outputs: position, layer, viewport, the
// caster in the view's axes. Invariant: draws the same bytes as voxelize.geom.
#extension GL_ARB_shader_viewport_layer_array : require
#include "maps/scene.glsl"
#include "technique/psm/push.glsl"
#include "technique/psm/quad.glsl"

layout(location = 0) flat out vec4 ball;
layout(location = 1) flat out vec4 rest;
layout(location = 2) flat out vec4 shares;
layout(location = 3) flat out uint instance;

void main() {
    instance = gl_InstanceIndex;
    uint map = drawn_map(instance);
    uint index = gl_VertexIndex / 6u;
    View view = maps[map].caster_view;
    Caster caster = casters[map_casters(map) + index / quad_count()];
    Quad quad;
    bool drawn = caster_quad(view, map, caster, index % quad_count(), quad);
    // Done once per vertex, not once per fragment.
    caster = view_caster(view, caster);
    ball = vec4(caster.position, caster.radius);
    rest = vec4(caster.axis, caster.density);
    shares = quad.shares;
    gl_Position = drawn ? quad_corner(quad, gl_VertexIndex % 6u) : vec4(2.0, 2.0, 0.5, 1.0);
    gl_Layer = int(quad.layer);
    gl_ViewportIndex = int(quad.viewport);
}
