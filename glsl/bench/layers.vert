#version 460
// Draws one triangle per layer that covers the whole picture. Output: the layer.
layout(location = 0) flat out uint layer;

void main() {
    layer = uint(gl_InstanceIndex);
    gl_Position = vec4(gl_VertexIndex == 1 ? 3.0 : -1.0, gl_VertexIndex == 2 ? 3.0 : -1.0, 0.5, 1.0);
}
