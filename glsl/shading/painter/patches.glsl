// lighting=vertex in compute passes: the quad of each caster, and the light at its vertices. Twin: shading::painter::vertices.
#ifndef CONSUME_PAINTER_PATCHES_GLSL
#define CONSUME_PAINTER_PATCHES_GLSL
#extension GL_EXT_scalar_block_layout : require

struct Patch {
    vec4 corners;  // NDC, low then high
    uint first;    // of its vertices, row by row
    uint parts;    // along x in the lower 16 bits, along y in the upper ones; 0 where vertices have no room
};
#endif
