// lighting=vertex in compute passes: the quad of each caster, and the light at the quad's vertices. Twin: shading::painter::vertices.
#ifndef CONSUME_PAINTER_PATCHES_GLSL
#define CONSUME_PAINTER_PATCHES_GLSL
#extension GL_EXT_scalar_block_layout : require

struct Patch {
    vec4 corners;  // NDC, low then high
    uint first;    // index of its first vertex; vertices are stored row by row
    uint parts;    // number of parts along x in the lower 16 bits, along y in the upper ones; 0 if the vertices do not fit
};
#endif
