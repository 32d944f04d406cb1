#version 460
// A point for each caster, of which voxelize.geom makes quads. Output: caster index.

layout(location = 0) flat out uint point_caster;

void main() {
    point_caster = gl_VertexIndex;
    gl_Position = vec4(0.0, 0.0, 0.5, 1.0);
    gl_PointSize = 1.0;
}
