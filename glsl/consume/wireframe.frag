#version 460
// The lines of the triangles of lighting=vertex, over the picture. Output: premultiplied colour, blended over.
layout(location = 0) out vec4 color;

void main() { color = vec4(vec3(0.0), 0.5); }
