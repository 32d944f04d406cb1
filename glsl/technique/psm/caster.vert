#version 460
// Emits a point per caster, which voxelize.geom expands into quads. Outputs: caster index, instance.

layout(location = 0) flat out uint point_caster;
layout(location = 1) flat out uint point_instance;

void main() {
    point_caster = gl_VertexIndex;
    point_instance = gl_InstanceIndex;
    gl_Position = vec4(0.0, 0.0, 0.5, 1.0);
    gl_PointSize = 1.0;
}
