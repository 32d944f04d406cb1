#version 460
// lighting=vertex, first of four stages: a caster is a patch of one vertex, far to near. Inputs: order. Output: caster.
#extension GL_EXT_scalar_block_layout : require

#include "shading/picture_set.glsl"
PICTURE_ORDER

layout(location = 0) out uint caster_index;

void main() { caster_index = order[gl_VertexIndex]; }
