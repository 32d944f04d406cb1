#version 460
// Writes a reflective shadow map, which holds the triangle that the light sees: position, normal and flux follow from it
// (lights/indirect/patch.glsl). Source: Dachsbacher and Stamminger 2005, whose maps store these directly. Inputs: the triangle,
// the place. Output: the triangle's index plus 1; 0 if there is none. Holes and see-through triangles are left out.
#include "maps/scene.glsl"
#define ALPHA_TRIANGLES triangles
#include "world/alpha.glsl"

layout(location = 0) flat in uint triangle;
layout(location = 1) in vec3 place;
layout(location = 0) out uint seen;

void main() {
    if (alpha_number(triangle) != 0u && !alpha_blocks(triangle, alpha_weights(triangles[triangle].corners, place))) {
        discard;
    }
    seen = triangle + 1u;
}
