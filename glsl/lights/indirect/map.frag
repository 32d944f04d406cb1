#version 460
// A reflective shadow map holds which triangle the light sees: position, normal and flux follow from it (lights/indirect/patch.glsl).
// Source: Dachsbacher and Stamminger 2005, where maps store these. Output: the triangle's number plus 1; 0 where there is none.
layout(location = 0) flat in uint triangle;
layout(location = 0) out uint seen;

void main() { seen = triangle + 1u; }
