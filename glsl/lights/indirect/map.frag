#version 460
// Writes a reflective shadow map, which holds the triangle that the light sees: position, normal and flux follow from it
// (lights/indirect/patch.glsl). Source: Dachsbacher and Stamminger 2005, whose maps store these directly. Output: the triangle's index plus
// 1; 0 if there is none.
layout(location = 0) flat in uint triangle;
layout(location = 0) out uint seen;

void main() { seen = triangle + 1u; }
